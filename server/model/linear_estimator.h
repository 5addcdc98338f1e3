// What an estimator of acceleration is to the model: a rational function C(z), and nothing else.
//
//   symbol   meaning
//   z        one tick ahead: X(k+1) = z X(k)
//   w        z - 1, one forward difference; about j omega T at low frequency
//   T        sample period
#pragma once

#include <complex>
#include <vector>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// A polynomial in w with real coefficients, the lowest power first. In w, because all that is slow
/// against the sample rate lies near z = 1, where powers of z cancel.
using DifferencePolynomial = std::vector<double>;

/// The value at `w`, and the product. Any thread.
std::complex<double> Evaluate(const DifferencePolynomial& polynomial, std::complex<double> w);
DifferencePolynomial Multiply(const DifferencePolynomial& a, const DifferencePolynomial& b);

/// z = e^(j omega T), with z - 1 kept apart so that it is accurate at low frequency.
struct CircleFrequency {
  std::complex<double> z;
  std::complex<double> w;
};

/// The point of `frequency_hz` (any) at the sample period `period_s` (above 0). Any thread.
CircleFrequency AtFrequency(double frequency_hz, double period_s);

/// C(z) = numerator(w) / denominator(w): sampled position to estimated acceleration. All analyses of accuracy
/// take the estimator from here, so that another one needs its factors and no other change. An estimator of
/// acceleration has (at least) w^2 in its numerator and roots of the denominator inside the unit circle; the
/// numerator's degree is at most the denominator's.
struct LinearEstimator {
  DifferencePolynomial numerator;
  DifferencePolynomial denominator;

  std::complex<double> Response(const CircleFrequency& at) const {
    return Evaluate(numerator, at.w) / Evaluate(denominator, at.w);
  }
};

/// What the loop's AccelerationEstimator computes, from its factors (estimator_factors.h): loop.estimator
/// with loop.period_s and loop.cutoff_hz, for the paper's (eqs. 3, 4), with f = 1 - a,
///
///   C(z) = H(z) D(z) = f w^2 / (T^2 (w + 1) (w + f))
///
/// Throws std::invalid_argument for an accelerometer: what that tells is no function of sampled positions.
/// Precondition: Validate(loop) is empty. Any thread.
LinearEstimator EstimatorOf(const LoopParameters& loop);

/// What follows an accelerometer, sample to estimate: eq. 4, or 1 without a filter. Precondition:
/// Validate(loop) is empty and IsAccelerometer(loop.estimator). Any thread.
LinearEstimator AccelerometerFilter(const LoopParameters& loop);

}  // namespace mwidth::model
