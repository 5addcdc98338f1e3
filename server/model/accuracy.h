// How heavy the rendered mass feels: the least-squares fit of a pure mass to motion and force (eqs. 21 to
// 24).
//
// The motion is that of the paper's Figure 9: the hand follows a chirp of constant amplitude whose frequency
// rises linearly. Acceleration and force are the true ones, sampled once a tick, not the loop's estimate.
//
// The instant of the sample matters. At a tick the actuator's force steps, by M times what the estimate
// gained in a period, and the acceleration steps back by that over m. At Table II, 10 Hz, 1 kHz and M = 3 m
// the error is -0.100 with the acceleration just after the step, -0.147 just before it, and -0.123 averaged
// over the period. The figures of Figure 9 are the first, so that is the default; the average is nearer to
// what a person feels, who cannot tell two sides of a millisecond.
#pragma once

#include <cstdint>
#include <optional>

#include "server/model/frequency_response.h"
#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// Eq. 23, sample by sample: the mass that leaves the least square of force unexplained. One thread.
class LeastSquaresMass {
 public:
  /// Acceleration in m/s^2 or rad/s^2; force of the hand in N or N m. Rt.
  void Add(double acceleration, double hand_force) noexcept {
    explained_ += acceleration * hand_force;
    motion_ += acceleration * acceleration;
  }
  /// kg or kg m^2. None where nothing has moved. Rt.
  std::optional<double> mass() const noexcept {
    return motion_ > 0 ? std::optional(explained_ / motion_) : std::nullopt;
  }

 private:
  double explained_ = 0;
  double motion_ = 0;
};

/// A linear chirp of the hand; its amplitude does not matter to a linear loop.
struct MotionBand {
  double lowest_hz = 0.1;
  double highest_hz = 5;
  double duration_s = 60;
};

/// The first field of `band` that is not allowed at the sample period `period_s`, if any: lowest_hz above 0;
/// highest_hz above lowest_hz, at most 0.5/period_s; duration_s at least 1/lowest_hz, at most 1e7 periods.
std::optional<ParameterError> Validate(const MotionBand& band, double period_s);

/// Whether there is a mass to be felt.
enum class Perception : uint8_t {
  kKnown,     ///< yes
  kUnstable,  ///< the virtual mass is outside the M-width: the hand feels an oscillation that grows
  kNotMoved,  ///< the hand holds with neither stiffness nor damping, and moves nothing
  /// The prediction drowns in rounding errors: damping holds the device so much faster than a tick that its
  /// acceleration is not seen
  kUnresolved,
};

struct PerceivedMass {
  Perception perception = Perception::kNotMoved;
  /// m_hat of eq. 23, which should be m + M; where kKnown.
  double mass = 0;
  /// (m_hat - (m + M)) / (m + M), eq. 24; where kKnown. None where m + M is 0, of which nothing is a
  /// fraction.
  std::optional<double> error = std::nullopt;
};

/// From the frequency response of the sampled loop: a slow chirp dwells on all frequencies alike (stationary
/// phase), so that
///
///   m_hat = integral of Re{F_h conj(X'')} df / integral of |X''|^2 df      over the band
///
/// with complex amplitudes per unit of hand motion. duration_s is not used: it is as if the chirp took for
/// ever. A resonance in the band so sharp that the chirp passes before it has swung in is overrated. `mass`
/// finite. Precondition: Validate(loop) and Validate(band, loop.period_s) are empty. Any thread; some 10 us,
/// with sharp resonances some ms, at most some 100 ms.
PerceivedMass PredictPerceivedMass(const LoopParameters& loop, double mass, const MotionBand& band,
                                   TickInstant instant = TickInstant::kAfterForceStep);

/// From the hybrid system itself, stepped exactly with the estimator that the loop runs, through a chirp that
/// begins at rest at its turning point. Between ticks the drive of the hand follows a
/// parabola, less than (omega T)^3/120 off the chirp. Same conditions. Any thread; as many steps as the chirp
/// has periods, some 100 ns each.
PerceivedMass MeasurePerceivedMass(const LoopParameters& loop, double mass, const MotionBand& band,
                                   TickInstant instant = TickInstant::kAfterForceStep);

}  // namespace mwidth::model
