#include "server/gate/force_noise_limit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/model/force_noise.h"
#include "server/model/m_width.h"

namespace mwidth::gate {
namespace {

class RandomLoops {
 public:
  model::LoopParameters Next() {
    model::LoopParameters loop{.device_mass = Between(1e-3, 1e2),
                               .device_damping = Between(1e-4, 1e1),
                               .hand_mass = 0,
                               .hand_damping = Between(1e-2, 3e2),
                               .hand_stiffness = Between(1, 3e4),
                               .period_s = Between(1e-4, 1e-2),
                               .cutoff_hz = 0,
                               .delay_s = 0};
    loop.cutoff_hz = Between(0.3, 0.48 / loop.period_s);
    loop.delay_s = Between(1e-3, 3) * loop.period_s;
    return loop;
  }

 private:
  double Between(double min, double max) {
    return min * std::pow(max / min, std::uniform_real_distribution<double>(0, 1)(random_));
  }
  std::mt19937_64 random_{7};
};

TEST(NearestQuietMass, KeepsTheLimitAndGivesNothingAway) {
  RandomLoops loops;
  for (int i = 0; i < 200; ++i) {
    const model::LoopParameters loop = loops.Next();
    const model::MWidth m_width = model::ComputeMWidth(loop);
    for (const double mass : {0.9 * m_width.lower.mass, 0.9 * m_width.upper.mass}) {
      const double noise = model::ForceNoise(loop, mass, 1e-6).value();
      const ForceNoiseLimit limit{.position_quantum = 1e-6, .max_force_noise = 0.3 * noise};
      const double quiet = NearestQuietMass(limit, loop, mass);
      EXPECT_TRUE(Keeps(limit, loop, quiet));
      EXPECT_FALSE(Keeps(limit, loop, quiet * (1 + 1e-7)));
      EXPECT_GT(quiet / mass, 0);
      const ForceNoiseLimit loose{.position_quantum = 1e-6, .max_force_noise = noise};
      EXPECT_EQ(NearestQuietMass(loose, loop, mass), mass);
    }
  }
}

// What the bisection relies on to find the nearest.
TEST(ForceNoise, RisesWithTheMassOnEitherSide) {
  RandomLoops loops;
  for (int i = 0; i < 300; ++i) {
    const model::LoopParameters loop = loops.Next();
    const model::MWidth m_width = model::ComputeMWidth(loop);
    for (const double edge : {m_width.lower.mass, m_width.upper.mass}) {
      double before = 0;
      for (int k = 1; k < 50; ++k) {
        const double noise = model::ForceNoise(loop, edge * k / 50, 1e-6).value();
        EXPECT_GT(noise, before);
        before = noise;
      }
    }
  }
}

TEST(KeepsForceNoiseLimit, IsFalseForAMassThatIsNotStable) {
  RandomLoops loops;
  const model::LoopParameters loop = loops.Next();
  const double unstable = 1.01 * model::ComputeMWidth(loop).upper.mass;
  EXPECT_FALSE(Keeps({.position_quantum = 1e-9, .max_force_noise = 1e9}, loop, unstable));
}

}  // namespace
}  // namespace mwidth::gate
