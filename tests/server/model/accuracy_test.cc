#include "server/model/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

// Figure 9: 0.1 to 5 Hz in 60 s.
constexpr MotionBand kFigureNine{};

double Measured(const LoopParameters& loop, double mass, TickInstant instant = TickInstant::kAfterForceStep) {
  const PerceivedMass perceived = MeasurePerceivedMass(loop, mass, kFigureNine, instant);
  EXPECT_EQ(perceived.perception, Perception::kKnown);
  return perceived.error.value();
}

double Predicted(const LoopParameters& loop, double mass,
                 TickInstant instant = TickInstant::kAfterForceStep) {
  const PerceivedMass perceived = PredictPerceivedMass(loop, mass, kFigureNine, instant);
  EXPECT_EQ(perceived.perception, Perception::kKnown);
  return perceived.error.value();
}

TEST(Accuracy, HasTheErrorsOfFigure9) {
  const LoopParameters loop = TableTwo();
  EXPECT_NEAR(Measured(loop, 3 * loop.device_mass), -0.100, 0.002);
  EXPECT_NEAR(Measured(loop, -0.5 * loop.device_mass), 0.160, 0.002);
  EXPECT_NEAR(Predicted(loop, 3 * loop.device_mass), -0.100, 0.002);
  EXPECT_NEAR(Predicted(loop, -0.5 * loop.device_mass), 0.160, 0.002);
}

// What the header says of the other side of the step.
TEST(Accuracy, DependsOnTheSideOfTheForceStep) {
  const LoopParameters loop = TableTwo();
  const double mass = 3 * loop.device_mass;
  EXPECT_NEAR(Measured(loop, mass, TickInstant::kBeforeForceStep), -0.147, 0.002);
  EXPECT_NEAR(Predicted(loop, mass, TickInstant::kBeforeForceStep), -0.147, 0.002);
}

TEST(Accuracy, HasNoSidesWhereTheForceStepsBetweenTicks) {
  LoopParameters loop = TableTwo();
  loop.delay_s = 0.4e-3;
  EXPECT_EQ(Measured(loop, 0.1), Measured(loop, 0.1, TickInstant::kBeforeForceStep));
  EXPECT_EQ(Predicted(loop, 0.1), Predicted(loop, 0.1, TickInstant::kBeforeForceStep));
}

TEST(Accuracy, ImprovesWithTheCutoff) {
  LoopParameters loop = TableTwo();
  for (const double mass_ratio : {3.0, 1.0, -0.5}) {
    double before = std::numeric_limits<double>::infinity();
    for (const double cutoff_hz : {5.0, 10.0, 20.0, 30.0, 40.0}) {
      loop.cutoff_hz = cutoff_hz;
      const double error = std::abs(Measured(loop, mass_ratio * loop.device_mass));
      EXPECT_LT(error, before) << mass_ratio << " " << cutoff_hz;
      before = error;
    }
  }
}

TEST(Accuracy, PredictsWhatIsMeasured) {
  RandomLoops loops(9);
  for (int i = 0; i < 40; ++i) {
    LoopParameters loop = loops.Next();
    // A chirp of a minute resolves no sharper resonance, and a test no shorter period.
    loop.period_s = loops.LogUniform(5e-4, 5e-3);
    loop.cutoff_hz = loops.LogUniform(2, 0.4 / loop.period_s);
    loop.delay_s = i % 2 == 0 ? 0 : loops.Uniform(0, 3) * loop.period_s;
    loop.hand_damping = loops.LogUniform(0.3, 1) * std::sqrt(loop.hand_stiffness * loop.device_mass);
    const MWidth m_width = ComputeMWidth(loop);
    const double mass = loops.Uniform(0.5 * m_width.lower.mass, 0.5 * m_width.upper.mass);
    for (const TickInstant instant : {TickInstant::kBeforeForceStep, TickInstant::kAfterForceStep}) {
      const PerceivedMass predicted = PredictPerceivedMass(loop, mass, kFigureNine, instant);
      const PerceivedMass measured = MeasurePerceivedMass(loop, mass, kFigureNine, instant);
      EXPECT_NEAR(predicted.mass, measured.mass, 0.01 * (loop.device_mass + std::abs(mass))) << "loop " << i;
    }
  }
}

