// What the loop does to a sinusoid: the sampled loop exactly, and the paper's effective mass and damping.
//
//   symbol     meaning
//   X_h, X     hand's and device's position; complex amplitudes of e^(j omega t), here at the ticks t = k T
//   F_h        force of the operator on the device
//   F_a        force of the actuator against it, M C(z) X, held from tick to tick
//   M          virtual mass
//   G(z)       zero-order-hold equivalent of the held mass, with loop delay (plant.h)
#pragma once

#include <complex>
#include <cstdint>
#include <optional>

#include "server/model/accelerometer.h"
#include "server/model/linear_estimator.h"
#include "server/model/loop_parameters.h"
#include "server/model/plant.h"

namespace mwidth::model {

/// The actuator's force steps at a tick (without a fraction of a tick of delay), and the acceleration with
/// it: which side of the step is a sample of it? Elsewhere both are the same.
enum class TickInstant : uint8_t { kBeforeForceStep, kAfterForceStep };

/// Complex amplitudes at the ticks, per unit of hand motion.
struct HandResponse {
  std::complex<double> position;      ///< X / X_h
  std::complex<double> velocity;      ///< 1/s
  std::complex<double> acceleration;  ///< 1/s^2
  /// F_h / X_h, N/m or N m/rad: what the hand feels. Where a hand mass is part of the loop, the force between
  /// it and the device.
  std::complex<double> hand_force;
};

/// The hybrid system in steady state, seen at its ticks; exact, also close to the sample rate. What the
/// staircase of force adds between the ticks is not seen there.
class SampledResponse {
 public:
  /// With the estimator of the loop. Precondition: Validate(loop) is empty.
  explicit SampledResponse(const LoopParameters& loop);
  /// With another one, from positions; those of the loop are not used.
  SampledResponse(const LoopParameters& loop, LinearEstimator estimator);

  /// L = M C(z) G(z) z^-delay at z = e^(j 2 pi f T); 1 + L is the characteristic function. `frequency_hz`
  /// above 0, or at least 0 where the hand has stiffness; at most half the sample rate to be meaningful. Any
  /// thread.
  /// With an accelerometer L = M H(z) A(z) (accelerometer.h).
  std::complex<double> Loop(double mass, double frequency_hz) const;
  /// What a hand that moves as e^(j 2 pi f t), continuously, makes of device and force. Meaningful where
  /// `mass` is inside the M-width: elsewhere no steady state is reached. `frequency_hz` above 0. Any thread.
  HandResponse ToHand(double mass, double frequency_hz,
                      TickInstant instant = TickInstant::kAfterForceStep) const;

 private:
  // Actuator force to position and to velocity at the ticks.
  struct ForceResponse {
    std::complex<double> position;
    std::complex<double> velocity;
  };
  ForceResponse ToForce(const CircleFrequency& at) const;
  // Actuator force to what an accelerometer tells at the ticks.
  std::complex<double> ToSensed(const CircleFrequency& at) const;

  LoopParameters loop_;
  // C(z), or an accelerometer's H(z).
  LinearEstimator estimator_;
  SampledPlant plant_;
  std::optional<SampledAcceleration> acceleration_;
  double newest_impulse_s_;
  double older_impulse_s_;
};

/// G(s) = F_h / X_h of the ideal device, which is nothing but mass: (m + M) s^2 (eq. 16).
std::complex<double> IdealStiffness(const LoopParameters& loop, double mass, double frequency_hz);

/// G(s) = F_h / X_h of the continuous model (eq. 18), and with `mass` 0 that of the device alone (eq. 17):
///
///   G(s) = (b_h s + k_h) Z / (Z + m_h s^2 + b_h s + k_h)     Z = m s^2 + b s + M D(s) H(s) e^(-s tau)
///
/// As printed, eq. 18 has no zero-order hold, although eq. 12 has; it is left out here too: SampledResponse
/// is the one that knows the hold. The loop delay tau is 0 in the paper. Eq. 17 as printed divides by b_h;
/// this form does not. `frequency_hz` above 0. Precondition: Validate(loop) is empty. Any thread.
std::complex<double> RenderedStiffness(const LoopParameters& loop, double mass, double frequency_hz);

/// Eqs. 19 and 20. The signs are right as printed when G is force over position (the paper calls it an
/// admittance). G is taken at the hand's end: towards the resonance of hand and device neither ratio is about
/// the device.
struct EffectiveRatios {
  /// -Re G / (m omega^2): of the ideal device 1 + M/m.
  double mass = 0;
  /// Im G / ((b + b_h) omega): of the ideal device 0. None where nothing damps.
  std::optional<double> damping;
};

/// `stiffness` is G at `frequency_hz`, which is above 0. Any thread.
EffectiveRatios ComputeEffectiveRatios(const LoopParameters& loop, std::complex<double> stiffness,
                                       double frequency_hz);

}  // namespace mwidth::model
