#include "client/cli/loop_words.h"

#include <cmath>
#include <vector>

#include "client/cli/estimator_name.h"
#include "client/cli/numbers.h"

namespace mwidth::cli {
namespace {

constexpr double kMsPerS = 1e3;

// What hands, devices and delays may differ in.
struct Parameter {
  const char* name;
  double (v1::LoopParameters::*value)() const;
  Unit unit;
  double scale = 1;
};

// "hand damping 2 N s/m" for each parameter that differs between the two loops.
void AddDifferences(const std::vector<Parameter>& parameters, const v1::LoopParameters& binding,
                    const v1::LoopParameters& loop, std::vector<std::string>& parts) {
  for (const auto& [name, value, unit, scale] : parameters) {
    if ((binding.*value)() != (loop.*value)()) {
      parts.push_back(name + (" " + Quantity(scale * (binding.*value)(), unit)));
    }
  }
}

std::string Join(const std::vector<std::string>& parts, const std::string& instead) {
  std::string text;
  for (const auto& part : parts) {
    text += (text.empty() ? "" : ", ") + part;
  }
  return text.empty() ? instead : text;
}

// "3.25 Hz" as where a margin is used up; nothing where it never is.
std::string At(double frequency_hz) {
  return frequency_hz == 0 ? "" : " (at " + Rounded(frequency_hz, 3) + " Hz)";
}

std::string Figure(double value) { return std::isinf(value) && value > 0 ? "unlimited" : Rounded(value, 3); }

std::string Figure(double value, const char* unit) {
  return std::isinf(value) && value > 0 ? Figure(value) : Figure(value) + " " + unit;
}

}  // namespace

std::string Quantity(double value, const Unit& unit) { return Rounded(value) + " " + unit.text; }

std::string IntervalText(const v1::Interval& interval, const Units& units) {
  if (interval.empty()) {
    return "none: " + interval.empty_reason();
  }
  return "from " + RoundedTowardZero(interval.min()) + " to " + RoundedTowardZero(interval.max()) + " " +
         units.mass.text;
}

std::string FilterText(const v1::LoopParameters& loop) {
  std::string text = EstimatorName(loop.estimator());
  const bool filtered = loop.estimator() == v1::ESTIMATOR_KIND_FILTERED_ACCELEROMETER;
  if (filtered || loop.estimator() == v1::ESTIMATOR_KIND_ACCELEROMETER) {
    text += " of " + Rounded(loop.accelerometer_bandwidth_hz()) + " Hz";
    if (!filtered) {
      return text;
    }
  }
  return text + ", cut-off " + Rounded(loop.cutoff_hz()) + " Hz";
}

std::string LoopText(const v1::LoopParameters& loop, const Units& units) {
  return "device " + Quantity(loop.device_mass(), units.mass) + ", " +
         Quantity(loop.device_damping(), units.damping) + "; hand " + Quantity(loop.hand_mass(), units.mass) +
         ", " + Quantity(loop.hand_damping(), units.damping) + ", " +
         Quantity(loop.hand_stiffness(), units.stiffness) + "; " + Rounded(1 / loop.period_s()) + " Hz; " +
         FilterText(loop) + "; delay " + Rounded(kMsPerS * loop.delay_s()) + " ms";
}

Assumptions AssumptionsOf(const v1::AxisInfo& axis) {
  return {axis.has_envelope() ? std::optional(axis.envelope()) : std::nullopt,
          axis.has_tolerance() ? std::optional(axis.tolerance()) : std::nullopt};
}

std::string AssumptionsText(const Assumptions& assumptions, const v1::LoopParameters& loop,
                            const Units& units) {
  std::vector<std::string> parts;
  const auto add = [&](const std::string& name, bool set, const v1::ParameterRange& range, double own,
                       const Unit& unit) {
    if (set && (range.min() != own || range.max() != own)) {
      const auto from = range.min() == range.max() ? "" : Rounded(range.min()) + " to ";
      parts.push_back(name + " " + from + Quantity(range.max(), unit));
    }
  };
  if (const auto& hand = assumptions.envelope) {
    add("hand stiffness", hand->has_stiffness(), hand->stiffness(), loop.hand_stiffness(), units.stiffness);
    add("hand damping", hand->has_damping(), hand->damping(), loop.hand_damping(), units.damping);
    add("hand mass", hand->has_mass(), hand->mass(), loop.hand_mass(), units.mass);
    if (hand->include_released_hand()) {
      parts.emplace_back("a released hand");
    }
  }
  if (const auto& device = assumptions.tolerance) {
    add("device mass", device->has_mass(), device->mass(), loop.device_mass(), units.mass);
    add("device damping", device->has_damping(), device->damping(), loop.device_damping(), units.damping);
  }
  if (loop.delay_s() > 0) {
    parts.push_back("delay 0 to " + Rounded(kMsPerS * loop.delay_s()) + " ms");
  }
  return Join(parts, kThisLoopAlone);
}

std::string BindingText(const v1::LoopParameters& binding, const v1::LoopParameters& loop,
                        const Units& units) {
  using Loop = v1::LoopParameters;
  std::vector<std::string> parts;
  if (binding.hand_stiffness() == 0 && binding.hand_damping() == 0 &&
      (loop.hand_stiffness() != 0 || loop.hand_damping() != 0)) {
    parts.emplace_back("a released hand");
  } else {
    AddDifferences({{"hand stiffness", &Loop::hand_stiffness, units.stiffness},
                    {"hand damping", &Loop::hand_damping, units.damping}},
                   binding, loop, parts);
  }
  AddDifferences({{"hand mass", &Loop::hand_mass, units.mass},
                  {"device mass", &Loop::device_mass, units.mass},
                  {"device damping", &Loop::device_damping, units.damping},
                  {"delay", &Loop::delay_s, {"ms", "ms"}, kMsPerS}},
                 binding, loop, parts);
  return Join(parts, "the nominal loop");
}

std::string MarginsText(const v1::StabilityMargins& margins) {
  return "gain " + Figure(margins.gain_db(), "dB") + At(margins.gain_hz()) + ", phase " +
         Figure(margins.phase_deg(), "deg") + At(margins.phase_hz()) + ", delay " +
         Figure(kMsPerS * margins.delay_s(), "ms") + (margins.delay_at_least() ? " or more" : "") +
         At(margins.delay_hz()) + ", modulus " + Figure(margins.modulus()) + At(margins.modulus_hz());
}

}  // namespace mwidth::cli
