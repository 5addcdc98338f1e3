#include "client/cli/session/movement.h"

#include <algorithm>
#include <cmath>

#include "server/model/accuracy.h"

namespace mwidth::cli::session {
namespace {

// Least way of a movement without a target, as a share of the longest in its trial, and of all that it moved:
// who goes there and comes back has not reached for where he ends.
constexpr double kLeastWayShare = 0.2;
constexpr double kLeastShareOfSpan = 0.5;

std::size_t SamplesOf(double time_s, const Motion& motion) {
  return static_cast<std::size_t>(std::lround(time_s / motion.period_s));
}

// The first sample from `from` on after which the motion is slower than `threshold` for kRestS; `limit` where
// there is none before.
std::size_t RestFrom(const Motion& motion, std::size_t from, std::size_t limit, double threshold) {
  const std::size_t rest = SamplesOf(kRestS, motion);
  std::size_t slow = 0;
  for (std::size_t k = from; k < limit; ++k) {
    slow = std::abs(motion.velocity[k]) < threshold ? slow + 1 : 0;
    if (slow == rest) {
      return k + 1 - rest;
    }
  }
  return limit;
}

std::size_t SettledAfter(const Motion& motion, const Movement& movement) {
  return movement.came_to_rest ? movement.end + SamplesOf(kRestS, motion) - 1 : movement.end;
}

void JudgeMotion(const Motion& motion, Movement& movement) {
  const double way = movement.target - movement.start;
  const double direction = way < 0 ? -1 : 1;
  double farthest = -HUGE_VAL;
  movement.peak = movement.onset;
  for (std::size_t k = movement.onset; k <= movement.settled; ++k) {
    const double beyond = direction * (motion.position[k] - movement.target);
    movement.turned = movement.came_to_rest || beyond < farthest;
    farthest = std::max(farthest, beyond);
    if (direction * motion.velocity[k] > direction * motion.velocity[movement.peak]) {
      movement.peak = k;
    }
  }
  movement.overshoot = farthest / std::abs(way);
  movement.end_error = motion.position[movement.settled] - movement.target;
  movement.peak_velocity = motion.velocity[movement.peak];
  movement.movement_time_s = motion.TimeOf(movement.end - movement.onset);
  movement.time_to_peak_s = motion.TimeOf(movement.peak - movement.onset);
}

void JudgeForce(const Motion& motion, const std::optional<Device>& device, Movement& movement) {
  double square = 0;
  bool constant = true;
  model::LeastSquaresMass perceived;
  model::LeastSquaresMass expected;
  for (std::size_t k = movement.onset; k <= movement.end; ++k) {
    const double force = motion.force[k];
    movement.peak_force = std::max(movement.peak_force, std::abs(force));
    square += force * force;
    constant = constant && motion.mass[k] == motion.mass[movement.onset];
    if (device) {
      const double without = device->mass * motion.acceleration[k] + device->damping * motion.velocity[k];
      perceived.Add(motion.acceleration[k], without + force);
      if (!motion.expected_force.empty()) {
        expected.Add(motion.acceleration[k], without + motion.expected_force[k]);
      }
    }
  }
  movement.rms_force = std::sqrt(square / static_cast<double>(movement.end - movement.onset + 1));
  if (constant) {
    movement.mass = motion.mass[movement.onset];
  }
  movement.perceived_mass = perceived.mass();
  movement.expected_mass = expected.mass();
  const double ideal = device && movement.mass ? device->mass + *movement.mass : 0;
  if (ideal != 0) {
    const auto error = [ideal](const std::optional<double>& mass) {
      return mass ? std::optional((*mass - ideal) / ideal) : std::nullopt;
    };
    movement.error = error(movement.perceived_mass);
    movement.expected_error = error(movement.expected_mass);
  }
}

// With a target.
class Reaches {
 public:
  Reaches(const Motion& motion, double start, double target)
      : motion_(motion), start_(start), target_(target), direction_(target < start ? -1 : 1) {
    for (const double velocity : motion.velocity) {
      fastest_ = std::max(fastest_, direction_ * velocity);
    }
  }

