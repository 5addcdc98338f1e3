// Which estimators of acceleration there are.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace mwidth::model {

/// Where the loop has its acceleration from. The first four are what follows the double backward difference
/// of the sampled positions, D(z) = (z - 1)^2 / (T z)^2 (eq. 3).
enum class EstimatorKind : uint8_t {
  /// The paper's H(z) = (1 - a) z / (z - a), a = e^(-w0 T) (eq. 4).
  kFilteredDifference,
  /// The same without the z in its numerator: (1 - a) / (z - a). What a loop runs that filters the difference
  /// of
  /// the tick before; one tick more of lag.
  kLateFilteredDifference,
  /// Second-order Butterworth low-pass filter, by the bilinear transform, exactly -3 dB at the cut-off.
  kButterworth,
  /// Steady-state Kalman filter of a target of constant acceleration (alpha-beta-gamma filter). Its gains
  /// follow
  /// from the cut-off at which the estimate is exactly 3 dB below the double difference.
  kKalman,
  /// An accelerometer's signal, low-passed by the sensor's own bandwidth w_a/(s + w_a) and sampled at the
  /// tick, as it is (accelerometer.h). The cut-off does not matter.
  kAccelerometer,
  /// The same behind the paper's H(z) (eq. 4).
  kFilteredAccelerometer,
};

/// All that need nothing but positions.
inline constexpr std::array<EstimatorKind, 4> kEstimatorKinds{
    EstimatorKind::kFilteredDifference, EstimatorKind::kLateFilteredDifference, EstimatorKind::kButterworth,
    EstimatorKind::kKalman};

/// All that need an accelerometer, too.
inline constexpr std::array<EstimatorKind, 2> kAccelerometerKinds{EstimatorKind::kAccelerometer,
                                                                  EstimatorKind::kFilteredAccelerometer};

/// True for the kinds of kAccelerometerKinds. Any thread. Rt.
constexpr bool IsAccelerometer(EstimatorKind kind) noexcept {
  return kind == EstimatorKind::kAccelerometer || kind == EstimatorKind::kFilteredAccelerometer;
}

/// "filtered-difference", "late-filtered-difference", "butterworth", "kalman", "accelerometer" or
/// "filtered-accelerometer", as configurations and messages have it; "unknown" for any other value. Any
/// thread. Rt.
const char* Name(EstimatorKind kind) noexcept;

/// The kind of that name, if any, accelerometers included. Any thread. Rt.
std::optional<EstimatorKind> EstimatorNamed(std::string_view name) noexcept;

/// Cut-off frequencies that an estimator runs with, as fractions of the sample rate.
struct CutoffRange {
  double min = 0;
  double max = 0;
};

/// Up to half the sample rate, where the filter's poles allow it: those of the bilinear transform reach the
/// unit circle there, so Butterworth's ends at 0.49. Filters of higher order begin at 1e-9, below which their
/// coefficients mean nothing in double precision; the first-order ones at 0, excluded. `kind` is one of
/// kEstimatorKinds or kAccelerometerKinds. Any thread. Rt.
CutoffRange CutoffRangeOf(EstimatorKind kind) noexcept;

/// True where `cutoff_hz` is above 0 and inside `range` at the sample period `period_s`, up to rounding;
/// false for NaN. Any thread. Rt.
bool Contains(const CutoffRange& range, double period_s, double cutoff_hz) noexcept;

/// True where AccelerationEstimator runs `kind`, one of kEstimatorKinds or kAccelerometerKinds, at
/// `cutoff_hz` with the sample period `period_s`; false for NaN. Any thread. Rt.
bool Runs(EstimatorKind kind, double period_s, double cutoff_hz) noexcept;

}  // namespace mwidth::model
