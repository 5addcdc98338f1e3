#include "server/gate/mass_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "server/gate/stability_gate.h"
#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(CheckNumbers, NamesTheNumberThatIsNotFinite) {
  for (const double mass : {kNan, kInf, -kInf}) {
    const auto refusal = CheckNumbers({.mass = mass}, PaperAxis());
    ASSERT_TRUE(refusal.has_value());
    EXPECT_EQ(refusal->code, RefusalCode::kInvalidArgument);
    EXPECT_EQ(refusal->reason, kInvalidNumber);
    EXPECT_EQ(refusal->metadata.at("field"), "mass");
  }
}

TEST(CheckNumbers, AllowsARampOfZeroToTenSeconds) {
  for (const double ramp_s : {-1e-9, 10.001, kNan, kInf}) {
    const auto refusal = CheckNumbers({.mass = 0.1, .ramp_s = ramp_s}, PaperAxis());
    ASSERT_TRUE(refusal.has_value()) << ramp_s;
    EXPECT_EQ(refusal->reason, kInvalidNumber);
    EXPECT_EQ(refusal->metadata.at("field"), "ramp");
  }
  EXPECT_FALSE(CheckNumbers({.mass = 0.1, .ramp_s = 0}, PaperAxis()));
  EXPECT_FALSE(CheckNumbers({.mass = 0.1, .ramp_s = 10}, PaperAxis()));
}

TEST(CheckNumbers, IncludesTheHardLimits) {
  for (const double mass : {-50.0, 50.0}) {
    EXPECT_FALSE(CheckNumbers({.mass = mass}, PaperAxis()));
    const auto refusal = CheckNumbers({.mass = 1.001 * mass}, PaperAxis());
    ASSERT_TRUE(refusal.has_value());
    EXPECT_EQ(refusal->code, RefusalCode::kInvalidArgument);
    EXPECT_EQ(refusal->reason, kMassLimit);
    EXPECT_THAT(refusal->message, HasSubstr("ask for -50 to 50 kg"));
  }
}

TEST(InadmissibleMass, TellsAPersonWhatWouldBeAccepted) {
  const AxisDescription axis = PaperAxis();
  const StabilityGate gate(axis.loop, {.gain_margin_db = 3});
  const double mass = 1.2 * gate.range().nominal.max;
  const StabilityReport report = gate.Judge(mass, {.min = -50, .max = 50}, axis.kind);
  const Refusal refusal = InadmissibleMass(report, axis);
  EXPECT_EQ(refusal.code, RefusalCode::kFailedPrecondition);
  EXPECT_EQ(refusal.reason, kUnstableMass);
  EXPECT_THAT(refusal.message, HasSubstr("outside the admitted range of -0.0"));
  EXPECT_THAT(refusal.message, HasSubstr("Ask for " + refusal.metadata.at("nearest_admitted_mass") + " kg"));
  EXPECT_THAT(refusal.message, HasSubstr("cut-off to "));
  ASSERT_TRUE(refusal.stability.has_value());
  EXPECT_EQ(refusal.stability->requested_mass, mass);
  // The number that a person reads, and types, is admitted.
  const double typed = std::stod(refusal.metadata.at("nearest_admitted_mass"));
  EXPECT_TRUE(gate.Judge(typed, {.min = -50, .max = 50}, axis.kind).admitted);
}

TEST(InadmissibleMass, OffersNoCutOffWhereNoneHelps) {
  const AxisDescription axis = PaperAxis();
  StabilityReport report =
      StabilityGate(axis.loop, {.gain_margin_db = 3}).Judge(40, {.min = -50, .max = 50}, axis.kind);
  report.admitting_cutoff_hz.reset();
  EXPECT_THAT(InadmissibleMass(report, axis).message, Not(HasSubstr("cut-off")));
}

TEST(InadmissibleMass, SaysWhyNothingIsAdmitted) {
  AxisDescription axis = PaperAxis();
  axis.loop.device_damping = 0;
  axis.loop.hand_damping = 0;
  const StabilityReport report =
      StabilityGate(axis.loop, {.gain_margin_db = 3}).Judge(0.1, {.min = -50, .max = 50}, axis.kind);
  const Refusal refusal = InadmissibleMass(report, axis);
  EXPECT_EQ(refusal.reason, kUnstableMass);
  EXPECT_THAT(refusal.message, HasSubstr(report.range.admitted.empty_reason));
  EXPECT_THAT(refusal.message, HasSubstr("Only a mass of 0"));
}

TEST(InadmissibleMass, TellsTheNoiseItsLimitAndAMassThatKeepsIt) {
  AxisDescription axis = PaperAxis();
  axis.force_noise_limit = 0.01;
  const StabilityGate gate(axis.loop, axis.Requirements());
  const StabilityReport report = gate.Judge(1.2, {.min = -50, .max = 50}, axis.kind);
  const Refusal refusal = InadmissibleMass(report, axis);
  EXPECT_EQ(refusal.code, RefusalCode::kFailedPrecondition);
  EXPECT_EQ(refusal.reason, kNoisyMass);
  EXPECT_EQ(refusal.metadata.at("force_noise_limit"), "0.01");
  EXPECT_GT(std::stod(refusal.metadata.at("force_noise")), 0.01);
  EXPECT_THAT(refusal.message, HasSubstr(refusal.metadata.at("force_noise") + " N on the force"));
  EXPECT_THAT(refusal.message, HasSubstr("0.01 N are allowed"));
  EXPECT_THAT(refusal.message, HasSubstr("set the filter's cut-off to "));
  const double typed = std::stod(refusal.metadata.at("nearest_admitted_mass"));
  EXPECT_THAT(refusal.message, HasSubstr("Ask for " + refusal.metadata.at("nearest_admitted_mass") + " kg"));
  EXPECT_TRUE(gate.Judge(typed, {.min = -50, .max = 50}, axis.kind).admitted);
}

}  // namespace
}  // namespace mwidth::gate
