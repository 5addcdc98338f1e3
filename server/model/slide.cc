#include "server/model/slide.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/model/real_roots.h"

namespace mwidth::model {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double VelocityAfter(const Slide& slide, const PlantResponse& response) noexcept {
  return slide.velocity + slide.acceleration * response.impulse + slide.pull_rate * response.step;
}

double AccelerationAfter(const Slide& slide, const PlantResponse& response) noexcept {
  return slide.acceleration * (1 - response.velocity_loss) + slide.pull_rate * response.impulse;
}

}  // namespace

SlidingPlant::SlidingPlant(double damping_rate, double stiffness_rate) noexcept
    : damping_rate_(damping_rate), stiffness_rate_(stiffness_rate) {
  const double alpha = damping_rate / 2;
  const double discriminant = alpha * alpha - stiffness_rate;
  if (discriminant < 0) {
    angular_frequency_ = std::sqrt(-discriminant);
    return;
  }
  half_difference_ = std::sqrt(discriminant);
  const double fast_rate = alpha + half_difference_;
  slow_rate_ = fast_rate > 0 ? stiffness_rate / fast_rate : 0;
}

double SlidingPlant::FirstTurn(const Slide& slide) const noexcept {
  const double a = slide.acceleration;
  const double j = slide.pull_rate;
  if (angular_frequency_ > 0) {
    // tan(omega t) = omega a / (alpha a - j), with the sign that leaves the first t above 0.
    const double turn = a != 0 ? std::copysign(1.0, a) : std::copysign(1.0, j);
    const double angle = std::atan2(std::abs(a) * angular_frequency_, turn * (damping_rate_ / 2 * a - j));
    return angle / angular_frequency_;
  }
  // e^(2 half_difference t) = (fast a - j) / (slow a - j), also where both rates agree.
  const double scale = a / (slow_rate_ * a - j);
  const double time_s =
      half_difference_ > 0 ? std::log1p(2 * half_difference_ * scale) / (2 * half_difference_) : scale;
  // The check takes infinity for a number that double cannot hold.
  return time_s > 0 ? time_s : kNever;  // NOLINT(bugprone-narrowing-conversions)
}

std::optional<double> SlidingPlant::FindStop(const Slide& slide, double time_s,
                                             const PlantResponse& at_end) const noexcept {
  const double s = slide.direction;
  double low = 0;
  double high = FirstTurn(slide);
  if (s * slide.acceleration > 0 || (slide.acceleration == 0 && s * slide.pull_rate > 0)) {
    // At first it speeds up; it can come to rest only after that turn.
    low = high;
    high = angular_frequency_ > 0 ? low + std::numbers::pi / angular_frequency_ : kNever;
  }
  if (!(low < time_s)) {
    return std::nullopt;
  }
  const PlantResponse response = high < time_s ? After(high) : at_end;
  if (!(s * VelocityAfter(slide, response) <= 0)) {
    return std::nullopt;
  }
  high = std::min(high, time_s);
  const RootBracket bracket{.low = low, .high = high, .rising = s < 0, .guess = low + (high - low) / 2};
  return RefineRoot(bracket, [&](double t) {
    const PlantResponse at = After(t);
    return ValueAndSlope{VelocityAfter(slide, at), AccelerationAfter(slide, at)};
  });
}

}  // namespace mwidth::model
