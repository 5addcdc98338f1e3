// A second reason to refuse a mass: a buzzing joint is as useless as an unstable one.
#pragma once

#include "server/model/loop_parameters.h"

namespace mwidth::gate {

/// How much the counts of the encoder, or of the accelerometer, may make the commanded force buzz.
struct ForceNoiseLimit {
  /// Position of one encoder count, m or rad; above 0.
  double position_quantum = 0;
  /// Largest standard deviation of the force, N or N m; above 0.
  double max_force_noise = 0;
  /// Acceleration of one count of the accelerometer, m/s^2 or rad/s^2; 0 where there is none.
  double acceleration_quantum = 0;
};

/// Whether the force noise of `mass` is within the limit; false where the mass is outside of the M-width.
/// Precondition: model::Validate(loop) is empty. Any thread, some 10 us.
bool Keeps(const ForceNoiseLimit& limit, const model::LoopParameters& loop, double mass);

/// The mass nearest to `mass`, towards 0, that keeps the limit: `mass` itself where it does. The answer
/// always keeps it; that nothing nearer does, to one part in 1e9, follows where the noise rises with the size
/// of the mass, as it does up to the edge in every one of thousands of random loops. Same precondition. Any
/// thread, some 0.5 ms.
double NearestQuietMass(const ForceNoiseLimit& limit, const model::LoopParameters& loop, double mass);

}  // namespace mwidth::gate
