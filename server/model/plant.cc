#include "server/model/plant.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace mwidth::model {
namespace {

// x'' + 2 alpha x' + kappa x = 0, time in ticks, released at x = 0 with velocity 1:
// h(s) = e^(-alpha s) S(s), S(s) = sinh(sqrt(alpha^2 - kappa) s) / sqrt(alpha^2 - kappa).
struct Motion {
  double alpha;
  double kappa;
};

// What a constant force over the first `s` ticks leaves in the numerator of G:
// step  = Phi(s)   = integral over 0..s of e^(-alpha v) S(v) dv
// after = Gamma(s) = e^(-2 alpha s) integral over 0..s of e^(alpha v) S(v) dv = h(s)^2 - h'(s) Phi(s)
struct Hold {
  double step;
  double after;
};

// (1 - e^-x) / x.
double MeanDecay(double x) noexcept { return x == 0 ? 1 : -std::expm1(-x) / x; }

// e^-x by `loss`, 1 - e^-x, wherever the difference from 1 is exact enough: it is at hand already.
double Decay(double x, double loss) noexcept { return loss <= 0.5 ? 1 - loss : std::exp(-x); }

// 1/n!, n = 3..
constexpr auto kInverseFactorials = [] {
  std::array<double, 28> values{};
  double factorial = 6;
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = 1 / factorial;
    factorial *= static_cast<double>(i) + 4;
  }
  return values;
}();

// Little happens in the time `s`: Taylor series. With p = 2 alpha s, r = kappa s^2 and v_1 = 1, v_2 = p,
// v_(n+2) = p v_(n+1) - r v_n, the integral of e^(alpha v) S(v) is s^2 times the sum of v_n / (n+1)!.
// Negative alpha turns the sign of every other term, so one sum each of odd and even ones serves both. They
// run side by side, v_(n+4) = (p^2 - 2 r) v_(n+2) - r^2 v_n. Needs p <= 2 and r <= 1.
Hold SeriesHold(double p, double r, double s, double loss) noexcept {
  const double ahead = p * p - 2 * r;
  const double behind = r * r;
  double even = 0;  // n = 2, 4, ..
  double even_v = p;
  double even_before = 0;
  double odd = 0;  // n = 3, 5, ..
  double odd_v = p * p - r;
  double odd_before = 1;
  // |v_n| < 2.5^(n-1): at worst the 27th term is below the rounding of the first.
  for (size_t i = 0; i < kInverseFactorials.size(); i += 2) {
    even += even_v * kInverseFactorials[i];
    odd += odd_v * kInverseFactorials[i + 1];
    if ((std::abs(even_v) + std::abs(odd_v)) * kInverseFactorials[i + 1] < 1e-18) {
      break;
    }
    even_before = std::exchange(even_v, ahead * even_v - behind * even_before);
    odd_before = std::exchange(odd_v, ahead * odd_v - behind * odd_before);
  }
  return {.step = s * s * (0.5 + (odd - even)), .after = s * s * Decay(p, loss) * (0.5 + (odd + even))};
}

// Well apart real poles: differences of two decays that differ by a third at least.
Hold OverdampedHold(const Motion& motion, double s, double difference) noexcept {
  const double fast = motion.alpha + difference;
  const double slow = motion.kappa / fast;  // alpha - difference without its cancellation
  const double mean_fast = MeanDecay(fast * s);
  const double mean_slow = MeanDecay(slow * s);
  const double scale = s / (2 * difference);
  return {.step = scale * (mean_slow - mean_fast),
          .after = scale * (std::exp(-slow * s) * mean_fast - std::exp(-fast * s) * mean_slow)};
}

// Poles close together or complex: the closed form divided by kappa, which is not small here.
Hold OscillatingHold(const Motion& motion, double s, double difference_squared) noexcept {
  double cosine = 0;  // e^(-alpha s) cosh(difference s)
  double sine = 0;    // e^(-alpha s) sinh(difference s) / difference
  if (difference_squared >= 0) {
    const double difference = std::sqrt(difference_squared);
    const double slow_decay = std::exp((difference - motion.alpha) * s);
    cosine = slow_decay * (1 + 0.5 * std::expm1(-2 * difference * s));
    sine = slow_decay * s * MeanDecay(2 * difference * s);
  } else {
    const double omega = std::sqrt(-difference_squared);
    const double decay = std::exp(-motion.alpha * s);
    cosine = decay * std::cos(omega * s);
    sine = decay * std::sin(omega * s) / omega;
  }
  return {.step = (1 - cosine - motion.alpha * sine) / motion.kappa,
          .after = (std::exp(-2 * motion.alpha * s) - cosine + motion.alpha * sine) / motion.kappa};
}

// `loss` is 1 - e^(-2 alpha s).
Hold HoldFor(const Motion& motion, double s, double loss) noexcept {
  if (motion.alpha * s <= 1 && motion.kappa * s * s <= 1) {
    return SeriesHold(2 * motion.alpha * s, motion.kappa * s * s, s, loss);
  }
  const double difference_squared = motion.alpha * motion.alpha - motion.kappa;
  if (4 * difference_squared >= motion.alpha * motion.alpha) {
    return OverdampedHold(motion, s, std::sqrt(difference_squared));
  }
  return OscillatingHold(motion, s, difference_squared);
}

}  // namespace

SampledPlant Discretize(const LoopParameters& loop) noexcept {
  const double mass = loop.device_mass + loop.hand_mass;
  const double damping = loop.device_damping + loop.hand_damping;
  const double period = loop.period_s;
  SampledPlant plant;
  plant.gain = period * period / mass;
  const Motion motion{.alpha = 0.5 * damping * period / mass, .kappa = loop.hand_stiffness * plant.gain};
  plant.loss = -std::expm1(-2 * motion.alpha);
  const Hold whole = HoldFor(motion, 1, plant.loss);
  plant.static_gap = motion.kappa * (whole.step + whole.after);
  plant.hold = {whole.step, whole.after, 0};
  if (loop.delay_s == 0) {
    return plant;
  }

  // A delay of three periods is rarely exactly three times the period in binary: what rounding made is no
  // fraction.
  const double ticks = loop.delay_s / period;
  const double rounding = 8 * std::numeric_limits<double>::epsilon() * ticks;
  const double whole_ticks = std::floor(ticks + rounding);
  const double fraction = ticks - whole_ticks;
  plant.delay_ticks = static_cast<int>(whole_ticks);
  if (fraction <= rounding) {
    return plant;
  }
  // The newest force acts during the last 1 - fraction of the tick, the one before during the rest.
  const double newest_decay = 2 * motion.alpha * (1 - fraction);
  const double newest_loss = -std::expm1(-newest_decay);
  const Hold newest = HoldFor(motion, 1 - fraction, newest_loss);
  const Hold before = HoldFor(motion, fraction, -std::expm1(-2 * motion.alpha * fraction));
  const double oldest = Decay(newest_decay, newest_loss) * before.after;
  plant.hold = {newest.step, (whole.step - newest.step) + (whole.after - oldest), oldest};
  return plant;
}

}  // namespace mwidth::model
