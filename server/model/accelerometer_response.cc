#include "server/model/accelerometer_response.h"

#include <algorithm>
#include <cmath>

namespace mwidth::model {
namespace {

// Below this product of time and rate each term of the series is less than 1/n of the one before.
constexpr double kSeriesReach = 0.5;
// 1/18! is below 1e-15, and the powers of 1/2 take it below 1e-20.
constexpr int kSeriesTerms = 18;

// Taylor coefficients, all from the equations of motion: h has c_1 = 1, c_(n+1) = -c c_n - k c_(n-1); y has
// a_(n+1) = l (c_(n+1) - a_n); and h_1 - h, with h_1 the impulse response without the spring, d_(n+2) =
// -c d_(n+1) + k c_n, which spring_loss is c times.
AccelerometerResponse Series(double time, double damping_rate, double stiffness_rate, double sensor_rate) {
  AccelerometerResponse response;
  double before = 0;  // c_(n-1)
  double motion = 1;  // c_n
  double sensed = sensor_rate;
  double lost = 0;        // d_n
  double lost_after = 0;  // d_(n+1)
  double power = time;    // t^n / n!
  for (int n = 1; n <= kSeriesTerms; ++n) {
    response.impulse += motion * power;
    response.step += motion * power * time / (n + 1);
    response.spring_loss += damping_rate * lost * power;
    response.after_step += sensed * power;
    response.after_ramp += sensed * power * time / (n + 1);
    response.after_parabola += sensed * power * time / (n + 1) * time / (n + 2);
    const double next = -damping_rate * motion - stiffness_rate * before;
    const double lost_next = -damping_rate * lost_after + stiffness_rate * motion;
    sensed = sensor_rate * (next - sensed);
    before = motion;
    motion = next;
    lost = lost_after;
    lost_after = lost_next;
    power *= time / (n + 1);
  }
  response.kept = std::exp(-sensor_rate * time);
  response.slope = std::exp(-damping_rate * time) + response.spring_loss - stiffness_rate * response.step;
  return response;
}

// After twice the time: what was reached after the first half goes on freely, and the acceleration acts
// again.
AccelerometerResponse Doubled(const AccelerometerResponse& half, double half_time, double damping_rate,
                              double stiffness_rate, double sensor_rate) {
  const double held = 1 - stiffness_rate * half.step;
  const double damping_kept = std::exp(-damping_rate * half_time);
  AccelerometerResponse whole;
  whole.impulse = half.impulse * (held + half.slope);
  whole.step = half.step * (1 + held) + half.impulse * half.impulse;
  whole.spring_loss = 2 * stiffness_rate * half.step * damping_rate * half.impulse +
                      half.spring_loss * (2 * damping_kept + half.spring_loss);
  // Squared, its error would double each time.
  whole.kept = std::exp(-sensor_rate * (2 * half_time));
  whole.after_step =
      half.after_step * (half.kept + half.slope) - stiffness_rate * half.after_ramp * half.impulse;
  whole.after_ramp = half.after_ramp * (half.kept + held) + half.impulse * half.after_step;
  whole.after_parabola = half.after_parabola * (half.kept + held) +
                         half.step * -std::expm1(-sensor_rate * half_time) + half.impulse * half.after_ramp;
  whole.slope = std::exp(-damping_rate * (2 * half_time)) + whole.spring_loss - stiffness_rate * whole.step;
  return whole;
}

}  // namespace

AccelerometerResponse SenseAfter(double time, double damping_rate, double stiffness_rate,
                                 double sensor_rate) noexcept {
  const double fastest_rate = std::max({damping_rate, std::sqrt(stiffness_rate), sensor_rate});
  int doublings = 0;
  double part = time;
  while (part * fastest_rate > kSeriesReach) {
    part /= 2;
    ++doublings;
  }
  AccelerometerResponse response = Series(part, damping_rate, stiffness_rate, sensor_rate);
  for (int i = 0; i < doublings; ++i) {
    response = Doubled(response, part, damping_rate, stiffness_rate, sensor_rate);
    part *= 2;
  }
  return response;
}

}  // namespace mwidth::model
