#include "server/model/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

namespace mwidth::model {
namespace {

using ::testing::HasSubstr;

constexpr LoopParameters kPaper{.device_mass = 0.07,
                                .device_damping = 0.005,
                                .hand_mass = 0,
                                .hand_damping = 5,
                                .hand_stiffness = 700,
                                .period_s = 1e-3,
                                .cutoff_hz = 10,
                                .delay_s = 0};

Sweep Hands() {
  return {.loop = kPaper,
          .x = {.parameter = SweepParameter::kHandDamping, .min = 1, .max = 20, .count = 33},
          .y = SweepRange{.parameter = SweepParameter::kHandStiffness,
                          .min = 10,
                          .max = 5000,
                          .count = 33,
                          .logarithmic = true}};
}

// The parameter that Validate objects to; empty where it does not.
std::string Objection(const Sweep& sweep) {
  const auto error = Validate(sweep);
  return error ? error->parameter : "";
}

TEST(SweepParameter, EachHasItsOwnFieldOfThatName) {
  std::set<std::string> names;
  for (const SweepParameter parameter : kSweepParameters) {
    LoopParameters loop = kPaper;
    loop.estimator = EstimatorKind::kAccelerometer;
    loop.accelerometer_bandwidth_hz = 100;
    SweptField(loop, parameter) = -1;
    // The model's own check of the loop names the same field.
    const auto error = Validate(loop);
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->parameter, SweepParameterName(parameter));
    names.insert(error->parameter);
  }
  EXPECT_EQ(names.size(), kSweepParameters.size());
}

TEST(ValueAt, StepsEvenlyAndEndsExactly) {
  const SweepRange range{.parameter = SweepParameter::kHandMass, .min = 0.1, .max = 0.7, .count = 4};
  EXPECT_EQ(ValueAt(range, 0), 0.1);
  EXPECT_NEAR(ValueAt(range, 1), 0.3, 1e-15);
  EXPECT_NEAR(ValueAt(range, 2), 0.5, 1e-15);
  EXPECT_EQ(ValueAt(range, 3), 0.7);
}

TEST(ValueAt, TakesEqualRatiosWhereLogarithmic) {
  const SweepRange range{
      .parameter = SweepParameter::kHandStiffness, .min = 0.3, .max = 3e4, .count = 6, .logarithmic = true};
  EXPECT_EQ(ValueAt(range, 0), 0.3);
  for (uint32_t i = 1; i < 5; ++i) {
    EXPECT_NEAR(ValueAt(range, i) / ValueAt(range, i - 1), 10, 1e-12);
  }
  EXPECT_EQ(ValueAt(range, 5), 3e4);
}

TEST(ValidateSweep, AcceptsOneAndTwoParameters) {
  Sweep sweep = Hands();
  EXPECT_EQ(Objection(sweep), "");
  sweep.y.reset();
  EXPECT_EQ(Objection(sweep), "");
}

TEST(ValidateSweep, NamesACountOutOfRange) {
  Sweep sweep = Hands();
  sweep.x.count = 1;
  EXPECT_EQ(Objection(sweep), "x.count");
  sweep.x.count = kMaxSweepCount + 1;
  EXPECT_EQ(Objection(sweep), "x.count");
  sweep = Hands();
  sweep.y->count = 0;
  EXPECT_EQ(Objection(sweep), "y.count");
  sweep.x.count = 1001;
  sweep.y->count = 1000;
  EXPECT_EQ(Objection(sweep), "x.count times y.count");
  EXPECT_THAT(Validate(sweep)->Message(), HasSubstr("at most 1000000"));
  sweep.x.count = 1000;
  EXPECT_EQ(Objection(sweep), "");
}

TEST(ValidateSweep, NamesEndsThatAreNoRange) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Sweep sweep = Hands();
    sweep.x.min = bad;
    EXPECT_EQ(Objection(sweep), "x.min");
    sweep = Hands();
    sweep.y->max = bad;
    EXPECT_EQ(Objection(sweep), "y.max");
  }
  Sweep sweep = Hands();
  sweep.x.max = sweep.x.min / 2;
  EXPECT_EQ(Objection(sweep), "x.max");
  sweep = Hands();
  sweep.y->min = 0;
  EXPECT_EQ(Objection(sweep), "y.min");
  sweep.y->logarithmic = false;
  EXPECT_EQ(Objection(sweep), "");
}

TEST(ValidateSweep, NamesAParameterOutOfItsRange) {
  Sweep sweep = Hands();
  sweep.x.min = -1;
  EXPECT_EQ(Objection(sweep), "hand_damping");
  sweep = Hands();
  sweep.y->max = 2e6;
  EXPECT_EQ(Objection(sweep), "hand_stiffness");
  sweep = Hands();
  sweep.loop.device_mass = 0;
  EXPECT_EQ(Objection(sweep), "device_mass");
  sweep = Hands();
  sweep.x = {.parameter = SweepParameter::kCutoffHz, .min = 1, .max = 501, .count = 3};
  EXPECT_EQ(Objection(sweep), "cutoff_hz");
}

TEST(ValidateSweep, RefusesTheSameParameterTwice) {
  Sweep sweep = Hands();
  sweep.y = sweep.x;
  EXPECT_EQ(Objection(sweep), "y.parameter");
}

TEST(ValidateSweep, HoldsCutoffAndDelayAgainstTheSweptPeriodThatAllowsTheMost) {
  Sweep sweep{.loop = kPaper,
              .x = {.parameter = SweepParameter::kPeriodS, .min = 1e-4, .max = 1e-2, .count = 5},
              .y = SweepRange{.parameter = SweepParameter::kCutoffHz, .min = 1, .max = 5000, .count = 3}};
  sweep.loop.delay_s = 0.03;
  EXPECT_EQ(Objection(sweep), "");
  sweep.y->max = 5001;
  EXPECT_EQ(Objection(sweep), "cutoff_hz");
  sweep.y->max = 5000;
  sweep.loop.delay_s = 0.031;
  EXPECT_EQ(Objection(sweep), "delay_s");
  sweep.loop.delay_s = -0.001;
  EXPECT_EQ(Objection(sweep), "delay_s");
  sweep.loop.delay_s = 0;
  sweep.x.min = 9e-6;
  EXPECT_EQ(Objection(sweep), "period_s");
}

}  // namespace
}  // namespace mwidth::model
