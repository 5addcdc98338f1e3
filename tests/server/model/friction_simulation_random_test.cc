// Friction in random loops: against small steps that know nothing of events, and against what can never be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "server/model/friction_simulation.h"
#include "server/model/hybrid_simulation.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Implicit steps a thousandth of a tick long: velocity and friction are found together, as the zero of a
/// monotone function, so nothing has to be detected.
class SmallSteps {
 public:
  SmallSteps(const LoopParameters& loop, double friction) : loop_(loop), friction_(friction) {}

  void Advance(double force_before, double force_after, double fraction, double hand_next) {
    const double hand_velocity = (hand_next - hand_) / loop_.period_s;
    const double hand_start = hand_;
    const double h = loop_.period_s / kSteps;
    const double mass = loop_.device_mass + loop_.hand_mass;
    for (int i = 1; i <= kSteps; ++i) {
      hand_ = hand_start + hand_velocity * h * i;
      const double force = i <= fraction * kSteps ? force_before : force_after;
      // mass (v - v_before)/h = k (hand - x_before - h v) + b_h hand' - (b + b_h) v - F_a - F_c sign(v).
      const double inertia = mass / h + h * loop_.hand_stiffness + loop_.device_damping + loop_.hand_damping;
      const double push = mass / h * velocity + loop_.hand_stiffness * (hand_ - position) +
                          loop_.hand_damping * hand_velocity - force;
      velocity = std::copysign(std::max(std::abs(push) - friction_, 0.0), push) / inertia;
      position += h * velocity;
    }
    hand_ = hand_next;
  }

  double position = 0;
  double velocity = 0;

 private:
  static constexpr int kSteps = 1000;
  LoopParameters loop_;
  double friction_;
  double hand_ = 0;
};

TEST(FrictionSimulationInRandomLoops, MovesAsSmallStepsDo) {
  std::mt19937_64 random(2012);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int stops = 0;
  for (int i = 0; i < 60; ++i) {
    LoopParameters loop = TableTwo();
    loop.hand_damping = i % 3 == 0 ? 0 : std::exp(uniform(-3, 5));  // swinging to creeping
    loop.hand_stiffness = i % 5 == 0 ? 0 : std::exp(uniform(4, 11));
    loop.hand_mass = i % 2 == 0 ? 0 : 0.05;
    const double fraction = i % 4 == 0 ? 0 : 0.25 * (i % 4);
    loop.delay_s = fraction * loop.period_s;
    const double friction = std::exp(uniform(-3, 1));
    FrictionSimulation simulation(loop, friction);
    SmallSteps steps(loop, friction);
    double hand = 0;
    double force = 0;
    double scale = 1e-6;
    for (int tick = 0; tick < 60; ++tick) {
      const double force_before = force;
      force = friction * uniform(-2, 2);
      hand += uniform(-1, 1) * 1e-3;
      simulation.Command(force);
      simulation.Advance(hand);
      steps.Advance(force_before, force, fraction, hand);
      scale = std::max(scale, std::abs(steps.position));
      stops += simulation.velocity() == 0 ? 1 : 0;
      // First order in the step, 1/1000 of a tick.
      ASSERT_NEAR(simulation.position(), steps.position, 0.01 * scale) << i << ", tick " << tick;
    }
  }
  EXPECT_GT(stops, 100);
}

TEST(FrictionSimulationInRandomLoops, WithVanishingFrictionIsTheSmoothSimulation) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 100; ++i) {
    LoopParameters loop = TableTwo();
    loop.device_mass = std::exp(uniform(-5, 2));
    loop.hand_damping = std::exp(uniform(-4, 5));
    loop.hand_stiffness = std::exp(uniform(0, 10));
    loop.delay_s = uniform(0, 3) * loop.period_s;
    HybridSimulation smooth(loop);
    FrictionSimulation rough(loop, 1e-300);
    double hand = 0;
    double scale = 0;
    for (int tick = 0; tick < 200; ++tick) {
      const double force = uniform(-1, 1);
      hand += uniform(-1, 1) * 1e-3;
      smooth.Command(force);
      rough.Command(force);
      scale = std::max(scale, std::abs(smooth.Advance(hand)));
      rough.Advance(hand);
      ASSERT_NEAR(rough.position(), smooth.position(), 1e-12 * scale) << i << ", tick " << tick;
    }
  }
}

TEST(FrictionSimulationInRandomLoops, NeverGainsEnergyUnderAHandAtRest) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 300; ++i) {
    const auto log_uniform = [&](double low, double high) {
      return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random));
    };
    const LoopParameters loop{.device_mass = log_uniform(1e-4, 1e2),
                              .device_damping = i % 2 == 0 ? 0 : log_uniform(1e-4, 1e3),
                              .hand_stiffness = log_uniform(1, 1e5),
                              .period_s = log_uniform(1e-5, 1e-2),
                              .cutoff_hz = 1};
    FrictionSimulation simulation(loop, log_uniform(1e-6, 1e2));
    simulation.Reset(log_uniform(1e-3, 1), -log_uniform(1e-3, 1), 0);
    double before = kInfinity;
    for (int tick = 0; tick < 200; ++tick) {
      simulation.Advance(0);
      const double energy = loop.device_mass * simulation.velocity() * simulation.velocity() +
                            loop.hand_stiffness * simulation.position() * simulation.position();
      // The phase of a fast swing is known to a rounding per radian, and so is what friction has taken.
      const double radians = std::sqrt(loop.hand_stiffness / loop.device_mass) * loop.period_s;
      ASSERT_LE(energy, before * (1 + 1e-14 * (1 + radians))) << i << ", tick " << tick;
      before = energy;
    }
  }
}

TEST(FrictionSimulationInRandomLoops, GoesOnWhereASlideIsTooShortForItsTimeToCount) {
  // A force that hardly beats friction pushes one way, the hand pulls the other: the slide ends after 1e-120
  // s, in which neither hand nor device moves by a rounding. The pull, unchanged, must not start it again.
  LoopParameters loop = TableTwo();
  loop.device_damping = loop.hand_damping;
  loop.hand_damping = 0;
  const double hand = 1e-4;
  FrictionSimulation rough(loop, 1e-124);
  HybridSimulation smooth(loop);
  rough.Reset(hand, 0, hand);
  smooth.Reset(hand, 0, hand);
  rough.Command(1e-120);
  rough.Advance(hand + 5e-5);
  smooth.Advance(hand + 5e-5);
  EXPECT_NEAR(rough.position(), smooth.position(), 1e-19);
  EXPECT_GT(rough.velocity(), 0);
}

TEST(FrictionSimulationInRandomLoops, EndsItsTickWhateverTheNumbersAndIsAsNewAfterAReset) {
  FrictionSimulation fresh(TableTwo(), 0.5);
  fresh.Reset(0.01, -0.2, 0);
  fresh.Advance(0.001);
  for (const double value : {std::nan(""), kInfinity, -kInfinity, 1e300, 1e-310}) {
    FrictionSimulation simulation(TableTwo(), 0.5);
    simulation.Command(value);
    simulation.Advance(0.01);
    simulation.Advance(value);
    simulation.Reset(0, value, 0);
    simulation.Advance(-0.01);
    simulation.Reset(value, 1, 0);
    for (int tick = 0; tick < 100; ++tick) {
      simulation.Advance(0);
    }
    simulation.Reset(0.01, -0.2, 0);
    simulation.Advance(0.001);
    EXPECT_EQ(simulation.position(), fresh.position());
    EXPECT_EQ(simulation.velocity(), fresh.velocity());
  }
}

}  // namespace
}  // namespace mwidth::model
