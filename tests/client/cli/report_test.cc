#include "client/cli/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mwidth::cli {
namespace {

using ::testing::HasSubstr;

v1::AxisInfo Axis(v1::AxisKind kind) {
  v1::AxisInfo axis;
  axis.set_name("elbow");
  axis.set_kind(kind);
  return axis;
}

TEST(MWidthReportTest, ShowsMassesAndRatiosWithNineDigits) {
  v1::GetMWidthResponse response;
  response.mutable_loop()->set_device_mass(0.07);
  response.mutable_loop()->set_period_s(0.001);
  response.mutable_loop()->set_cutoff_hz(10);
  response.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_KALMAN);
  auto& nominal = *response.mutable_m_width()->mutable_nominal();
  nominal.set_min(-1.3981549499 * 0.07);
  nominal.set_max(34.2468304444 * 0.07);
  response.mutable_m_width()->mutable_admitted()->set_min(-1.00000000999 * 0.07);
  const auto text = MWidthReport(response, Axis(v1::AXIS_KIND_LINEAR), {});
  EXPECT_THAT(text, HasSubstr("-1.39815495"));
  EXPECT_THAT(text, HasSubstr("34.2468304"));
  // An admitted edge stays inside, the others are rounded to the nearest.
  EXPECT_THAT(text, HasSubstr("-1 "));
  EXPECT_THAT(text, HasSubstr("1000 Hz; kalman, cut-off 10 Hz; delay 0 ms"));
}

TEST(MWidthReportTest, SaysWhatIsAssumedAndWhichLoopsSetTheEdges) {
  v1::GetMWidthResponse response;
  auto& loop = *response.mutable_loop();
  loop.set_hand_stiffness(700);
  loop.set_hand_damping(5);
  loop.set_delay_s(0.0005);
  auto& m_width = *response.mutable_m_width();
  *m_width.mutable_min_binding() = loop;
  *m_width.mutable_max_binding() = loop;
  EXPECT_THAT(
      MWidthReport(response, Axis(v1::AXIS_KIND_LINEAR), {}),
      HasSubstr(
          "Robust means stable for delay 0 to 0.5 ms.\nThe robust edges are set by the nominal loop.\n"));

  m_width.mutable_min_binding()->set_hand_stiffness(2000);
  m_width.mutable_max_binding()->set_hand_stiffness(0);
  m_width.mutable_max_binding()->set_hand_damping(0);
  v1::HandEnvelope envelope;
  envelope.mutable_stiffness()->set_min(100);
  envelope.mutable_stiffness()->set_max(2000);
  envelope.set_include_released_hand(true);
  EXPECT_THAT(MWidthReport(response, Axis(v1::AXIS_KIND_LINEAR), {.envelope = envelope}),
              HasSubstr("Robust means stable for hand stiffness 100 to 2000 N/m, a released hand, delay 0 to "
                        "0.5 ms.\nThe robust edges "
                        "are set by hand stiffness 2000 N/m (lower) and a released hand (upper).\n"));
}

TEST(StateReportTest, ShowsTheFilterThatRunsAndWhatItIsRobustFor) {
  v1::GetStateResponse response;
  auto& info = *response.add_axes()->mutable_info();
  info = Axis(v1::AXIS_KIND_ROTARY);
  info.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_BUTTERWORTH);
  info.mutable_loop()->set_cutoff_hz(25);
  EXPECT_THAT(StateReport(response), HasSubstr("robust for       this loop alone\n"));
  info.mutable_tolerance()->mutable_mass()->set_min(0.04);
  info.mutable_tolerance()->mutable_mass()->set_max(0.06);
  // A range that holds nothing but the loop's own value says nothing.
  info.mutable_envelope()->mutable_mass();
  const auto text = StateReport(response);
  EXPECT_THAT(text, HasSubstr("filter           butterworth, cut-off 25 Hz\n"));
  EXPECT_THAT(text, HasSubstr("robust for       device mass 0.04 to 0.06 kg m²\n"));
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