TEST(Accuracy, FindsTheDeviceAloneWhereNothingIsRendered) {
  LoopParameters loop = TableTwo();
  loop.hand_mass = 0.4;
  EXPECT_NEAR(PredictPerceivedMass(loop, 0, kFigureNine).mass, loop.device_mass, 1e-12);
  EXPECT_NEAR(MeasurePerceivedMass(loop, 0, kFigureNine).mass, loop.device_mass, 1e-4);
}

TEST(Accuracy, SaysThatAnUnstablePairIsUnstable) {
  LoopParameters loop = TableTwo();
  const MWidth m_width = ComputeMWidth(loop);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double mass : {1.001 * m_width.lower.mass, 1.001 * m_width.upper.mass, nan}) {
    EXPECT_EQ(PredictPerceivedMass(loop, mass, kFigureNine).perception, Perception::kUnstable);
    EXPECT_EQ(MeasurePerceivedMass(loop, mass, kFigureNine).perception, Perception::kUnstable);
    EXPECT_FALSE(MeasurePerceivedMass(loop, mass, kFigureNine).error);
  }
  loop.device_damping = loop.hand_damping = 0;
  EXPECT_EQ(PredictPerceivedMass(loop, 0.01, kFigureNine).perception, Perception::kUnstable);
}

TEST(Accuracy, StaysFiniteUpToTheEdges) {
  const LoopParameters loop = TableTwo();
  const MWidth m_width = ComputeMWidth(loop);
  for (const double mass : {(1 - 1e-6) * m_width.lower.mass, (1 - 1e-6) * m_width.upper.mass}) {
    EXPECT_TRUE(std::isfinite(PredictPerceivedMass(loop, mass, kFigureNine).error.value()));
    EXPECT_TRUE(std::isfinite(MeasurePerceivedMass(loop, mass, kFigureNine).error.value()));
  }
}

TEST(Accuracy, HasAMassButNoErrorWhereNoMassIsLeft) {
  const LoopParameters loop = TableTwo();
  const PerceivedMass perceived = PredictPerceivedMass(loop, -loop.device_mass, kFigureNine);
  EXPECT_EQ(perceived.perception, Perception::kKnown);
  EXPECT_GT(perceived.mass, 0);
  EXPECT_FALSE(perceived.error);
}

TEST(Accuracy, SaysThatAReleasedHandMovesNothing) {
  LoopParameters loop = TableTwo();
  loop.hand_damping = loop.hand_stiffness = 0;
  EXPECT_EQ(PredictPerceivedMass(loop, 0.1, kFigureNine).perception, Perception::kNotMoved);
  EXPECT_EQ(MeasurePerceivedMass(loop, 0.1, kFigureNine).perception, Perception::kNotMoved);
}

TEST(Accuracy, NamesTheFieldOfABandThatIsNotAllowed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Validate(kFigureNine, 1e-3));
  EXPECT_EQ(Validate({0, 5, 60}, 1e-3)->parameter, "lowest_hz");
  EXPECT_EQ(Validate({nan, 5, 60}, 1e-3)->parameter, "lowest_hz");
  EXPECT_EQ(Validate({0.1, 0.1, 60}, 1e-3)->parameter, "highest_hz");
  EXPECT_EQ(Validate({0.1, 501, 60}, 1e-3)->parameter, "highest_hz");
  EXPECT_EQ(Validate({0.1, 5, 9}, 1e-3)->parameter, "duration_s");
  EXPECT_EQ(Validate({0.1, 5, 10001}, 1e-3)->parameter, "duration_s");
}

TEST(LeastSquaresMass, FitsWhatItIsGiven) {
  LeastSquaresMass fit;
  EXPECT_FALSE(fit.mass());
  fit.Add(1, 2);
  fit.Add(-2, -4.5);
  EXPECT_DOUBLE_EQ(*fit.mass(), (2 + 9) / 5.0);
}

TEST(PredictPerceivedMass, SaysSoWhereRoundingErrorsDrownTheMass) {
  // Damping stops this device a thousand times within a sample period.
  const LoopParameters stuck{.device_mass = 2.2e-6,
                             .device_damping = 1706,
                             .hand_mass = 0,
                             .hand_damping = 2e-9,
                             .hand_stiffness = 117,
                             .period_s = 2.7e-5,
                             .cutoff_hz = 64,
                             .delay_s = 8e-5};
  const PerceivedMass perceived = PredictPerceivedMass(stuck, -1.6e-7, {.lowest_hz = 0.1, .highest_hz = 3});
  EXPECT_EQ(perceived.perception, Perception::kUnresolved);
}

}  // namespace
}  // namespace mwidth::model
