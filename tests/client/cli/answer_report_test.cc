#include "client/cli/answer_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace mwidth::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kMargins =
    "  Margins: gain 2.92 dB (at 3.25 Hz), phase 41.5 deg (at 22 Hz), delay 3 ms or more, modulus 0.25 (at "
    "31 Hz).\n";

v1::AxisInfo Axis(v1::AxisKind kind) {
  v1::AxisInfo axis;
  axis.set_name("elbow");
  axis.set_kind(kind);
  axis.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_FILTERED_DIFFERENCE);
  axis.mutable_loop()->set_cutoff_hz(10);
  return axis;
}

v1::StabilityReport Report(double mass) {
  v1::StabilityReport report;
  report.set_requested_mass(mass);
  report.mutable_m_width()->mutable_admitted()->set_min(-0.05);
  report.mutable_m_width()->mutable_admitted()->set_max(0.35);
  report.mutable_m_width()->set_required_gain_margin_db(3);
  *report.mutable_loop() = Axis(v1::AXIS_KIND_LINEAR).loop();
  auto& margins = *report.mutable_margins();
  margins.set_gain_db(2.923);
  margins.set_gain_hz(3.25);
  margins.set_phase_deg(41.5);
  margins.set_phase_hz(22);
  margins.set_delay_s(0.003);
  margins.set_delay_at_least(true);
  margins.set_modulus(0.25);
  margins.set_modulus_hz(31);
  return report;
}

client::Refusal Refused() {
  auto report = Report(0.8);
  report.set_gain_margin_db(-4);
  report.set_binding("The delay of the loop sets this edge.");
  report.set_nearest_admitted_mass(0.35);
  report.set_admitting_cutoff_hz(4.5);
  return {.sentence = "", .reason = "UNSTABLE_MASS", .stability = report, .status = {}};
}

TEST(AdmissionReportTest, TellsTheMarginsWithTheirFrequencies) {
  v1::SetMassResponse response;
  response.set_mass(-0.04);
  *response.mutable_stability() = Report(-0.04);
  EXPECT_EQ(AdmissionReport(response, Axis(v1::AXIS_KIND_ROTARY), /*validate_only=*/false),
            std::string("Rendering -0.04 kg m² on elbow. Admitted are masses from -0.05 to 0.35 kg m².\n") +
                kMargins);
  EXPECT_THAT(AdmissionReport(response, Axis(v1::AXIS_KIND_ROTARY), /*validate_only=*/true),
              HasSubstr("Would render -0.04 kg m²"));
}

TEST(AdmissionReportTest, AMarginThatNothingUsesUpIsUnlimited) {
  v1::SetMassResponse response;
  auto& margins = *response.mutable_stability()->mutable_margins();
  margins.set_gain_db(std::numeric_limits<double>::infinity());
  margins.set_phase_deg(std::numeric_limits<double>::infinity());
  margins.set_delay_s(std::numeric_limits<double>::infinity());
  margins.set_modulus(1);
  EXPECT_THAT(AdmissionReport(response, Axis(v1::AXIS_KIND_LINEAR), /*validate_only=*/false),
              HasSubstr("Margins: gain unlimited, phase unlimited, delay unlimited, modulus 1.\n"));
}

TEST(RefusalReportTest, SaysWhatWasAskedWhatIsAdmittedAndWhatWouldHelp) {
  EXPECT_EQ(RefusalReport(Refused(), Axis(v1::AXIS_KIND_ROTARY)),
            std::string("Refused: a virtual mass of 0.8 kg m² on elbow would make the loop unstable.\n"
                        "  Admitted are masses from -0.05 to 0.35 kg m²; the nearest is 0.35 kg m².\n"
                        "  A filter cut-off of 4.5 Hz would admit it; it is 10 Hz.\n"
                        "  The upper edge binds. The delay of the loop sets this edge.\n") +
                kMargins);
}

TEST(RefusalReportTest, UnitsFollowTheKindOfTheAxis) {
  const auto text = RefusalReport(Refused(), Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("0.8 kg on elbow"));
  EXPECT_THAT(text, Not(HasSubstr("m²")));
}

