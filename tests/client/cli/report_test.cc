#include "client/cli/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mwidth::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

v1::AxisInfo Axis(v1::AxisKind kind) {
  v1::AxisInfo axis;
  axis.set_name("elbow");
  axis.set_kind(kind);
  return axis;
}

v1::StabilityReport Refused() {
  v1::StabilityReport report;
  report.set_requested_mass(0.8);
  report.mutable_m_width()->mutable_admitted()->set_min(-0.05);
  report.mutable_m_width()->mutable_admitted()->set_max(0.35);
  report.mutable_m_width()->set_required_gain_margin_db(3);
  report.mutable_loop()->set_cutoff_hz(10);
  report.set_gain_margin_db(-4);
  report.set_binding("The delay of the loop sets this edge.");
  report.set_nearest_admitted_mass(0.35);
  report.set_admitting_cutoff_hz(4.5);
  return report;
}

TEST(RefusalReportTest, SaysWhatWasAskedWhatIsAdmittedAndWhatWouldHelp) {
  EXPECT_EQ(RefusalReport(Refused(), Axis(v1::AXIS_KIND_ROTARY)),
            "Refused: a virtual mass of 0.8 kg m² on elbow would make the loop unstable.\n"
            "  Admitted are masses from -0.05 to 0.35 kg m²; the nearest is 0.35 kg m².\n"
            "  A filter cut-off of 4.5 Hz would admit it; it is 10 Hz.\n"
            "  The upper edge binds. The delay of the loop sets this "
            "edge.\n");
}

TEST(RefusalReportTest, UnitsFollowTheKindOfTheAxis) {
  const auto text = RefusalReport(Refused(), Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("0.8 kg on elbow"));
  EXPECT_THAT(text, Not(HasSubstr("m²")));
}

TEST(RefusalReportTest, TellsAMarginTooSmallFromAnUnstableLoop) {
  auto report = Refused();
  report.set_gain_margin_db(1.25);
  EXPECT_THAT(RefusalReport(report, Axis(v1::AXIS_KIND_LINEAR)),
              HasSubstr("would leave a gain margin of 1.25 dB, and 3 dB are required"));
  report.set_gain_margin_db(5);
  EXPECT_THAT(RefusalReport(report, Axis(v1::AXIS_KIND_LINEAR)),
              HasSubstr("would not be stable for every hand and device"));
}

TEST(RefusalReportTest, SaysWhereNothingHelps) {
  auto report = Refused();
  report.set_requested_mass(-0.8);
  report.clear_admitting_cutoff_hz();
  const auto text = RefusalReport(report, Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("No cut-off of the filter would admit it."));
  EXPECT_THAT(text, HasSubstr("The lower edge binds"));
}

TEST(RefusalReportTest, AnEmptyIntervalComesWithItsReason) {
  auto report = Refused();
  auto& admitted = *report.mutable_m_width()->mutable_admitted();
  admitted.Clear();
  admitted.set_empty(true);
  admitted.set_empty_reason("nothing takes energy out of this loop");
  const auto text = RefusalReport(report, Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("Admitted are masses none: nothing takes energy out of this loop."));
  EXPECT_THAT(text, Not(HasSubstr("nearest")));
}

TEST(MWidthReportTest, ShowsMassesAndRatiosWithNineDigits) {
  v1::GetMWidthResponse response;
  response.mutable_loop()->set_device_mass(0.07);
  response.mutable_loop()->set_period_s(0.001);
  response.mutable_loop()->set_cutoff_hz(10);
  auto& nominal = *response.mutable_m_width()->mutable_nominal();
  nominal.set_min(-1.3981549499 * 0.07);
  nominal.set_max(34.2468304444 * 0.07);
  response.mutable_m_width()->mutable_admitted()->set_min(-1.00000000999 * 0.07);
  const auto text = MWidthReport(response, Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("-1.39815495"));
  EXPECT_THAT(text, HasSubstr("34.2468304"));
  // An admitted edge stays inside, the others are rounded to the nearest.
  EXPECT_THAT(text, HasSubstr("-1 "));
  EXPECT_THAT(text, HasSubstr("1000 Hz, cut-off 10 Hz, delay 0 ms"));
}

TEST(StateReportTest, NamesTheStateAndTheFault) {
  v1::GetStateResponse response;
  auto& axis = *response.add_axes();
  *axis.mutable_info() = Axis(v1::AXIS_KIND_ROTARY);
  axis.set_state(v1::STATE_FAULT);
  axis.mutable_fault()->set_kind(v1::FAULT_KIND_VELOCITY_LIMIT);
  axis.mutable_fault()->set_tick(12);
  axis.mutable_fault()->set_message("too fast");
  axis.set_mass(0.1);
  axis.set_target_mass(0.2);
  const auto text = StateReport(response);
  EXPECT_THAT(text, HasSubstr("elbow (rotary)\n"));
  EXPECT_THAT(text, HasSubstr("state            fault\n"));
  EXPECT_THAT(text, HasSubstr("velocity limit at tick 12: too fast\n"));
  EXPECT_THAT(text, HasSubstr("controlled by    nobody\n"));
  EXPECT_THAT(text, HasSubstr("0.1 kg m², on its way to 0.2 kg m²\n"));
}

}  // namespace
}  // namespace mwidth::cli
