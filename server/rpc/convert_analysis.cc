#include "server/rpc/convert_analysis.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "server/gate/invalid_number.h"
#include "server/rpc/convert.h"

namespace mwidth::rpc {
namespace {

constexpr double kLargestMass = 1e6;

// As proto3 has it, 0 is a field that was not set.
double Or(double value, double otherwise) { return value == 0 ? otherwise : value; }

std::optional<model::SweepParameter> Parameter(v1::SweepParameter parameter) {
  switch (parameter) {
    case v1::SWEEP_PARAMETER_DEVICE_MASS:
      return model::SweepParameter::kDeviceMass;
    case v1::SWEEP_PARAMETER_DEVICE_DAMPING:
      return model::SweepParameter::kDeviceDamping;
    case v1::SWEEP_PARAMETER_HAND_MASS:
      return model::SweepParameter::kHandMass;
    case v1::SWEEP_PARAMETER_HAND_DAMPING:
      return model::SweepParameter::kHandDamping;
    case v1::SWEEP_PARAMETER_HAND_STIFFNESS:
      return model::SweepParameter::kHandStiffness;
    case v1::SWEEP_PARAMETER_PERIOD_S:
      return model::SweepParameter::kPeriodS;
    case v1::SWEEP_PARAMETER_CUTOFF_HZ:
      return model::SweepParameter::kCutoffHz;
    case v1::SWEEP_PARAMETER_DELAY_S:
      return model::SweepParameter::kDelayS;
    case v1::SWEEP_PARAMETER_ACCELEROMETER_BANDWIDTH_HZ:
      return model::SweepParameter::kAccelerometerBandwidthHz;
    default:
      return std::nullopt;
  }
}

gate::Result<model::SweepRange> ReadRange(const std::string& side, const v1::SweepRange& range) {
  const std::optional<model::SweepParameter> parameter = Parameter(range.parameter());
  if (!parameter) {
    return gate::InvalidNumber(side + ".parameter", range.parameter(), "a SweepParameter, 1 to 9");
  }
  return model::SweepRange{.parameter = *parameter,
                           .min = range.min(),
                           .max = range.max(),
                           .count = range.count(),
                           .logarithmic = range.logarithmic()};
}

model::ParameterRange Read(bool set, const v1::ParameterRange& range, double own) {
  return set ? model::ParameterRange{.min = range.min(), .max = range.max()}
             : model::ParameterRange{.min = own, .max = own};
}

}  // namespace

std::optional<gate::Refusal> CheckEstimator(v1::EstimatorKind estimator) {
  if (v1::EstimatorKind_IsValid(estimator)) {
    return std::nullopt;
  }
  return gate::InvalidNumber("estimator", estimator, "an EstimatorKind, 0 to 6");
}

gate::Result<model::LoopParameters> ReadLoop(const model::LoopParameters& own,
                                             const v1::LoopParameters& overrides) {
  if (auto refusal = CheckEstimator(overrides.estimator())) {
    return *std::move(refusal);
  }
  const model::LoopParameters loop = Override(own, overrides);
  if (const auto error = model::Validate(loop)) {
    return gate::InvalidNumber(*error);
  }
  return loop;
}

bool AsksOfTheAxisItself(const v1::GetMWidthRequest& request) {
  // A message without a field that is set has no size.
  return request.loop().ByteSizeLong() == 0 && !request.has_envelope() && !request.has_tolerance();
}

gate::Result<gate::Requirements> ReadAssumptions(gate::Requirements own, const model::LoopParameters& loop,
                                                 const v1::GetMWidthRequest& request) {
  own.hand.reset();
  own.device.reset();
  if (request.has_envelope()) {
    const v1::HandEnvelope& hand = request.envelope();
    own.hand = {.hand_stiffness = Read(hand.has_stiffness(), hand.stiffness(), loop.hand_stiffness),
                .hand_damping = Read(hand.has_damping(), hand.damping(), loop.hand_damping),
                .hand_mass = Read(hand.has_mass(), hand.mass(), loop.hand_mass),
                .include_released_hand = hand.include_released_hand()};
  }
  if (request.has_tolerance()) {
    const v1::DeviceTolerance& device = request.tolerance();
    own.device = {.device_mass = Read(device.has_mass(), device.mass(), loop.device_mass),
                  .device_damping = Read(device.has_damping(), device.damping(), loop.device_damping)};
  }
  // A single loop is what it is, and has been validated.
  const auto error =
      gate::AssumesOneLoop(loop, own) ? std::nullopt : model::Validate(AssumedLoops(loop, own));
  if (error) {
    return gate::InvalidNumber(*error);
  }
  return own;
}

gate::Result<double> ReadMass(double mass) {
  // Written so that NaN is refused.
  if (!(std::abs(mass) <= kLargestMass)) {
    return gate::InvalidNumber("mass", mass, "-1e6 to 1e6");
  }
  return mass;
}

gate::Result<model::Sweep> ReadSweep(const model::LoopParameters& own,
                                     const v1::SweepMWidthRequest& request) {
  if (auto refusal = CheckEstimator(request.loop().estimator())) {
    return *std::move(refusal);
  }
  // The loop is not validated by itself: what is swept is not used of it.
  model::Sweep sweep{.loop = Override(own, request.loop()), .x = {}, .y = {}};
  const gate::Result<model::SweepRange> x = ReadRange("x", request.x());
  if (!x.ok()) {
    return x.refusal();
  }
  sweep.x = *x;
  if (request.has_y()) {
    const gate::Result<model::SweepRange> y = ReadRange("y", request.y());
    if (!y.ok()) {
      return y.refusal();
    }
    sweep.y = *y;
  }
  if (const auto error = model::Validate(sweep)) {
    return gate::InvalidNumber(*error);
  }
  return sweep;
}

gate::Result<model::MotionBand> ReadBand(const v1::MotionBand& band, double period_s) {
  model::MotionBand read{.lowest_hz = Or(band.min_hz(), gate::kDefaultBand.lowest_hz),
                         .highest_hz = Or(band.max_hz(), gate::kDefaultBand.highest_hz),
                         .duration_s = band.duration_s()};
  if (read.duration_s == 0) {
    read.duration_s = std::max(gate::kDefaultBand.duration_s, 1 / read.lowest_hz);
  }
  if (auto error = model::Validate(read, period_s)) {
    // The API's names.
    if (error->parameter == "lowest_hz") {
      error->parameter = "min_hz";
    } else if (error->parameter == "highest_hz") {
      *error = {"max_hz", error->value, "above band.min_hz, at most half the sample rate"};
    } else {
      error->allowed = "at least 1 / band.min_hz, at most 1e7 sample periods";
    }
    return gate::InvalidNumber(*error, "band.");
  }
  return read;
}

gate::Result<model::FrequencyRange> ReadFrequencies(const v1::GetFrequencyResponseRequest& request,
                                                    double period_s) {
  model::FrequencyRange range;
  range.min_hz = Or(request.min_hz(), range.min_hz);
  range.max_hz = Or(request.max_hz(), 0.5 / period_s);
  range.count = request.count() == 0 ? range.count : request.count();
  if (const auto error = model::Validate(range, period_s)) {
    return gate::InvalidNumber(*error);
  }
  return range;
}

gate::Result<model::ResponseModel> ReadModel(v1::ResponseModel model, const model::LoopParameters& loop) {
  switch (model) {
    case v1::RESPONSE_MODEL_UNSPECIFIED:
    case v1::RESPONSE_MODEL_DISCRETE:
      return model::ResponseModel::kDiscrete;
    case v1::RESPONSE_MODEL_CONTINUOUS:
      if (loop.estimator != model::EstimatorKind::kFilteredDifference) {
        return gate::InvalidNumber("model", model, "RESPONSE_MODEL_DISCRETE (1) with this estimator");
      }
      return model::ResponseModel::kContinuous;
    default:
      return gate::InvalidNumber("model", model, "a ResponseModel, 0 to 2");
  }
}

void Convert(const model::SweepRow& row, v1::SweepMWidthResponse& message) {
  message.set_row(row.row);
  message.set_row_count(row.row_count);
  message.set_y(row.y);
  message.mutable_x()->Add(row.x.begin(), row.x.end());
  message.mutable_min()->Add(row.lower.begin(), row.lower.end());
  message.mutable_max()->Add(row.upper.begin(), row.upper.end());
}

void Convert(const model::Bode& bode, v1::GetFrequencyResponseResponse& message) {
  message.mutable_frequency_hz()->Add(bode.frequency_hz.begin(), bode.frequency_hz.end());
  message.mutable_magnitude_db()->Add(bode.magnitude_db.begin(), bode.magnitude_db.end());
  message.mutable_phase_deg()->Add(bode.phase_deg.begin(), bode.phase_deg.end());
  message.mutable_effective_mass_ratio()->Add(bode.effective_mass_ratio.begin(),
                                              bode.effective_mass_ratio.end());
  message.mutable_effective_damping_ratio()->Add(bode.effective_damping_ratio.begin(),
                                                 bode.effective_damping_ratio.end());
  message.set_effective_missing_reason(bode.effective_missing);
}

void Convert(const gate::MassAccuracy& accuracy, v1::Accuracy& message) {
  message.set_ideal_mass(accuracy.ideal_mass);
  if (accuracy.perceived_mass) {
    message.set_perceived_mass(*accuracy.perceived_mass);
  }
  if (accuracy.error) {
    message.set_error(*accuracy.error);
  }
  if (accuracy.simulated_perceived_mass) {
    message.set_simulated_perceived_mass(*accuracy.simulated_perceived_mass);
  }
  if (accuracy.simulated_error) {
    message.set_simulated_error(*accuracy.simulated_error);
  }
  if (accuracy.force_noise) {
    message.set_force_noise(*accuracy.force_noise);
  }
  message.set_unavailable_reason(accuracy.unavailable_reason);
}

}  // namespace mwidth::rpc
