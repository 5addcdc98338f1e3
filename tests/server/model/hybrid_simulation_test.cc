// The exact step against the matrix exponential of the augmented system, in 50 digits.
#include "server/model/hybrid_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/server/model/reference_plant.h"

namespace mwidth::model {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }
  bool OneIn(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

 private:
  std::mt19937_64 random_;
};

LoopParameters RandomLoop(Draw& draw) {
  LoopParameters loop;
  loop.device_mass = draw.LogUniform(1e-3, 1e2);
  loop.device_damping = draw.OneIn(4) ? 0 : draw.LogUniform(1e-4, 1e1);
  loop.hand_mass = draw.OneIn(2) ? 0 : draw.LogUniform(1e-3, 1);
  loop.hand_damping = draw.OneIn(4) ? 0 : draw.LogUniform(1e-2, 3e2);
  loop.hand_stiffness = draw.OneIn(4) ? 0 : draw.LogUniform(1, 3e4);
  loop.period_s = draw.LogUniform(1e-5, 1e-2);
  loop.cutoff_hz = 0.1 / loop.period_s;
  loop.delay_s = draw.OneIn(3) ? 0 : draw.Uniform(0, 3) * loop.period_s;
  return loop;
}

LoopParameters PaperLoop() {
  return {.device_mass = 0.07,
          .device_damping = 0.005,
          .hand_damping = 5,
          .hand_stiffness = 700,
          .period_s = 1e-3,
          .cutoff_hz = 10};
}

TEST(HybridSimulation, StepsLikeTheMatrixExponentialIn50Digits) {
  Draw draw(2012);
  for (int i = 0; i < 60; ++i) {
    const LoopParameters loop = RandomLoop(draw);
    HybridSimulation simulation(loop);
    ReferencePlant reference(loop);
    // A force that moves the device about as far as the hand does.
    const double mass = loop.device_mass + loop.hand_mass;
    const double force_scale = mass / (loop.period_s * loop.period_s);
    double position_scale = 0;
    double velocity_scale = 0;
    for (int tick = 0; tick < 8; ++tick) {
      const double force = draw.Uniform(-force_scale, force_scale);
      const double hand = draw.Uniform(-1, 1);
      simulation.Command(force);
      reference.Command(force);
      simulation.Advance(hand);
      reference.Advance(hand);
      const auto position = static_cast<double>(reference.state()[0]);
      const auto velocity = static_cast<double>(reference.state()[1]);
      position_scale = std::max({position_scale, std::abs(position), 1.0});
      velocity_scale = std::max({velocity_scale, std::abs(velocity), 1 / loop.period_s});
      // The phase of a fast oscillation is itself only known to a rounding per radian.
      const double radians_per_tick = std::sqrt(loop.hand_stiffness / mass) * loop.period_s;
      const double tolerance = 1e-14 * (1 + radians_per_tick) * (tick + 1);
      EXPECT_NEAR(simulation.position(), position, tolerance * position_scale) << "loop " << i;
      EXPECT_NEAR(simulation.velocity(), velocity, tolerance * velocity_scale) << "loop " << i;
    }
  }
}

TEST(HybridSimulation, ForceActsFromItsDelayOnAndNotBefore) {
  LoopParameters loop = PaperLoop();
  loop.delay_s = 1.25e-3;
  HybridSimulation simulation(loop);
  simulation.Command(1);
  EXPECT_EQ(simulation.Advance(0), 0);
  // From 1.25 ms to 2 ms: the impulse of 1 N pushes 70 g against the positive direction.
  EXPECT_LT(simulation.Advance(0), 0);
  EXPECT_NEAR(simulation.velocity(), -0.75e-3 / 0.07, 0.05 * 0.75e-3 / 0.07);
}

TEST(HybridSimulation, UndelayedForceActsWithinItsTick) {
  HybridSimulation simulation(PaperLoop());
  simulation.Command(1);
  EXPECT_LT(simulation.Advance(0), 0);
}

TEST(HybridSimulation, ResetForgetsForcesOnTheirWay) {
  LoopParameters loop = PaperLoop();
  loop.delay_s = 3e-3;
  HybridSimulation simulation(loop);
  simulation.Command(1);
  simulation.Advance(0);
  simulation.Reset(0.5, 0, 0.5);
  for (int tick = 0; tick < 10; ++tick) {
    EXPECT_EQ(simulation.Advance(0.5), 0.5);
  }
}

TEST(HybridSimulation, SettlesWhereTheSpringBalancesTheForce) {
  HybridSimulation simulation(PaperLoop());
  simulation.Command(7);
  for (int tick = 0; tick < 1000; ++tick) {
    simulation.Advance(0);
  }
  EXPECT_NEAR(simulation.position(), -0.01, 1e-15);
  EXPECT_NEAR(simulation.velocity(), 0, 1e-15);
}

TEST(HybridSimulation, TrailsASteadyHandByTheDeviceDampingAlone) {
  HybridSimulation simulation(PaperLoop());
  for (int tick = 1; tick <= 2000; ++tick) {
    simulation.Advance(tick * 1e-4);
  }
  // b v / k_h: 0.005 N s/m at 0.1 m/s against 700 N/m.
  EXPECT_NEAR(simulation.hand_position() - simulation.position(), 0.005 * 0.1 / 700, 1e-14);
  EXPECT_NEAR(simulation.velocity(), 0.1, 1e-13);
}

TEST(HybridSimulation, MovesUnderADriveAsUnderTheHandThatExertsIt) {
  LoopParameters loop = PaperLoop();
  loop.delay_s = 0.3e-3;
  // Without damping in the hand, a straight way of the hand is a straight drive.
  loop.device_damping = 5.005;
  loop.hand_damping = 0;
  HybridSimulation held(loop);
  HybridSimulation driven(loop);
  Draw draw(3);
  double hand = 0;
  for (int tick = 0; tick < 100; ++tick) {
    const double force = draw.Uniform(-1, 1);
    const double hand_next = hand + draw.Uniform(-0.01, 0.01);
    held.Command(force);
    driven.Command(force);
    held.Advance(hand_next);
    driven.AdvanceUnder(700 * hand, 350 * (hand + hand_next), 700 * hand_next);
    hand = hand_next;
    EXPECT_NEAR(driven.position(), held.position(), 1e-15);
    EXPECT_NEAR(driven.velocity(), held.velocity(), 1e-13);
  }
}

TEST(HybridSimulation, GathersMomentumFromADrive) {
  LoopParameters loop;
  loop.device_mass = 2;
  loop.period_s = 1e-2;
  loop.cutoff_hz = 1;
  HybridSimulation simulation(loop);
  // 3 + 12 y - 6 y^2 N, y the share of the tick; its integral is 7, and the integral of that 3.
  simulation.AdvanceUnder(3, 7.5, 9);
  EXPECT_NEAR(simulation.velocity(), 7 * 1e-2 / 2, 1e-16);
  EXPECT_NEAR(simulation.position(), 3 * 1e-4 / 2, 1e-18);
}

TEST(HybridSimulation, FreeDeviceGlidesStraightOn) {
  LoopParameters loop;
  loop.device_mass = 2;
  loop.period_s = 0.5e-2;
  loop.cutoff_hz = 1;
  HybridSimulation simulation(loop);
  simulation.Reset(1, 3, 0);
  for (int tick = 0; tick < 200; ++tick) {
    simulation.Advance(0);
  }
  EXPECT_NEAR(simulation.position(), 4, 1e-12);
  EXPECT_EQ(simulation.velocity(), 3);
}

}  // namespace
}  // namespace mwidth::model
