// The paper's continuous model of the loop: for insight and Bode plots. What is admitted is decided by the
// discrete model (m_width.h), which equals the hybrid one; this one only resembles it.
//
//   symbol   meaning                  here
//   mu       moving mass m + m_h      device_mass + hand_mass
//   beta     damping b + b_h          device_damping + hand_damping
//   k        stiffness k_h            hand_stiffness
//   tau      loop delay               delay_s (0 in the paper)
//   w*       phase crossing           2 pi Edge::critical_hz
//
// It has the paper's filter, whatever LoopParameters::estimator says.
#pragma once

#include <complex>

#include "server/model/loop_parameters.h"
#include "server/model/m_width.h"

namespace mwidth::model {

/// D(s) H(s) at s = j 2 pi f: how position becomes an estimate of acceleration, 1/s^2.
///
///   D(s) = 4 s^2 / (s T + 2)^2     H(s) = w0 / (s + w0)                                  (eqs. 6, 7)
///
/// `frequency_hz` at least 0. Precondition: Validate(loop) is empty. Any thread.
std::complex<double> ContinuousEstimator(const LoopParameters& loop, double frequency_hz);

/// L(s) at s = j 2 pi f, of which 1 + L is the characteristic function (eqs. 11 to 14, for any units):
///
///   L(s) = M D(s) H(s) e^(-s T/2) e^(-s tau) / (mu s^2 + beta s + k)
///
/// Eq. 12 as printed has four zeros at the origin: s^2 once in D and once more with the plant. The plant of
/// eq. 9 has no zeros, so the loop has the two of D. `mass` is M; `frequency_hz` above 0, or at least 0 where
/// k > 0. Precondition: Validate(loop) is empty. Any thread.
std::complex<double> ContinuousLoop(const LoopParameters& loop, double mass, double frequency_hz);

/// The continuous model's M-width: the open interval around 0 inside of which every root of 1 + L has a
/// negative real part. At each edge L(j w*) = -1. critical_hz is w*/2 pi; it is 0 for the free mass without
/// friction, which loses its stability at M = -mu by drifting off. Empty for the same reason as the discrete
/// one.
///
/// Precondition: Validate(loop) is empty. Any thread.
MWidth ComputeContinuousMWidth(const LoopParameters& loop);

}  // namespace mwidth::model
