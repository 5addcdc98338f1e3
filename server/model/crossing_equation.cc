#include "server/model/crossing_equation.h"

namespace mwidth::model {

CrossingEquation::CrossingEquation(const SampledPlant& plant, const EstimatorFactors& estimator,
                                   double moving_mass) noexcept
    : plant_(plant),
      estimator_(estimator),
      mass_scale_(moving_mass / estimator.gain),
      hold_(plant.hold),
      senses_acceleration_(false) {
  AppendEstimator();
}

CrossingEquation::CrossingEquation(const SampledPlant& plant, const SampledAcceleration& acceleration,
                                   const EstimatorFactors& factors, double moving_mass) noexcept
    : plant_(plant),
      estimator_(factors),
      mass_scale_(moving_mass / factors.gain),
      hold_{1, 0, 0},
      senses_acceleration_(true) {
  // N of degree 1, or z times N/z of degree 2, and that z makes good for the tick begun.
  const auto& n = acceleration.rise;
  Append(n[2] == 0 ? CircleFactor{n[0], n[0] - 2 * n[1], -n[1]}
                   : CircleFactor{n[0], 2 * n[1] - 4 * n[2] - n[0], n[0] - n[1]});
  AppendEstimator();
}

void CrossingEquation::AppendEstimator() noexcept {
  // Powers of z that are left to multiply with; (z + 1)^2 = 4 c z has one for each pair.
  int turns = 1 + estimator_.half_rate_zero_pairs - estimator_.lag_ticks - plant_.delay_ticks;
  for (const PoleFactor& pole : estimator_) {
    if (pole.degree == 2 || turns > 0) {
      Append(pole.circle);
      --turns;
    } else {
      // conj(B) of degree 1 without z.
      Append({pole.circle.at_c, -pole.circle.at_s, pole.circle.at_c + pole.circle.turn});
    }
  }
  for (; turns < 0; ++turns) {
    Append(kOneTickLater);
  }
}

int CrossingEquation::DisagreementForm(Form& form) const noexcept {
  const auto& n = hold_;
  // hold[0] + hold[1]/z + hold[2]/z^2, with 1 = c + s, cos t = c - s and cos 2t = c^2 - 6 c s + s^2.
  CircleForm w;
  if (n[2] == 0) {
    w.degree = 1;
    w.re = {n[0] + n[1], n[0] - n[1]};
    w.im = {-n[1]};
  } else {
    w.degree = 2;
    w.re = {n[0] + n[1] + n[2], 2 * n[0] - 6 * n[2], n[0] - n[1] + n[2]};
    w.im = {-n[1] - 2 * n[2], 2 * n[2] - n[1]};
  }
  for (int i = 0; i < factor_count_; ++i) {
    w = Times(w, factors_[static_cast<size_t>(i)]);
  }
  const double q = plant_.static_gap;
  if (senses_acceleration_) {
    // L = (q - u) w - delta u, with q - u = q c + (q - 4) s and w = -2 s + j sin(t).
    const std::array<double, 3> left_re{0, -2 * q - 4 * plant_.loss, 8 - 2 * q - 4 * plant_.loss};
    const std::array<double, 2> left_im{q, q - 4};
    for (int k = 0; k <= w.degree; ++k) {
      const auto i = static_cast<size_t>(k);
      for (size_t j = 0; j < left_im.size(); ++j) {
        form[i + j] -= left_im[j] * w.re[i];
      }
      for (size_t j = 0; k < w.degree && j < left_re.size(); ++j) {
        form[i + j] += left_re[j] * w.im[i];
      }
    }
    return w.degree + 1;
  }
  if (plant_.loss == 0) {
    form = w.im;
    return w.degree - 1;
  }
  for (int k = 0; k <= w.degree; ++k) {
    const auto i = static_cast<size_t>(k);
    const double y = k < w.degree ? w.im[i] : 0;
    const double y_before = k > 0 ? w.im[i - 1] : 0;
    form[i] = q * (y + y_before) - 4 * y_before + plant_.loss * (2 * y_before - w.re[i]);
  }
  return w.degree;
}

}  // namespace mwidth::model
