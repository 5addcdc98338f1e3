// Any parameters: a typed error that names one of them, or an interval around zero that keeps its promises.
#include <cmath>

#include "server/model/m_width.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  using mwidth::fuzz::Require;
  mwidth::fuzz::Input input(data, size);
  mwidth::model::LoopParameters loop;
  loop.device_mass = input.Number(1e-6, 10);
  loop.device_damping = input.Number(0, 10);
  loop.hand_mass = input.Number(0, 1);
  loop.hand_damping = input.Number(0, 300);
  loop.hand_stiffness = input.Number(0, 3e4);
  loop.period_s = input.Number(1e-5, 1e-2);
  loop.cutoff_hz = input.Number(0.1, 0.5 / loop.period_s);
  loop.delay_s = input.Number(0, 3 * loop.period_s);
  if (const auto error = mwidth::model::Validate(loop)) {
    Require(!error->parameter.empty() && !error->allowed.empty() && !error->Message().empty(),
            "a named error");
    return 0;
  }
  const mwidth::model::MWidth m_width = mwidth::model::ComputeMWidth(loop);
  if (m_width.empty()) {
    // What damping takes out of one period may underflow to nothing.
    const double lost =
        (loop.device_damping + loop.hand_damping) * loop.period_s / (loop.device_mass + loop.hand_mass);
    Require(lost < 1e-300 && loop.hand_stiffness > 0, "empty only without damping");
    return 0;
  }
  Require(m_width.lower.mass < 0 && m_width.upper.mass > 0, "zero lies inside");
  Require(m_width.lower.critical_hz >= 0 && m_width.upper.critical_hz <= 0.51 / loop.period_s,
          "critical frequencies");
  const double mass = input.Number(m_width.lower.mass * 2, m_width.upper.mass * 2);
  const double margin = mwidth::model::GainMargin(m_width, mass);
  Require(std::isnan(mass) || m_width.Contains(mass) == (margin > 1),
          "the gain margin agrees with the interval");
  return 0;
}
