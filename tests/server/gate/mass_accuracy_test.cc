#include "server/gate/mass_accuracy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/model/m_width.h"
#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

using testing::HasSubstr;

TEST(MassAccuracy, PredictsAndSimulatesFigure9) {
  const model::LoopParameters loop = PaperAxis().loop;
  const double m = loop.device_mass;
  for (const auto& [mass, error] : {std::pair{3 * m, -0.100}, std::pair{-0.5 * m, 0.160}}) {
    MassAccuracy accuracy = PredictAccuracy(loop, mass, kDefaultBand, 1e-6);
    EXPECT_EQ(accuracy.ideal_mass, m + mass);
    EXPECT_NEAR(accuracy.error.value(), error, 0.002);
    EXPECT_NEAR(accuracy.perceived_mass.value(), (1 + error) * (m + mass), 0.002 * (m + mass));
    EXPECT_FALSE(accuracy.simulated_error.has_value());
    SimulateAccuracy(loop, mass, kDefaultBand, accuracy);
    EXPECT_NEAR(accuracy.simulated_error.value(), error, 0.002);
    EXPECT_NEAR(accuracy.simulated_perceived_mass.value(), (1 + error) * (m + mass), 0.002 * (m + mass));
    EXPECT_EQ(accuracy.unavailable_reason, "");
  }
}

TEST(MassAccuracy, SaysThatAMassIsUnstableInPlaceOfFigures) {
  const model::LoopParameters loop = PaperAxis().loop;
  const double unstable = 1.001 * model::ComputeMWidth(loop).upper.mass;
  MassAccuracy accuracy = PredictAccuracy(loop, unstable, kDefaultBand, 1e-6);
  SimulateAccuracy(loop, unstable, kDefaultBand, accuracy);
  EXPECT_FALSE(accuracy.perceived_mass || accuracy.error || accuracy.force_noise);
  EXPECT_FALSE(accuracy.simulated_perceived_mass || accuracy.simulated_error);
  EXPECT_THAT(accuracy.unavailable_reason, HasSubstr("unstable"));
}

TEST(MassAccuracy, SaysWhyEvenAMassOfZeroIsNotFelt) {
  model::LoopParameters loop = PaperAxis().loop;
  loop.device_damping = 0;
  loop.hand_damping = 0;
  EXPECT_THAT(PredictAccuracy(loop, 0, kDefaultBand, 1e-6).unavailable_reason, HasSubstr("without damping"));
  loop.hand_stiffness = 0;
  const MassAccuracy released = PredictAccuracy(loop, 0.01, kDefaultBand, 1e-6);
  EXPECT_FALSE(released.perceived_mass.has_value());
  EXPECT_THAT(released.unavailable_reason, HasSubstr("neither stiffness nor damping"));
}

TEST(MassAccuracy, HasNoRelativeErrorWhereNothingShouldBeFelt) {
  const model::LoopParameters loop = PaperAxis().loop;
  const MassAccuracy accuracy = PredictAccuracy(loop, -loop.device_mass, kDefaultBand, 1e-6);
  EXPECT_EQ(accuracy.ideal_mass, 0);
  EXPECT_TRUE(accuracy.perceived_mass.has_value());
  EXPECT_FALSE(accuracy.error.has_value());
  EXPECT_THAT(accuracy.unavailable_reason, HasSubstr("add up to 0"));
}

TEST(MassAccuracy, TellsNoNoiseOfAnAccelerometerWhoseCountsAreNotKnown) {
  model::LoopParameters loop = PaperAxis().loop;
  loop.estimator = model::EstimatorKind::kFilteredAccelerometer;
  loop.accelerometer_bandwidth_hz = 100;
  const MassAccuracy unknown = PredictAccuracy(loop, 0.1, kDefaultBand, 1e-6);
  EXPECT_FALSE(unknown.force_noise.has_value());
  EXPECT_TRUE(unknown.perceived_mass.has_value());
  EXPECT_THAT(unknown.unavailable_reason, HasSubstr("no accelerometer"));
  const MassAccuracy known = PredictAccuracy(loop, 0.1, kDefaultBand, 1e-6, 0.01);
  EXPECT_GT(known.force_noise.value(), 0);
  EXPECT_EQ(known.unavailable_reason, "");
}

}  // namespace
}  // namespace mwidth::gate
