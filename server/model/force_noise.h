// How much the commanded force buzzes because the encoder counts, or because the accelerometer is noisy.
//
// An encoder that resolves q adds an error within -q/2..q/2 to every position. While the joint moves over
// many counts a period, and not at a constant speed, the errors are as good as white, of variance q^2/12. The
// estimator takes their second difference over T^2: M q/T^2 is a large force.
//
// A slow or resting joint is outside of that assumption: its errors are correlated, and at rest they are
// constant or a limit cycle. Then the figure is an estimate and no bound.
#pragma once

#include <optional>

#include "server/model/linear_estimator.h"
#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// Standard deviation of M C(z) N: the noise of the estimate times the mass, as if the device did not
/// move under it. N or N m. For the paper's estimator, with f = 1 - a,
///
///   |M| q/sqrt(12) f/T^2 sqrt(1 + (1 + f)^2 + f^3/(2 - f))
///
/// `position_quantum` is q, at least 0. None where the estimator is not stable. Any thread.
std::optional<double> OpenLoopForceNoise(const LinearEstimator& estimator, double mass,
                                         double position_quantum);

/// Standard deviation of M C / (1 + M C G z^-delay) N, N or N m: with the device that the noise moves, and
/// that is measured again. This is the one to limit: near an edge of the M-width the loop rings with
/// every count, and the open loop would not tell. None where `mass` is outside of the M-width.
///
/// An accelerometer does not see the encoder: with one, AccelerometerForceNoise of its own counts, whose
/// noise is white while the acceleration changes by many of them. `position_quantum`, m or rad, and
/// `acceleration_quantum`, m/s^2 or rad/s^2, at least 0. Precondition: Validate(loop) is empty. Any thread.
std::optional<double> ForceNoise(const LoopParameters& loop, double mass, double position_quantum,
                                 double acceleration_quantum = 0);

/// Standard deviation of M H / (1 + M H A) N with an accelerometer whose samples have white noise N of
/// standard deviation `sample_noise`, at least 0, m/s^2 or rad/s^2 (accelerometer.h has A). A sensor whose
/// noise has the density S below its bandwidth, in m/s^2/sqrt(Hz), has about S sqrt(pi/2 bandwidth). None
/// where `mass` is outside of the M-width. Precondition: Validate(loop) is empty and
/// IsAccelerometer(loop.estimator). Any thread.
std::optional<double> AccelerometerForceNoise(const LoopParameters& loop, double mass, double sample_noise);

}  // namespace mwidth::model
