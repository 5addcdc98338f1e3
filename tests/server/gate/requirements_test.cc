#include "server/gate/requirements.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

TEST(Requirements, AssumeTheLoopItselfWhereNothingElseIsAsked) {
  model::LoopParameters loop = PaperAxis().loop;
  EXPECT_TRUE(AssumesOneLoop(loop, {}));
  loop.delay_s = 1e-3;
  EXPECT_FALSE(AssumesOneLoop(loop, {}));
  EXPECT_EQ(AssumedLoops(loop, {}), model::EnvelopeOf(loop));
}

TEST(Requirements, PutTheirHandsAndDevicesAroundTheLoop) {
  const model::LoopParameters loop = PaperAxis().loop;
  Requirements requirements{.hand = model::EnvelopeOf(loop).hand};
  EXPECT_TRUE(AssumesOneLoop(loop, requirements));
  requirements.hand->include_released_hand = true;
  EXPECT_FALSE(AssumesOneLoop(loop, requirements));
  requirements = {.device = model::DeviceTolerance{.device_mass = {.min = 0.06, .max = 0.08},
                                                   .device_damping = {.min = 0, .max = 1}}};
  const model::LoopEnvelope assumed = AssumedLoops(loop, requirements);
  EXPECT_EQ(assumed.device, requirements.device);
  EXPECT_EQ(assumed.hand, model::EnvelopeOf(loop).hand);
  EXPECT_EQ(assumed.cutoff_hz, loop.cutoff_hz);
  EXPECT_FALSE(AssumesOneLoop(loop, requirements));
}

TEST(Requirements, AssumeTheToleratedDelayWithAnAccelerometer) {
  const Requirements requirements{.delay_tolerance_s = 2.5e-4};
  for (const auto& [estimator, senses] : {std::pair{model::EstimatorKind::kFilteredDifference, false},
                                          std::pair{model::EstimatorKind::kKalman, false},
                                          std::pair{model::EstimatorKind::kAccelerometer, true},
                                          std::pair{model::EstimatorKind::kFilteredAccelerometer, true}}) {
    for (const double delay_s : {0.0, 1e-3}) {
      model::LoopParameters loop = PaperAxis().loop;
      loop.estimator = estimator;
      loop.accelerometer_bandwidth_hz = 100;
      loop.delay_s = delay_s;
      EXPECT_EQ(AssumedLoops(loop, requirements).delay_bound_s, delay_s + (senses ? 2.5e-4 : 0));
      EXPECT_EQ(AssumesOneLoop(loop, requirements), delay_s == 0 && !senses);
      EXPECT_EQ(AssumesOneLoop(loop, {}), delay_s == 0);
    }
  }
}

}  // namespace
}  // namespace mwidth::gate
