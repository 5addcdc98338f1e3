#include "server/model/delay_margin_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

LoopParameters Later(LoopParameters loop, double seconds) {
  loop.delay_s += seconds;
  return loop;
}

// Sensors slow and fast against the tick, masses from a tenth of an edge to 0.999 of it: nothing before the
// margin loses the mass, on a grid of its own, and just behind it does.
TEST(SearchDelayMargin, IsWhereTheMWidthLosesTheMass) {
  RandomLoops random(61);
  int finite = 0;
  for (int i = 0; i < 300; ++i) {
    LoopParameters loop = random.Next();
    loop.estimator = kAccelerometerKinds.at(static_cast<std::size_t>(i) % 2);
    loop.accelerometer_bandwidth_hz = std::clamp(random.LogUniform(0.01, 50) / loop.period_s, 0.1, 1e6);
    loop.delay_s = i % 3 == 0 ? loop.period_s * random.Uniform(0, 2) : 0;
    const MWidth m_width = ComputeMWidth(loop);
    const double mass = (1 - random.LogUniform(1e-3, 0.9)) *
                        (random.Uniform(0, 1) < 0.5 ? m_width.lower.mass : m_width.upper.mass);
    const DelayMargin margin = SearchDelayMargin(loop, mass);
    for (int k = 0; k < 200; ++k) {
      const double seconds = margin.seconds * random.Uniform(0, 1) * (1 - 1e-9);
      ASSERT_TRUE(ComputeMWidth(Later(loop, seconds)).Contains(mass)) << i << " after " << seconds;
    }
    if (margin.at_least) {
      EXPECT_NEAR(loop.delay_s + margin.seconds, 3 * loop.period_s, 1e-12 * loop.period_s);
      continue;
    }
    ++finite;
    EXPECT_FALSE(ComputeMWidth(Later(loop, margin.seconds * (1 + 1e-9) + 1e-15)).Contains(mass)) << i;
    EXPECT_GT(margin.critical_hz, 0);
  }
  EXPECT_GT(finite, 100);
}

}  // namespace
}  // namespace mwidth::model
