#include "server/model/crossing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "server/model/unit_circle.h"

namespace mwidth::model {
namespace {

// The loop of crossing.h: its polynomials, and what they are at a point.
class Loop {
 public:
  Loop(const SampledPlant& plant, const EstimatorFactors& estimator, double moving_mass) noexcept;
  // With an accelerometer.
  Loop(const SampledPlant& plant, const SampledAcceleration& acceleration, const EstimatorFactors& factors,
       double moving_mass) noexcept;

  // W without its gain and its zeros at z = -1: (hold[0] + hold[1]/z + hold[2]/z^2) times the factors, one of
  // which is the numerator of an accelerometer.
  CircleValue W(const CirclePoint& at) const noexcept {
    const double cosine = at.c - at.s;
    const auto& n = hold_;
    CircleValue value{n[0] + n[1] * cosine, -n[1], std::abs(n[0]) + std::abs(n[1]), std::abs(n[1])};
    if (n[2] != 0) {
      value.re += n[2] * (cosine * cosine - 4 * at.s * at.c);
      value.im -= n[2] * 2 * cosine;
      value.re_size += std::abs(n[2]);
      value.im_size += 2 * std::abs(n[2]);
    }
    for (int i = 0; i < factor_count_; ++i) {
      value = Times(value, factors_[static_cast<size_t>(i)], at);
    }
    return value;
  }

  // L, the left side that is to be M' W.
  CircleValue Left(const CirclePoint& at) const noexcept {
    const double u = 4 * at.s;
    const double q = plant_.static_gap;
    if (senses_acceleration_) {
      return {-u * (0.5 * (q - u) + plant_.loss), q - u, u * (0.5 * (q + u) + plant_.loss), q + u};
    }
    return {q - u * (1 - plant_.loss / 2), plant_.loss, q + u, plant_.loss};
  }

  // Im(L conj(W)) / sin(t): zero where one mass satisfies both real equations. Where nothing is lost in a
  // loop without an accelerometer, Y: the other factor's root is at rest, and CrossingsOf knows it.
  double Disagreement(const CirclePoint& at) const noexcept {
    const CircleValue w = W(at);
    if (senses_acceleration_) {
      const CircleValue left = Left(at);
      return left.re * w.im - left.im * w.re;
    }
    if (plant_.loss == 0) {
      return w.im;
    }
    return (plant_.static_gap - 4 * at.s) * w.im + plant_.loss * (2 * at.s * w.im - w.re);
  }

  // The mass at a crossing, from whichever of the two equations suffers less from cancellation.
  double MassAt(const CirclePoint& at) const noexcept {
    const CircleValue w = W(at);
    const CircleValue left = Left(at);
    // Size over value is how many times its rounding a number carries; compared without dividing.
    const double lost_in_im =
        std::max(w.im_size * std::abs(left.im), std::abs(w.im) * left.im_size) * std::abs(w.re * left.re);
    const double lost_in_re =
        std::max(w.re_size * std::abs(left.re), std::abs(w.re) * left.re_size) * std::abs(w.im * left.im);
    const bool from_im = lost_in_im <= lost_in_re && left.im != 0;
    return MassFor(from_im ? left.im / w.im : left.re / w.re, at);
  }

  // At z = -1 everything is real: one equation, no condition. Infinite where C(-1) = 0.
  double MassAtHalfSampleRate() const noexcept { return MassFor(Left({1, 0}).re / W({1, 0}).re, {1, 0}); }

  // Coefficients of Disagreement as a form. Returns its degree.
  int DisagreementForm(Form& form) const noexcept;

  // The paper's estimator without delay.
  bool IsQuadratic() const noexcept {
    return factor_count_ == 1 && plant_.hold[2] == 0 && !senses_acceleration_;
  }
  // Then Disagreement is -(Gamma u^2 - first u + zeroth), Gamma = hold[1]: closed form. Both values of u,
  // which may lie outside 0..4 or be NaN.
  std::array<double, 2> QuadraticRoots() const noexcept;

 private:
  // Estimator's poles, whole ticks of delay, and two more where a numerator has them.
  static constexpr size_t kMaxFactors = EstimatorFactors::kMaxPoles + 5;

  void Append(const CircleFactor& factor) noexcept {
    factors_[static_cast<size_t>(factor_count_++)] = factor;
  }

