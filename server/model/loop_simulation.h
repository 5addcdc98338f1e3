// The whole rendering loop, with what the linear model leaves out.
//
//   X(k) -> encoder -> estimate a_hat(k) -> M a_hat(k) -> limit, motor's quantum -> delay -> device and hand
//
// With no imperfection it is the model whose M-width is computed: HybridSimulation, or
// AccelerometerSimulation whose sensor is read beside the encoder, and AccelerationEstimator with eq. 5
// between them, bit for bit. Each imperfection is then told from the model by switching it on.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

#include "server/model/accelerometer_simulation.h"
#include "server/model/estimator.h"
#include "server/model/friction_simulation.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// What parts a real axis from the linear model; none by default. The loop's delay is in LoopParameters.
struct Imperfections {
  /// One encoder count in m or rad; positions are read to the nearest. 0: exact.
  double position_quantum = 0;
  /// One count of the accelerometer in m/s^2 or rad/s^2, likewise; of no account without one.
  double acceleration_quantum = 0;
  /// One count of the force in N or N m; forces are rounded to the nearest. 0: exact.
  double force_quantum = 0;
  /// Coulomb friction of the device in N or N m.
  double coulomb_friction = 0;
  /// Largest force either way in N or N m; with a quantum, its largest multiple within the limit.
  double force_limit = std::numeric_limits<double>::infinity();
};

/// The first imperfection that is not a number or out of range, if any: quanta and friction 0 to 1e6;
/// force_limit at least 0, also infinite.
std::optional<ParameterError> Validate(const Imperfections& imperfections);

/// What the loop saw and did in one tick, k.
struct LoopSample {
  /// X(k) and its derivative as they are; the loop knows only the counts.
  double position = 0;
  double velocity = 0;
  /// The loop's estimate, a_hat(k).
  double acceleration = 0;
  /// F_a(k) as the motor gets it, against the positive direction; it acts after the loop's delay.
  double force = 0;
  /// Force of the hand's spring and damper on device and hand mass, just after kT (eq. 2).
  double hand_force = 0;
};

/// One loop that renders one virtual mass. A loop that is unstable grows until its numbers are infinite, then
/// not numbers; a step never fails. One thread. All but the constructor is Rt.
class LoopSimulation {
 public:
  /// At rest at 0, the sensor too. Precondition: Validate of `loop` and of `imperfections` is empty; `mass`
  /// is finite.
  LoopSimulation(const LoopParameters& loop, double mass, const Imperfections& imperfections = {});

  /// As after a long rest of the estimator at `position`, but with `velocity`; no force acts or is on its
  /// way.
  void Reset(double position, double velocity, double hand_position) noexcept;

  /// Tick k: reads, estimates, commands; then lets time pass to k+1 while the hand moves in a straight line
  /// to `hand_position_next`.
  LoopSample Step(double hand_position_next) noexcept {
    if (auto* smooth = std::get_if<HybridSimulation>(&plant_)) {
      return StepOn(*smooth, hand_position_next);
    }
    if (auto* sensed = std::get_if<AccelerometerSimulation>(&plant_)) {
      return StepOn(*sensed, hand_position_next);
    }
    return StepOn(*std::get_if<FrictionSimulation>(&plant_), hand_position_next);
  }

 private:
  template <typename Plant>
  LoopSample StepOn(Plant& plant, double hand_position_next) noexcept;

  static double Counted(double value, double quantum) noexcept {
    return quantum > 0 ? std::round(value / quantum) * quantum : value;
  }
  double Read(double position) const noexcept { return Counted(position, imperfections_.position_quantum); }
  template <typename Plant>
  double Estimate(const Plant& plant) noexcept {
    if constexpr (requires { plant.sensed(); }) {
      return estimator_.Update(Read(plant.position()), 1,
                               Counted(plant.sensed(), imperfections_.acceleration_quantum));
    } else {
      return estimator_.Update(Read(plant.position()));
    }
  }
  double Deliver(double force) const noexcept {
    // A branch that is foreseen, rather than a clamp to infinity that the next position would wait for.
    if (ideal_motor_) {
      return force;
    }
    const double quantum = imperfections_.force_quantum;
    if (quantum > 0) {
      force = std::clamp(std::round(force / quantum), -largest_counts_, largest_counts_) * quantum;
    }
    return std::clamp(force, -imperfections_.force_limit, imperfections_.force_limit);
  }

  LoopParameters loop_;
  double mass_;
  Imperfections imperfections_;
  /// Neither quantum nor limit of the force.
  bool ideal_motor_;
  /// What the limit leaves of whole counts, where the force has a quantum.
  double largest_counts_;
  AccelerationEstimator estimator_;
  std::variant<HybridSimulation, AccelerometerSimulation, FrictionSimulation> plant_;
};

// Inline for the same reason as HybridSimulation's: a caller that needs one number of a sample pays for one.

template <typename Plant>
LoopSample LoopSimulation::StepOn(Plant& plant, double hand_position_next) noexcept {
  LoopSample sample{.position = plant.position(), .velocity = plant.velocity()};
  const double hand_position = plant.hand_position();
  const double hand_velocity = (hand_position_next - hand_position) / loop_.period_s;
  sample.hand_force = loop_.hand_stiffness * (hand_position - sample.position) +
                      loop_.hand_damping * (hand_velocity - sample.velocity);
  sample.acceleration = Estimate(plant);
  sample.force = Deliver(mass_ * sample.acceleration);
  plant.Command(sample.force);
  plant.Advance(hand_position_next);
  return sample;
}

}  // namespace mwidth::model
