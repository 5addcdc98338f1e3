#include "server/model/loop_parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

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

struct Field {
  const char* name;
  double LoopParameters::*member;
  double min;
  double max;
};

constexpr std::array<Field, 8> kFields{{{"device_mass", &LoopParameters::device_mass, 1e-6, 1e4},
                                        {"device_damping", &LoopParameters::device_damping, 0, 1e4},
                                        {"hand_mass", &LoopParameters::hand_mass, 0, 1e4},
                                        {"hand_damping", &LoopParameters::hand_damping, 0, 1e4},
                                        {"hand_stiffness", &LoopParameters::hand_stiffness, 0, 1e6},
                                        {"period_s", &LoopParameters::period_s, 1e-5, 1e-2},
                                        {"cutoff_hz", &LoopParameters::cutoff_hz, 1e-300, 500},
                                        {"delay_s", &LoopParameters::delay_s, 0, 3e-3}}};

TEST(Validate, AcceptsThePapersLoop) { EXPECT_FALSE(Validate(kPaper).has_value()); }

TEST(Validate, AcceptsBothEndsOfEveryRange) {
  for (const Field& field : kFields) {
    for (const double value : {field.min, field.max}) {
      LoopParameters loop = kPaper;
      loop.*field.member = value;
      // A period of 10 ms leaves no room for more than 50 Hz; the paper's 10 Hz is fine at every period.
      EXPECT_FALSE(Validate(loop).has_value()) << field.name << " = " << value;
    }
  }
}

TEST(Validate, NamesTheFieldThatIsOutOfRangeOrNotFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Field& field : kFields) {
    for (const double value : {-infinity, -1.0, field.min - 1e-6, field.max * (1 + 1e-9), infinity,
                               std::numeric_limits<double>::quiet_NaN()}) {
      LoopParameters loop = kPaper;
      loop.*field.member = value;
      const auto error = Validate(loop);
      ASSERT_TRUE(error.has_value()) << field.name << " = " << value;
      EXPECT_EQ(error->parameter, field.name);
      EXPECT_TRUE(error->value == value || std::isnan(value));
      EXPECT_THAT(error->Message(), HasSubstr(error->allowed));
    }
  }
}

TEST(Validate, AcceptsThreePeriodsOfDelayHoweverTheyAreRounded) {
  for (int i = 1; i <= 1000; ++i) {
    LoopParameters loop = kPaper;
    loop.period_s = 1e-5 * i;
    loop.delay_s = 3e-5 * i;
    EXPECT_FALSE(Validate(loop).has_value()) << i;
    loop.delay_s = loop.period_s + loop.period_s + loop.period_s;
    EXPECT_FALSE(Validate(loop).has_value()) << i;
  }
}

TEST(ParameterError, SaysInOneSentenceWhatIsWrongAndWhatIsAllowed) {
  LoopParameters loop = kPaper;
  loop.delay_s = 0.004;
  EXPECT_EQ(Validate(loop)->Message(), "delay_s = 0.004 is not allowed: it must be 0 to 3 periods (0.003 s)");
  loop = kPaper;
  loop.cutoff_hz = 501;
  EXPECT_EQ(Validate(loop)->Message(),
            "cutoff_hz = 501 is not allowed: it must be above 0, at most half the sample rate (500 Hz)");
}

TEST(Validate, KnowsEachEstimatorsCutoffs) {
  LoopParameters loop = kPaper;
  loop.cutoff_hz = 500;
  for (const EstimatorKind kind : kEstimatorKinds) {
    loop.estimator = kind;
    EXPECT_EQ(Validate(loop).has_value(), kind == EstimatorKind::kButterworth) << Name(kind);
  }
  loop.estimator = EstimatorKind::kButterworth;
  EXPECT_EQ(Validate(loop)->parameter, "cutoff_hz");
  EXPECT_THAT(Validate(loop)->allowed, HasSubstr("at most 0.49 of the sample rate (490 Hz)"));
  loop.cutoff_hz = 1e-7;
  EXPECT_THAT(Validate(loop)->allowed, HasSubstr("at least 1e-06 Hz"));
}

TEST(Validate, RefusesAnEstimatorThatThereIsNot) {
  LoopParameters loop = kPaper;
  loop.estimator = static_cast<EstimatorKind>(17);
  const auto error = Validate(loop);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->parameter, "estimator");
  EXPECT_EQ(error->value, 17);
  EXPECT_THAT(error->allowed,
              HasSubstr("filtered-difference, late-filtered-difference, butterworth, kalman"));
}

}  // namespace
}  // namespace mwidth::model
