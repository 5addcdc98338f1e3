// Any envelope: a typed error, or a robust interval inside the M-width of every loop of the envelope that is
// tried.
#include "server/model/m_width.h"
#include "server/model/robust_interval.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using mwidth::fuzz::Input;
using mwidth::model::ParameterRange;

ParameterRange Range(Input& input, double min, double max) {
  const double from = input.Number(min, max);
  return {from, input.Number(from, max)};
}

double Within(Input& input, const ParameterRange& range) {
  return range.min + (range.max - range.min) * input.Take<uint8_t>() / 255.0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using mwidth::fuzz::Require;
  Input input(data, size);
  mwidth::model::LoopEnvelope envelope;
  envelope.hand.hand_stiffness = Range(input, 0, 3000);
  envelope.hand.hand_damping = Range(input, 0, 50);
  envelope.hand.hand_mass = Range(input, 0, 0.5);
  envelope.hand.include_released_hand = input.Take<uint8_t>() % 2 == 0;
  envelope.device.device_mass = Range(input, 0.01, 1);
  envelope.device.device_damping = Range(input, 0, 1);
  envelope.period_s = input.Number(2e-4, 2e-3);
  envelope.cutoff_hz = input.Number(1, 200);
  envelope.delay_bound_s = input.Number(0, 3 * envelope.period_s);
  envelope.estimator = static_cast<mwidth::model::EstimatorKind>(input.Take<uint8_t>() % 6);
  envelope.accelerometer_bandwidth_hz = input.Number(1, 2000);
  if (const auto error = mwidth::model::Validate(envelope)) {
    Require(!error->parameter.empty() && !error->allowed.empty(), "a named error");
    return 0;
  }
  const auto certificate = mwidth::model::CertifyRobustInterval(envelope);
  if (certificate.empty()) {
    return 0;
  }
  for (int i = 0; i < 16; ++i) {
    const mwidth::model::LoopParameters loop{
        .device_mass = Within(input, envelope.device.device_mass),
        .device_damping = Within(input, envelope.device.device_damping),
        .hand_mass = Within(input, envelope.hand.hand_mass),
        .hand_damping = Within(input, envelope.hand.hand_damping),
        .hand_stiffness = Within(input, envelope.hand.hand_stiffness),
        .period_s = envelope.period_s,
        .cutoff_hz = envelope.cutoff_hz,
        .delay_s = Within(input, {0, envelope.delay_bound_s}),
        .estimator = envelope.estimator,
        .accelerometer_bandwidth_hz = envelope.accelerometer_bandwidth_hz};
    const auto m_width = mwidth::model::ComputeMWidth(loop);
    Require(!m_width.empty(), "a loop without an M-width makes the robust interval empty");
    // The nominal edge itself is rounded: by less than 1e-12 of it.
    Require(certificate.lower.mass >= m_width.lower.mass * (1 + 1e-12), "robust at the lower edge");
    Require(certificate.upper.mass <= m_width.upper.mass * (1 + 1e-12), "robust at the upper edge");
  }
  return 0;
}
