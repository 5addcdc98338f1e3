#include "server/model/envelope.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

void ExpectError(const LoopEnvelope& envelope, const char* parameter, const char* allowed) {
  const auto error = Validate(envelope);
  ASSERT_TRUE(error.has_value()) << parameter;
  EXPECT_EQ(error->parameter, parameter);
  EXPECT_NE(error->allowed.find(allowed), std::string::npos) << error->allowed;
}

TEST(Envelope, OfALoopIsValid) {
  const LoopEnvelope envelope = EnvelopeOf(TableTwo());
  EXPECT_FALSE(Validate(envelope).has_value());
  EXPECT_EQ(envelope.hand.hand_stiffness, (ParameterRange{700, 700}));
  EXPECT_EQ(envelope, EnvelopeOf(TableTwo()));
}

TEST(Envelope, RefusesAnEmptyBoxByName) {
  for (const auto& [name, range] : {std::pair{"hand_stiffness", &HandEnvelope::hand_stiffness},
                                    std::pair{"hand_damping", &HandEnvelope::hand_damping},
                                    std::pair{"hand_mass", &HandEnvelope::hand_mass}}) {
    LoopEnvelope envelope = EnvelopeOf(TableTwo());
    envelope.hand.*range = {.min = 3, .max = 2};
    ExpectError(envelope, name, "min at most its max (2)");
  }
  for (const auto& [name, range] : {std::pair{"device_mass", &DeviceTolerance::device_mass},
                                    std::pair{"device_damping", &DeviceTolerance::device_damping}}) {
    LoopEnvelope envelope = EnvelopeOf(TableTwo());
    envelope.device.*range = {.min = 3, .max = 2};
    ExpectError(envelope, name, "min at most its max (2)");
  }
}

TEST(Envelope, RefusesWhatIsNotFiniteOrOutOfRangeAtEitherEnd) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LoopEnvelope envelope = EnvelopeOf(TableTwo());
  envelope.hand.hand_stiffness.max = 2e6;
  ExpectError(envelope, "hand_stiffness", "0 to 1e6");
  envelope = EnvelopeOf(TableTwo());
  envelope.hand.hand_damping.min = -1;
  ExpectError(envelope, "hand_damping", "0 to 1e4");
  envelope = EnvelopeOf(TableTwo());
  envelope.device.device_mass.min = nan;
  ExpectError(envelope, "device_mass", "1e-6 to 1e4");
  envelope = EnvelopeOf(TableTwo());
  envelope.device.device_mass.max = std::numeric_limits<double>::infinity();
  ExpectError(envelope, "device_mass", "1e-6 to 1e4");
  envelope = EnvelopeOf(TableTwo());
  envelope.cutoff_hz = 501;
  ExpectError(envelope, "cutoff_hz", "500");
  envelope = EnvelopeOf(TableTwo());
  envelope.delay_bound_s = 3.01e-3;
  ExpectError(envelope, "delay_bound_s", "0.003");
}

TEST(Envelope, OfAnAccelerometerHasItsBandwidth) {
  LoopParameters loop = TableTwo();
  loop.estimator = EstimatorKind::kAccelerometer;
  loop.accelerometer_bandwidth_hz = 100;
  EXPECT_FALSE(Validate(EnvelopeOf(loop)).has_value());
  EXPECT_EQ(EnvelopeOf(loop).accelerometer_bandwidth_hz, 100);
  loop.accelerometer_bandwidth_hz = 0;
  ExpectError(EnvelopeOf(loop), "accelerometer_bandwidth_hz", "0.1 to 1e6");
}

}  // namespace
}  // namespace mwidth::model
