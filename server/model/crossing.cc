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
  Loop(const SampledPlant& plant, double filter_gap, double moving_mass) noexcept
      : plant_(plant), f_(filter_gap), mass_scale_(moving_mass / filter_gap) {}

  // W = (hold[0] + hold[1]/z + hold[2]/z^2) conj(w + f) z^-delay_ticks.
  CircleValue W(const CirclePoint& at) const noexcept {
    const double cosine = at.c - at.s;
    const auto& n = plant_.hold;
    CircleValue value{n[0] + n[1] * cosine, -n[1], std::abs(n[0]) + std::abs(n[1]), std::abs(n[1])};
    if (n[2] != 0) {
      value.re += n[2] * (cosine * cosine - 4 * at.s * at.c);
      value.im -= n[2] * 2 * cosine;
      value.re_size += std::abs(n[2]);
      value.im_size += 2 * std::abs(n[2]);
    }
    value = TimesConjugate(value, f_ - 2 * at.s, f_ + 2 * at.s, at);
    for (int i = 0; i < plant_.delay_ticks; ++i) {
      value = TimesConjugate(value, cosine, 1, at);
    }
    return value;
  }

  // (q - u) Y + delta (u Y / 2 - A): zero where one mass satisfies both real equations. Where nothing is
  // lost, Y: the other factor's root is at rest, and FindCrossings knows it.
  double Disagreement(const CirclePoint& at) const noexcept {
    const CircleValue w = W(at);
    if (plant_.loss == 0) {
      return w.im;
    }
    return (plant_.static_gap - 4 * at.s) * w.im + plant_.loss * (2 * at.s * w.im - w.re);
  }

  // The mass at a crossing, from whichever of the two equations suffers less from cancellation.
  double MassAt(const CirclePoint& at) const noexcept {
    const CircleValue w = W(at);
    const double u = 4 * at.s;
    const double real_part = plant_.static_gap - u * (1 - plant_.loss / 2);
    // Size over value is how many times its rounding a number carries; compared without dividing.
    const double lost_in_im = w.im_size * std::abs(w.re * real_part);
    const double lost_in_re =
        std::abs(w.im) * std::max(w.re_size * std::abs(real_part), std::abs(w.re) * (plant_.static_gap + u));
    const bool from_im = lost_in_im <= lost_in_re && plant_.loss > 0;
    const double ratio = from_im ? plant_.loss / w.im : real_part / w.re;
    return mass_scale_ * ratio * FilterSizeSquared(u) / u;
  }

  // At z = -1 everything is real: one equation, no condition.
  double MassAtHalfSampleRate() const noexcept {
    return mass_scale_ * (plant_.static_gap - 4 + 2 * plant_.loss) / W({1, 0}).re * FilterSizeSquared(4) / 4;
  }

  // Coefficients of Disagreement as a form. Returns its degree.
  int DisagreementForm(Form& form) const noexcept;

  // Without delay Disagreement is -(Gamma u^2 - first u + zeroth), Gamma = hold[1]: the paper's loop in
  // closed form. Both values of u, which may lie outside 0..4 or be NaN.
  std::array<double, 2> QuadraticRoots() const noexcept;

 private:
  // |w + f|^2.
  double FilterSizeSquared(double u) const noexcept { return f_ * f_ + u * (1 - f_); }

  SampledPlant plant_;
  double f_;
  double mass_scale_;
};

int Loop::DisagreementForm(Form& form) const noexcept {
  const auto& n = plant_.hold;
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
  w = TimesConjugate(w, f_, f_ - 2);
  for (int i = 0; i < plant_.delay_ticks; ++i) {
    w = TimesConjugate(w, 1, -1);
  }
  if (plant_.loss == 0) {
    form = w.im;
    return w.degree - 1;
  }
  const double q = plant_.static_gap;
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
  const double gamma = plant_.hold[1];
  const double sum = plant_.hold[0] + gamma;
  // Unless the sampling aliases the plant, all terms are positive.
  const double first = sum + gamma * (f_ + q + delta);
  const double zeroth = sum * (q + f_ * delta) + gamma * f_ * q;
  const double discriminant = first * first - 4 * gamma * zeroth;
  const double twice = first + std::copysign(std::sqrt(discriminant), first);
  return {2 * zeroth / twice, twice / (2 * gamma)};
}

void Add(Crossings& crossings, const Loop& loop, double half_sine_squared) noexcept {
  crossings.found[static_cast<size_t>(crossings.count++)] = {.mass = loop.MassAt(PointAt(half_sine_squared)),
                                                             .half_sine_squared = half_sine_squared};
}

void AddDelayedCrossings(Crossings& crossings, const Loop& loop) noexcept {
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

}  // namespace

Crossings FindCrossings(const SampledPlant& plant, double filter_gap, double moving_mass) noexcept {
  const Loop loop(plant, filter_gap, moving_mass);
  Crossings crossings;
  crossings.found[0] = {.mass = loop.MassAtHalfSampleRate(), .half_sine_squared = 1};
  crossings.count = 1;
  if (plant.loss == 0) {
    // A free mass without friction: at rest nothing but the sum of the masses resists.
    crossings.found[1] = {.mass = -moving_mass, .half_sine_squared = 0};
    crossings.count = 2;
  }
  if (plant.delay_ticks > 0 || plant.hold[2] != 0) {
    AddDelayedCrossings(crossings, loop);
    return crossings;
  }
  for (const double u : loop.QuadraticRoots()) {
    if (u > 0 && u < 4) {
      Add(crossings, loop, u / 4);
    }
  }
  return crossings;
}

}  // namespace mwidth::model
