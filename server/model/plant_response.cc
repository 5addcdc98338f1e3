#include "server/model/plant_response.h"

#include <algorithm>
#include <cmath>

namespace mwidth::model {
namespace {

// Below this product of time and rate the series gains a factor of at least 2n per term n.
constexpr double kSeriesReach = 0.5;
// (1/2)^16 / 16! is below 1e-18.
constexpr int kSeriesTerms = 16;

/// Taylor series. The coefficients of the impulse response x = sum c_n t^n / n! follow from the equation of
/// motion: c_1 = 1, c_(n+1) = -damping c_n - stiffness c_(n-1); the others are its integrals, term by term.
PlantResponse Series(double time_s, double damping_rate, double stiffness_rate) {
  PlantResponse response;
  double before = 0;
  double coefficient = 1;
  double power = time_s;  // t^n / n!
  for (int n = 1; n <= kSeriesTerms; ++n) {
    const double term = coefficient * power;
    response.impulse += term;
    response.step += term * time_s / (n + 1);
    response.ramp += term * time_s / (n + 1) * time_s / (n + 2);
    response.parabola += term * time_s / (n + 1) * time_s / (n + 2) * time_s / (n + 3);
    const double next = -damping_rate * coefficient - stiffness_rate * before;
    before = coefficient;
    coefficient = next;
    power *= time_s / (n + 1);
  }
  response.velocity_loss = damping_rate * response.impulse + stiffness_rate * response.step;
  return response;
}

/// The response after twice the time: the motion reached after the first half goes on freely, and the
/// acceleration acts again.
PlantResponse Doubled(const PlantResponse& half, double half_time_s, double damping_rate,
                      double stiffness_rate) {
  const double position_kept = 1 - stiffness_rate * half.step;
  const double velocity_kept = 1 - half.velocity_loss;
  PlantResponse whole;
  whole.impulse = half.impulse * (position_kept + velocity_kept);
  whole.step = half.step * (1 + position_kept) + half.impulse * half.impulse;
  whole.ramp = half.ramp * (1 + position_kept) + half.impulse * half.step + half_time_s * half.step;
  whole.parabola = half.parabola * (1 + position_kept) + half.impulse * half.ramp +
                   half_time_s * (half.ramp + half_time_s / 2 * half.step);
  whole.velocity_loss = damping_rate * whole.impulse + stiffness_rate * whole.step;
  return whole;
}

}  // namespace

PlantResponse RespondAfter(double time_s, double damping_rate, double stiffness_rate) noexcept {
  const double fastest_rate = std::max(damping_rate, std::sqrt(stiffness_rate));
  int doublings = 0;
  double part_s = time_s;
  while (part_s * fastest_rate > kSeriesReach) {
    part_s /= 2;
    ++doublings;
  }
  PlantResponse response = Series(part_s, damping_rate, stiffness_rate);
  for (int i = 0; i < doublings; ++i) {
    response = Doubled(response, part_s, damping_rate, stiffness_rate);
    part_s *= 2;
  }
  return response;
}

}  // namespace mwidth::model
