#include "server/model/estimator.h"

namespace mwidth::model {

EstimatorFactors FactorsOf(EstimatorKind kind, double period_s, double cutoff_hz) noexcept {
  switch (kind) {
    case EstimatorKind::kLateFilteredDifference:
      return LateFirstOrderLowPass::Factors(period_s, cutoff_hz);
    case EstimatorKind::kButterworth:
      return ButterworthLowPass::Factors(period_s, cutoff_hz);
    case EstimatorKind::kKalman:
      return KalmanLowPass::Factors(period_s, cutoff_hz);
    case EstimatorKind::kFilteredDifference:
    // The filter alone: of an accelerometer there is no C(z).
    case EstimatorKind::kAccelerometer:
    case EstimatorKind::kFilteredAccelerometer:
      break;
  }
  return FirstOrderLowPass::Factors(period_s, cutoff_hz);
}

AccelerationEstimator::LowPass AccelerationEstimator::MakeLowPass(EstimatorKind kind, double period_s,
                                                                  double cutoff_hz) noexcept {
  const EstimatorFactors factors = FactorsOf(kind, period_s, cutoff_hz);
  switch (kind) {
    case EstimatorKind::kLateFilteredDifference:
      return LateFirstOrderLowPass(factors);
    case EstimatorKind::kButterworth:
      return ButterworthLowPass(factors);
    case EstimatorKind::kKalman:
      return KalmanLowPass(factors);
    case EstimatorKind::kAccelerometer:
      return DirectSignal();
    case EstimatorKind::kFilteredDifference:
    case EstimatorKind::kFilteredAccelerometer:
      break;
  }
  return FirstOrderLowPass(factors);
}

AccelerationEstimator::AccelerationEstimator(double period_s, double cutoff_hz, EstimatorKind kind) noexcept
    : period_s_(period_s),
      low_pass_(MakeLowPass(kind, period_s, cutoff_hz)),
      senses_(IsAccelerometer(kind)) {}

AccelerationEstimator AccelerationEstimator::ChangedTo(EstimatorKind kind, double cutoff_hz) const noexcept {
  AccelerationEstimator changed(*this);
  changed.low_pass_ = MakeLowPass(kind, period_s_, cutoff_hz);
  changed.senses_ = IsAccelerometer(kind);
  changed.Settle(acceleration_);
  return changed;
}

}  // namespace mwidth::model
