// Boxes of plants, and plants of a box, for the tests of bounds.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "server/model/loop_parameters.h"
#include "server/model/plant_range.h"

namespace mwidth::model {

/// Seeded boxes of plants and random members.
class RandomPlants {
 public:
  explicit RandomPlants(unsigned seed) : random_(seed) {}

  double Uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  double LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }
  bool OneIn(int n) { return Uniform(0, n) < 1; }

  /// A range around a value between `low` and `high`, in one of four cases a point, else up to a factor
  /// `spread` wide.
  Interval Range(double low, double high, double spread) {
    const double first = LogUniform(low, high);
    return {first, OneIn(4) ? first : first * LogUniform(1, spread)};
  }

  /// Plants of every kind with T = `period_s`: alpha 1e-6..30, kappa 1e-8..60, near critical damping,
  /// aliased, released.
  PlantBox Box(double period_s) {
    const double spread = OneIn(2) ? 1.1 : 20;
    PlantBox box;
    box.mass = Range(1e-2, 1, spread);
    const double alpha = LogUniform(1e-6, 30);
    const double kappa = OneIn(4) ? alpha * alpha * (1 + LogUniform(1e-12, 1)) : LogUniform(1e-8, 60);
    box.damping = Range(1, 1, spread);
    box.stiffness = Range(1, 1, spread);
    for (double* end : {&box.damping.lo, &box.damping.hi}) {
      *end *= 2 * alpha * box.mass.lo / period_s;
    }
    for (double* end : {&box.stiffness.lo, &box.stiffness.hi}) {
      *end *= kappa * box.mass.lo / (period_s * period_s);
    }
    if (OneIn(8)) {
      box.stiffness = Exactly(0);
    }
    if (!OneIn(3)) {
      const double first = OnGrid(Uniform(0, 1));
      const double second = OneIn(3) ? 1 : OnGrid(OneIn(2) ? Uniform(0, 1) : std::min(1.0, first + 0.01));
      box.delay_ticks = static_cast<int>(Uniform(0, 3));
      box.fraction = {std::min(first, second), std::max(first, second)};
    }
    return box;
  }

  /// A fraction of a tick that is exact also with whole ticks added, and below 1 so that it stays a fraction.
  static constexpr double kGrid = 0x1p-40;
  static double OnGrid(double fraction) { return std::floor(fraction / kGrid) * kGrid; }

  /// Anywhere in `range`, often at an end.
  double Inside(const Interval& range) {
    const double way = Uniform(-0.5, 1.5);
    return std::clamp(range.lo + way * range.width(), range.lo, range.hi);
  }
  LoopParameters Inside(const PlantBox& box, double period_s) {
    return {.device_mass = Inside(box.mass),
            .device_damping = Inside(box.damping),
            .hand_stiffness = Inside(box.stiffness),
            .period_s = period_s,
            .delay_s = (box.delay_ticks + OnGrid(std::min(Inside(box.fraction), 1 - kGrid))) * period_s};
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace mwidth::model
