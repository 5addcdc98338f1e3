// Friction against what is known of it on paper.
#include "server/model/friction_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

LoopParameters FreeMass() { return {.device_mass = 2, .period_s = 1e-3, .cutoff_hz = 10}; }

TEST(FrictionSimulation, StopsAFreeMassWhenFrictionHasTakenItsMomentum) {
  FrictionSimulation simulation(FreeMass(), 0.8);
  simulation.Reset(1, 0.1, 0);
  const double stop_s = 2 * 0.1 / 0.8;  // m v / F_c = 0.25 s, at the end of a tick
  for (int tick = 1; tick <= 249; ++tick) {
    simulation.Advance(0);
    EXPECT_NEAR(simulation.velocity(), 0.1 - 0.4 * tick * 1e-3, 1e-15);
  }
  EXPECT_GT(simulation.velocity(), 0);
  simulation.Advance(0);
  simulation.Advance(0);
  EXPECT_EQ(simulation.velocity(), 0);
  EXPECT_NEAR(simulation.position(), 1 + 0.1 * stop_s / 2, 1e-14);
}

TEST(FrictionSimulation, StopsInTheMiddleOfATickToRounding) {
  FrictionSimulation simulation(FreeMass(), 0.8);
  simulation.Reset(0, -0.3e-3, 0);  // 0.75 ticks from rest
  simulation.Advance(0);
  EXPECT_EQ(simulation.velocity(), 0);
  EXPECT_NEAR(simulation.position(), -0.3e-3 * 0.75e-3 / 2, 1e-21);
}

TEST(FrictionSimulation, StopsAViscouslyBrakedMassAtTheLogarithmicTime) {
  LoopParameters loop = FreeMass();
  loop.device_damping = 3;
  const double friction = 0.5;
  const double v0 = 0.7;
  const double stop_s = 2.0 / 3 * std::log1p(3 * v0 / friction);
  FrictionSimulation simulation(loop, friction);
  simulation.Reset(0, v0, 0);
  int ticks = 0;
  while (simulation.velocity() != 0 && ticks < 10'000) {
    simulation.Advance(0);
    ++ticks;
  }
  EXPECT_EQ(ticks, std::ceil(stop_s / loop.period_s));
  // Momentum: m v_0 = b x + F_c t.
  EXPECT_NEAR(simulation.position(), (2 * v0 - friction * stop_s) / 3, 1e-14);
}

TEST(FrictionSimulation, SticksWhileTheForceIsAtMostFrictionAndNotBeyond) {
  FrictionSimulation simulation(FreeMass(), 0.8);
  simulation.Reset(3, 0, 0);
  for (const double force : {0.8, -0.8, 0.0, 0.5}) {
    simulation.Command(force);
    simulation.Advance(0);
    EXPECT_EQ(simulation.position(), 3);
    EXPECT_EQ(simulation.velocity(), 0);
  }
  simulation.Command(1);  // F_a acts against the positive direction
  simulation.Advance(0);
  EXPECT_NEAR(simulation.velocity(), -(1 - 0.8) / 2 * 1e-3, 1e-19);
}

TEST(FrictionSimulation, TakesTwiceFrictionOverStiffnessOffEachHalfSwing) {
  LoopParameters loop{.device_mass = 0.5, .hand_stiffness = 200, .period_s = 1e-3, .cutoff_hz = 10};
  const double friction = 0.9;
  const double loss = 2 * friction / 200;
  FrictionSimulation simulation(loop, friction);
  simulation.Reset(0.1, 0, 0);
  double reached = 0.1;
  double rest = 0.1;
  while (std::abs(rest) > friction / 200) {
    rest = -std::copysign(std::abs(rest) - loss, rest);
  }
  for (int tick = 0; tick < 2000; ++tick) {
    simulation.Advance(0);
    reached = std::min(reached, simulation.position());
  }
  // The first turn lies between two samples of a parabola.
  EXPECT_NEAR(reached, -(0.1 - loss), 0.1 * 400 * 0.5e-3 * 0.5e-3 / 2);
  EXPECT_GE(reached, -(0.1 - loss) - 1e-15);
  EXPECT_NEAR(simulation.position(), rest, 1e-15);
  EXPECT_EQ(simulation.velocity(), 0);
}

TEST(FrictionSimulation, CountsHundredsOfSwingsWithinOneTick) {
  // 1e5 rad/s: 318 half swings in 10 ms.
  const LoopParameters loop{.device_mass = 1e-4, .hand_stiffness = 1e6, .period_s = 1e-2, .cutoff_hz = 10};
  const double friction = 5;
  const double loss = 2 * friction / 1e6;
  const double start = 200.3 * loss;
  FrictionSimulation simulation(loop, friction);
  simulation.Reset(start, 0, 0);
  simulation.Advance(0);
  EXPECT_EQ(simulation.velocity(), 0);
  EXPECT_NEAR(simulation.position(), 0.3 * loss, 1e-12 * start);  // after 200 half swings
}

TEST(FrictionSimulation, BreaksLooseWhenTheSpringPullsHarderThanFriction) {
  LoopParameters loop = TableTwo();
  loop.hand_damping = 0;
  loop.device_damping = 0;
  const double friction = 1.4;
  const double hand_velocity = 0.0123;
  const double loose_s = friction / (700 * hand_velocity);
  FrictionSimulation simulation(loop, friction);
  const auto ticks = static_cast<int>(loose_s / loop.period_s);
  for (int tick = 1; tick <= ticks; ++tick) {
    simulation.Advance(tick * loop.period_s * hand_velocity);
    EXPECT_EQ(simulation.position(), 0);
  }
  // From there a ramp of the pull: x = u (t - sin(w t)/w).
  const double omega = 100;
  for (int tick = ticks + 1; tick <= ticks + 60; ++tick) {
    simulation.Advance(tick * loop.period_s * hand_velocity);
    const double t = tick * loop.period_s - loose_s;
    EXPECT_NEAR(simulation.position(), hand_velocity * (t - std::sin(omega * t) / omega), 1e-15);
    EXPECT_NEAR(simulation.velocity(), hand_velocity * (1 - std::cos(omega * t)), 1e-13);
  }
}

TEST(FrictionSimulation, TrailsASteadyHandByDampingAndFriction) {
  FrictionSimulation simulation(TableTwo(), 1.4);
  for (int tick = 1; tick <= 3000; ++tick) {
    simulation.Advance(tick * 1e-4);
  }
  EXPECT_NEAR(simulation.hand_position() - simulation.position(), (1.4 + 0.005 * 0.1) / 700, 1e-14);
  EXPECT_NEAR(simulation.velocity(), 0.1, 1e-13);
}

}  // namespace
}  // namespace mwidth::model
