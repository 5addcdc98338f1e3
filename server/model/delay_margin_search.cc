#include "server/model/delay_margin_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "server/model/m_width.h"

namespace mwidth::model {
namespace {

constexpr int kMaxTicks = 3;
constexpr int kPointsPerTick = 64;

LoopParameters WithDelay(LoopParameters loop, double ticks) {
  loop.delay_s = std::min(ticks, static_cast<double>(kMaxTicks)) * loop.period_s;
  return loop;
}

// Delays in ticks, above `first`, ascending to kMaxTicks.
std::vector<double> Delays(const LoopParameters& loop, double first) {
  const double rate = 2 * std::numbers::pi * loop.accelerometer_bandwidth_hz * loop.period_s;
  std::vector<double> delays;
  for (int tick = 0; tick < kMaxTicks; ++tick) {
    for (int i = 1; i <= kPointsPerTick; ++i) {
      delays.push_back(tick + static_cast<double>(i) / kPointsPerTick);
    }
    double left = 0.5 / kPointsPerTick;
    while (left * rate > 1.0 / kPointsPerTick) {
      delays.push_back(tick + 1 - left);
      left /= 2;
    }
  }
  delays.erase(std::remove_if(delays.begin(), delays.end(), [first](double ticks) { return ticks <= first; }),
               delays.end());
  std::sort(delays.begin(), delays.end());
  return delays;
}

}  // namespace

DelayMargin SearchDelayMargin(const LoopParameters& loop, double mass) {
  const double own = loop.delay_s / loop.period_s;
  double inside = own;
  for (double outside : Delays(loop, own)) {
    if (ComputeEdgeMasses(WithDelay(loop, outside)).Contain(mass)) {
      inside = outside;
      continue;
    }
    while (outside - inside > 1e-12 * (outside - own)) {
      const double middle = inside + (outside - inside) / 2;
      if (middle <= inside || middle >= outside) {
        break;
      }
      (ComputeEdgeMasses(WithDelay(loop, middle)).Contain(mass) ? inside : outside) = middle;
    }
    const MWidth lost = ComputeMWidth(WithDelay(loop, outside));
    return {.seconds = (inside - own) * loop.period_s,
            .critical_hz = (mass < 0 ? lost.lower : lost.upper).critical_hz};
  }
  return {.seconds = std::max(kMaxTicks - own, 0.0) * loop.period_s, .at_least = true};
}

}  // namespace mwidth::model