  Movements Find() const {
    Movements movements;
    const std::size_t count = motion_.position.size();
    std::size_t armed = 0;
    for (;;) {
      const std::size_t near = First(armed, [](double way) { return way < 0.25; });
      const std::size_t middle = First(near, [](double way) { return way > 0.5; });
      if (middle == count) {
        return movements;
      }
      const std::size_t next = First(middle, [](double way) { return way < 0.25; });
      armed = middle;
      if (const auto onset = OnsetBefore(middle)) {
        movements.found.push_back(Reach(*onset, middle, next));
      } else {
        ++movements.left_out;
      }
    }
  }

 private:
  template <typename Condition>
  std::size_t First(std::size_t from, const Condition& condition) const {
    std::size_t k = from;
    while (k < motion_.position.size() && !condition((motion_.position[k] - start_) / (target_ - start_))) {
      ++k;
    }
    return k;
  }
  double Threshold() const { return kOnsetShare * fastest_; }
  std::optional<std::size_t> OnsetBefore(std::size_t middle) const {
    for (std::size_t k = middle; k > 0; --k) {
      if (direction_ * motion_.velocity[k - 1] < Threshold()) {
        return k - 1;
      }
    }
    return std::nullopt;
  }
  Movement Reach(std::size_t onset, std::size_t middle, std::size_t next) const {
    const std::size_t limit = std::min(next, motion_.position.size());
    Movement reach{.onset = onset, .start = start_, .target = target_, .target_given = true};
    reach.end = RestFrom(motion_, middle, limit, Threshold());
    reach.came_to_rest = reach.end < limit;
    reach.end = std::min(reach.end, limit - 1);
    reach.settled = SettledAfter(motion_, reach);
    return reach;
  }

  const Motion& motion_;
  double start_;
  double target_;
  double direction_;
  double fastest_ = 0;
};

// From the least to the farthest position.
double SpanOf(const Motion& motion, const Movement& movement) {
  const auto begin = motion.position.begin() + static_cast<std::ptrdiff_t>(movement.onset);
  const auto end = motion.position.begin() + static_cast<std::ptrdiff_t>(movement.settled + 1);
  const auto [least, most] = std::minmax_element(begin, end);
  return *most - *least;
}

// Without one.
Movements BetweenRests(const Motion& motion) {
  Movements movements;
  double fastest = 0;
  for (const double velocity : motion.velocity) {
    fastest = std::max(fastest, std::abs(velocity));
  }
  const double threshold = kOnsetShare * fastest;
  const std::size_t count = motion.position.size();
  double longest = kLeastWayCounts / kLeastWayShare * motion.position_quantum;
  for (std::size_t k = 0; k < count;) {
    if (std::abs(motion.velocity[k]) < threshold || threshold == 0) {
      ++k;
      continue;
    }
    const std::size_t end = RestFrom(motion, k, count, threshold);
    if (k == 0 || end == count) {
      ++movements.left_out;
    } else {
      Movement movement{.onset = k - 1, .end = end, .came_to_rest = true, .start = motion.position[k - 1]};
      movement.settled = SettledAfter(motion, movement);
      movement.target = motion.position[movement.settled];
      longest = std::max(longest, std::abs(movement.target - movement.start));
      movements.found.push_back(movement);
    }
    k = end;
  }
  std::erase_if(movements.found, [longest](const Movement& movement) {
    return !(std::abs(movement.target - movement.start) > kLeastWayShare * longest);
  });
  movements.left_out += std::erase_if(movements.found, [&motion](const Movement& movement) {
    return std::abs(movement.target - movement.start) < kLeastShareOfSpan * SpanOf(motion, movement);
  });
  return movements;
}

}  // namespace

Movements FindMovements(const Motion& motion, const Task& task, const std::optional<Device>& device) {
  const double start = task.start.value_or(motion.position.front());
  Movements movements = task.target && *task.target != start ? Reaches(motion, start, *task.target).Find()
                                                             : BetweenRests(motion);
  for (Movement& movement : movements.found) {
    JudgeMotion(motion, movement);
    JudgeForce(motion, device, movement);
  }
  return movements;
}

}  // namespace mwidth::cli::session