  // M from M' |B|^2.
  double MassFor(double ratio, const CirclePoint& at) const noexcept {
    double mass = mass_scale_ * ratio;
    for (const PoleFactor& pole : estimator_) {
      mass *= pole.SizeSquared(at);
    }
    for (int i = 0; i < estimator_.half_rate_zero_pairs; ++i) {
      mass /= 4 * at.c;
    }
    return mass / (4 * at.s);
  }

  void AppendEstimator() noexcept;

  SampledPlant plant_;
  EstimatorFactors estimator_;
  double mass_scale_;
  // Of the plant; 1 where there is an accelerometer, whose numerator is the first factor.
  std::array<double, 3> hold_;
  bool senses_acceleration_;
  std::array<CircleFactor, kMaxFactors> factors_;
  int factor_count_ = 0;
};

Loop::Loop(const SampledPlant& plant, const EstimatorFactors& estimator, double moving_mass) noexcept
    : plant_(plant),
      estimator_(estimator),
      mass_scale_(moving_mass / estimator.gain),
      hold_(plant.hold),
      senses_acceleration_(false) {
  AppendEstimator();
}

Loop::Loop(const SampledPlant& plant, const SampledAcceleration& acceleration,
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

void Loop::AppendEstimator() noexcept {
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

int Loop::DisagreementForm(Form& form) const noexcept {
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

std::array<double, 2> Loop::QuadraticRoots() const noexcept {
  const double q = plant_.static_gap;
  const double delta = plant_.loss;
  const double f = estimator_.poles[0].circle.at_c;
  const double gamma = plant_.hold[1];
  const double sum = plant_.hold[0] + gamma;
  // Unless the sampling aliases the plant, all terms are positive.
  const double first = sum + gamma * (f + q + delta);
  const double zeroth = sum * (q + f * delta) + gamma * f * q;
  const double discriminant = first * first - 4 * gamma * zeroth;
  const double twice = first + std::copysign(std::sqrt(discriminant), first);
  return {2 * zeroth / twice, twice / (2 * gamma)};
}

void Add(Crossings& crossings, const Loop& loop, double half_sine_squared) noexcept {
  crossings.found[static_cast<size_t>(crossings.count++)] = {.mass = loop.MassAt(PointAt(half_sine_squared)),
                                                             .half_sine_squared = half_sine_squared};
}

void AddIsolatedCrossings(Crossings& crossings, const Loop& loop) noexcept {
  Form form{};
  const int degree = loop.DisagreementForm(form);
  Form bernstein{};
  Form slope{};
  double binomial = 1;
  for (int i = 0; i <= degree; ++i) {
    const auto k = static_cast<size_t>(i);
    bernstein[k] = form[k] / binomial;
    binomial = binomial * (degree - i) / (i + 1);
    slope[k] = i < degree ? (i + 1) * form[k + 1] - (degree - i) * form[k] : 0;
  }
  for (const RootBracket& bracket : IsolateRoots({bernstein.data(), static_cast<size_t>(degree) + 1})) {
    // The value comes from the factors, not from the expanded polynomial: it carries less rounding.
    const double root = RefineRoot(bracket, [&](double x) {
      const CirclePoint at = PointAt(x);
      return ValueAndSlope{loop.Disagreement(at), Evaluate(slope, degree - 1, at)};
    });
    Add(crossings, loop, root);
  }
}

Crossings CrossingsOf(const Loop& loop, bool lossless, double moving_mass) noexcept {
  Crossings crossings;
  crossings.found[0] = {.mass = loop.MassAtHalfSampleRate(), .half_sine_squared = 1};
  crossings.count = 1;
  if (lossless) {
    // A free mass without friction: at rest nothing but the sum of the masses resists.
    crossings.found[1] = {.mass = -moving_mass, .half_sine_squared = 0};
    crossings.count = 2;
  }
  if (!loop.IsQuadratic()) {
    AddIsolatedCrossings(crossings, loop);
    return crossings;
  }
  for (const double u : loop.QuadraticRoots()) {
    if (u > 0 && u < 4) {
      Add(crossings, loop, u / 4);
    }
  }
  return crossings;
}

}  // namespace

Crossings FindCrossings(const SampledPlant& plant, const EstimatorFactors& estimator,
                        double moving_mass) noexcept {
  return CrossingsOf(Loop(plant, estimator, moving_mass), plant.loss == 0, moving_mass);
}

Crossings FindCrossings(const SampledPlant& plant, const SampledAcceleration& acceleration,
                        const EstimatorFactors& factors, double moving_mass) noexcept {
  return CrossingsOf(Loop(plant, acceleration, factors, moving_mass), plant.loss == 0, moving_mass);
}

}  // namespace mwidth::model