TEST(RefusalReportTest, TellsAMarginTooSmallFromAnUnstableLoop) {
  auto refusal = Refused();
  refusal.stability.set_gain_margin_db(1.25);
  refusal.stability.mutable_margins()->set_gain_db(1.25);
  EXPECT_THAT(RefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR)),
              HasSubstr("would leave a gain margin of 1.25 dB, and 3 dB are required"));
}

TEST(RefusalReportTest, TellsAnotherHandFromTheNominalOne) {
  auto refusal = Refused();
  refusal.stability.set_gain_margin_db(5);
  refusal.stability.mutable_margins()->set_gain_db(-1);
  EXPECT_THAT(RefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR)),
              HasSubstr("would not be stable for every hand and device"));
  // The proof is up to 0.5 % short of the worst hand.
  refusal.stability.mutable_margins()->set_gain_db(3.01);
  EXPECT_THAT(RefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR)),
              HasSubstr("is not proved to leave a gain margin of 3 dB for every hand and device"));
}

TEST(RefusalReportTest, ANoisyMassIsNotSaidToBeUnstable) {
  auto refusal = Refused();
  refusal.reason = "NOISY_MASS";
  refusal.stability.set_gain_margin_db(6);
  refusal.stability.set_binding("The encoder's counts put a noise on the force.");
  const auto text = RefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(
      text, HasSubstr("0.8 kg on elbow would be stable, but make the force noisier than the axis allows.\n"));
  EXPECT_THAT(text, HasSubstr("\n  The encoder's counts put a noise on the force.\n"));
  EXPECT_THAT(text, Not(HasSubstr("edge binds")));
}

TEST(RefusalReportTest, SaysWhereNothingHelps) {
  auto refusal = Refused();
  refusal.stability.set_requested_mass(-0.8);
  refusal.stability.clear_admitting_cutoff_hz();
  const auto text = RefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("No lower cut-off of the filter would admit it."));
  EXPECT_THAT(text, HasSubstr("The lower edge binds"));
}

TEST(RefusalReportTest, AnEmptyIntervalComesWithItsReason) {
  auto refusal = Refused();
  auto& admitted = *refusal.stability.mutable_m_width()->mutable_admitted();
  admitted.Clear();
  admitted.set_empty(true);
  admitted.set_empty_reason("nothing takes energy out of this loop");
  const auto text = RefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR));
  EXPECT_THAT(text, HasSubstr("No mass is admitted: nothing takes energy out of this loop.\n"));
  EXPECT_THAT(text, Not(HasSubstr("nearest")));
  EXPECT_THAT(text, Not(HasSubstr("binds")));
}

TEST(FilterReportTest, SaysWhatItIsWhatItWasAndWhatItAdmits) {
  v1::SetFilterResponse response;
  *response.mutable_stability() = Report(0);
  response.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_KALMAN);
  response.mutable_loop()->set_cutoff_hz(20);
  EXPECT_EQ(FilterReport(response, Axis(v1::AXIS_KIND_LINEAR), /*validate_only=*/false),
            "elbow: filter is kalman, cut-off 20 Hz; it was filtered-difference, cut-off 10 Hz.\n"
            "  Admitted are masses from -0.05 to 0.35 kg.\n");
  EXPECT_THAT(FilterReport(response, Axis(v1::AXIS_KIND_LINEAR), /*validate_only=*/true),
              HasSubstr("filter would be kalman, cut-off 20 Hz; it is filtered-difference"));
  *response.mutable_stability() = Report(0.1);
  EXPECT_THAT(FilterReport(response, Axis(v1::AXIS_KIND_LINEAR), /*validate_only=*/false),
              HasSubstr(std::string("  The mass of 0.1 kg on elbow stays.\n") + kMargins));
}

TEST(FilterRefusalReportTest, NamesTheFilterAndTheMassThatIsSet) {
  auto refusal = Refused();
  refusal.stability.mutable_loop()->set_cutoff_hz(100);
  EXPECT_EQ(
      FilterRefusalReport(refusal, Axis(v1::AXIS_KIND_LINEAR)),
      std::string(
          "Refused: with filtered-difference, cut-off 100 Hz, the virtual mass of 0.8 kg on elbow that is "
          "set would make the loop unstable.\n"
          "  Masses admitted with this filter: from -0.05 to 0.35 kg.\n"
          "  The upper edge binds. The delay of the loop sets this edge.\n") +
          kMargins);
}

}  // namespace
}  // namespace mwidth::cli
