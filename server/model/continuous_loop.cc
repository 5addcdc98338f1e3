#include "server/model/continuous_loop.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

namespace mwidth::model {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

// The phase of L/M falls from pi (k > 0) or pi/2 towards minus infinity, always: every factor lags more as
// the frequency rises. So L/M is real once for each multiple of pi, and the n-th time (n = 0, 1, ...) it has
// the sign of (-1)^n. Its size there is the inverse of the mass that makes L = -1.
class PhaseCrossings {
 public:
  explicit PhaseCrossings(const LoopParameters& loop)
      : mu_(loop.device_mass + loop.hand_mass),
        beta_(loop.device_damping + loop.hand_damping),
        k_(loop.hand_stiffness),
        half_period_s_(loop.period_s / 2),
        dead_time_s_(loop.period_s / 2 + loop.delay_s),
        cutoff_(2 * pi * loop.cutoff_hz) {}

  // First frequency above `w_before`, the one of n - 1 (or 0), at which lead and lag part by n pi.
  double Frequency(int n, double w_before) const {
    const auto excess = [&](double w) { return Lead(w) - Lag(w) + n * pi; };
    double low = w_before;
    // Here the dead time alone lags by more than the lead can make up.
    double high = (n + 1) * pi / dead_time_s_;
    // From afar the root looks as if it were at 0, which costs the solver bisections; halving is as good.
    while (excess(high / 2) < 0 && high / 2 > low) {
      high /= 2;
    }
    low = std::max(low, high / 2);
    std::uintmax_t iterations = 100;
    const auto [below, above] = boost::math::tools::toms748_solve(
        excess, low, high, boost::math::tools::eps_tolerance<double>(53), iterations);
    return below + (above - below) / 2;
  }

  // |M| for which |L| = 1.
  double Mass(double w) const { return std::hypot(mu_ * w * w - k_, beta_ * w) / (w * w) / EstimatorSize(w); }

  // No crossing at w or above has a mass below this. Meant for frequencies above the resonance.
  double LeastMassFrom(double w) const { return (mu_ - k_ / (w * w)) / EstimatorSize(w); }

 private:
  // Phase of -1/(k - mu w^2 + j beta w), from pi (or pi/2, or 0) down to 0.
  double Lead(double w) const { return std::atan2(beta_ * w, mu_ * w * w - k_); }
  double Lag(double w) const {
    return 2 * std::atan(w * half_period_s_) + std::atan(w / cutoff_) + w * dead_time_s_;
  }
  // |D H| / w^2.
  double EstimatorSize(double w) const {
    const double difference = w * half_period_s_;
    return 1 / ((1 + difference * difference) * std::hypot(1, w / cutoff_));
  }

  double mu_;
  double beta_;
  double k_;
  double half_period_s_;
  double dead_time_s_;
  double cutoff_;
};

}  // namespace

Complex ContinuousEstimator(const LoopParameters& loop, double frequency_hz) {
  const Complex s(0, 2 * pi * frequency_hz);
  const double cutoff = 2 * pi * loop.cutoff_hz;
  const Complex lag = s * loop.period_s + 2.0;
  return 4.0 * s * s / (lag * lag) * cutoff / (s + cutoff);
}

Complex ContinuousLoop(const LoopParameters& loop, double mass, double frequency_hz) {
  const double w = 2 * pi * frequency_hz;
  const Complex plant(loop.hand_stiffness - (loop.device_mass + loop.hand_mass) * w * w,
                      (loop.device_damping + loop.hand_damping) * w);
  const Complex dead_time = std::polar(1.0, -w * (loop.period_s / 2 + loop.delay_s));
  return mass * ContinuousEstimator(loop, frequency_hz) * dead_time / plant;
}

MWidth ComputeContinuousMWidth(const LoopParameters& loop) {
  MWidth m_width;
  const double damping = loop.device_damping + loop.hand_damping;
  if (damping == 0 && loop.hand_stiffness > 0) {
    m_width.empty_reason = "without damping (device_damping and hand_damping are 0) the loop is not stable";
    return m_width;
  }
  const double infinity = std::numeric_limits<double>::infinity();
  m_width.lower.mass = -infinity;
  m_width.upper.mass = infinity;
  const double moving_mass = loop.device_mass + loop.hand_mass;
  const bool free = damping == 0;
  if (free) {
    // s^2 cancels: at rest L is M/mu, and there is no phase crossing above rest to find it by.
    m_width.lower = {.mass = -moving_mass, .critical_hz = 0};
  }
  const PhaseCrossings crossings(loop);
  const double resonance = std::sqrt(loop.hand_stiffness / moving_mass);
  double w = 0;
  // Delay can make a later crossing the nearer one, as long as |L| still rises towards the resonance.
  for (int n = free ? 1 : 0;; ++n) {
    w = crossings.Frequency(n, w);
    const double size = crossings.Mass(w);
    Edge& edge = n % 2 == 0 ? m_width.lower : m_width.upper;
    if (size < std::abs(edge.mass)) {
      edge = {.mass = n % 2 == 0 ? -size : size, .critical_hz = w / (2 * pi)};
    }
    const double farther = std::max(-m_width.lower.mass, m_width.upper.mass);
    if (w > resonance && crossings.LeastMassFrom(w) >= farther) {
      return m_width;
    }
  }
}

}  // namespace mwidth::model
