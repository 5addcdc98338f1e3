// The README's table of estimators, computed anew.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "server/model/m_width.h"
#include "server/model/robust_interval.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

std::string Format(const char* format, double low, double high) {
  std::array<char, 64> text{};
  EXPECT_GT(std::snprintf(text.data(), text.size(), format, low, high), 0);
  return text.data();
}

// One line: the interval, and what is proved with any delay up to a tick.
std::string Row(const LoopParameters& loop) {
  const MWidth m_width = ComputeMWidth(loop);
  std::string row = std::string("| `") + Name(loop.estimator) + "`";
  if (IsAccelerometer(loop.estimator)) {
    row += Format(", %.0f Hz", loop.accelerometer_bandwidth_hz, 0);
  }
  row +=
      Format(" | %.3f to %.2f", m_width.lower.mass / loop.device_mass, m_width.upper.mass / loop.device_mass);
  row += Format(" | %.1f, %.1f Hz", m_width.lower.critical_hz, m_width.upper.critical_hz);
  LoopEnvelope envelope = EnvelopeOf(loop);
  envelope.delay_bound_s = loop.period_s;
  if (Validate(envelope)) {
    return row + " | - |";
  }
  const RobustCertificate proved = CertifyRobustInterval(envelope);
  return row + Format(" | %.2f to %.1f |", proved.lower.mass / loop.device_mass,
                      proved.upper.mass / loop.device_mass);
}

TEST(EstimatorTable, InTheReadmeIsWhatTheModelComputes) {
  std::ifstream file(TEST_DATA_DIR "/../../server/model/README.md");
  std::stringstream readme;
  readme << file.rdbuf();
  std::vector<LoopParameters> loops;
  for (const EstimatorKind kind : kEstimatorKinds) {
    loops.push_back(TableTwo());
    loops.back().estimator = kind;
  }
  for (const EstimatorKind kind : kAccelerometerKinds) {
    for (const double bandwidth_hz : {10.0, 100.0, 1000.0}) {
      loops.push_back(TableTwo());
      loops.back().estimator = kind;
      loops.back().accelerometer_bandwidth_hz = bandwidth_hz;
    }
  }
  for (const LoopParameters& loop : loops) {
    const std::string row = Row(loop);
    std::cout << row << '\n';
    EXPECT_THAT(readme.str(), testing::HasSubstr(row + "\n"));
  }
}

}  // namespace
}  // namespace mwidth::model
