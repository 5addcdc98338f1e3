// How much of a white noise a stable filter lets through: the squared H2 norm.
#pragma once

#include <optional>

#include "server/model/linear_estimator.h"

namespace mwidth::model {

/// Variance at the output of numerator(w) / denominator(w), w = z - 1, per variance of white noise at its
/// input:
///
///   1/(2 pi) integral over -pi..pi of |numerator / denominator|^2 dt,   z = e^(jt)
///
/// in closed form: the bilinear map takes the circle to the imaginary axis, where Routh's table gives both
/// the verdict on stability and the integral (Astrom, Introduction to Stochastic Control Theory, 1970,
/// chapter 5). None where a root of the denominator is on or outside the circle; a common root at w = 0, left
/// by coefficients that are exactly 0, is cancelled first. The numerator's degree is at most the
/// denominator's; the denominator's highest coefficient is not 0. Any thread.
std::optional<double> WhiteNoiseGain(const DifferencePolynomial& numerator,
                                     const DifferencePolynomial& denominator);

}  // namespace mwidth::model
