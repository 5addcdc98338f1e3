// The end of a slide against a dense look at its velocity.
#include "server/model/slide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

namespace mwidth::model {
namespace {

/// First of many evenly spaced times at which the velocity no longer has the slide's direction.
std::optional<double> LookForStop(const SlidingPlant& plant, const Slide& slide, double time_s, int looks) {
  for (int i = 1; i <= looks; ++i) {
    const double t = time_s * i / looks;
    const PlantResponse at = plant.After(t);
    const double velocity = slide.velocity + slide.acceleration * at.impulse + slide.pull_rate * at.step;
    if (slide.direction * velocity <= 0) {
      return t;
    }
  }
  return std::nullopt;
}

TEST(SlidingPlant, FindsTheFirstStopAndNoOther) {
  std::mt19937_64 random(2012);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr int kLooks = 4000;
  int stops = 0;
  int slides = 0;
  for (int i = 0; i < 1500; ++i) {
    // From a fraction of a swing to several within the time, damped from not at all to heavily.
    const double time_s = 1e-3;
    const double stiffness_rate = i % 7 == 0 ? 0 : std::pow(std::exp(uniform(-4, 3)) / time_s, 2);
    const double critical = 2 * std::sqrt(stiffness_rate);
    const double damping_rate = i % 5 == 0   ? 0
                                : i % 5 == 1 ? critical
                                             : std::exp(uniform(-4, 3)) * std::max(critical, 1.0);
    const SlidingPlant plant(damping_rate, stiffness_rate);
    const double direction = i % 2 == 0 ? 1 : -1;
    const double speed = i % 3 == 0 ? 0 : uniform(0, 1);
    const double push = uniform(i % 3 == 0 ? 0 : -3, 3);
    const Slide slide{.velocity = direction * speed,
                      .acceleration = direction * push / time_s,
                      .pull_rate = uniform(-2, 2) * stiffness_rate,
                      .direction = direction};
    const std::optional<double> found = plant.FindStop(slide, time_s, plant.After(time_s));
    const std::optional<double> seen = LookForStop(plant, slide, time_s, kLooks);
    if (seen) {
      ASSERT_TRUE(found) << i;
      EXPECT_LE(*found, *seen * (1 + 1e-12)) << i;
      EXPECT_GE(*found, *seen - time_s / kLooks * (1 + 1e-9)) << i;
      ++stops;
    } else if (found) {
      // A touch between two looks: the velocity there must be zero all the same.
      const PlantResponse at = plant.After(*found);
      EXPECT_NEAR(slide.velocity + slide.acceleration * at.impulse + slide.pull_rate * at.step, 0, 1e-6) << i;
    } else {
      ++slides;
    }
  }
  EXPECT_GT(stops, 300);
  EXPECT_GT(slides, 300);
}

TEST(SlidingPlant, StopsAFreeMassAtVelocityOverDeceleration) {
  const SlidingPlant plant(0, 0);
  const Slide slide{.velocity = -3, .acceleration = 7, .pull_rate = 0, .direction = -1};
  const std::optional<double> stop = plant.FindStop(slide, 1, plant.After(1));
  ASSERT_TRUE(stop);
  EXPECT_NEAR(*stop, 3.0 / 7, 1e-15);
  EXPECT_FALSE(plant.FindStop(slide, 0.42, plant.After(0.42)));
}

TEST(SlidingPlant, TurnsBackAfterHalfASwing) {
  // v = sin(w t): from rest, out and back.
  const SlidingPlant plant(0, 1e4);
  const Slide slide{.velocity = 0, .acceleration = 100, .pull_rate = 0, .direction = 1};
  const std::optional<double> stop = plant.FindStop(slide, 1, plant.After(1));
  ASSERT_TRUE(stop);
  EXPECT_NEAR(*stop, std::acos(-1.0) / 100, 1e-15);
}

}  // namespace
}  // namespace mwidth::model
