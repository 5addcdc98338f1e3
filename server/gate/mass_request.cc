#include "server/gate/mass_request.h"

#include <cmath>
#include <string>

#include "server/gate/figures.h"
#include "server/gate/invalid_number.h"

namespace mwidth::gate {
namespace {

std::string Range(const Interval& interval) {
  return FigureTowardsZero(interval.min) + " to " + FigureTowardsZero(interval.max);
}

std::string Advice(const StabilityReport& report, const std::string& unit) {
  std::string advice = "Ask for " + FigureTowardsZero(report.nearest_admitted_mass) + " " + unit;
  if (report.admitting_cutoff_hz) {
    advice += ", or set the filter's cut-off to " + FigureTowardsZero(*report.admitting_cutoff_hz) + " Hz";
  }
  return advice + ". The mass rendered so far stays.";
}

Refusal NoisyMass(const StabilityReport& report, const AxisDescription& axis) {
  return {.code = RefusalCode::kFailedPrecondition,
          .reason = kNoisyMass,
          .message = "A virtual mass of " + Figure(report.requested_mass) + " " + MassUnit(axis.kind) +
                     " is stable, but makes the force buzz. " + report.binding + " " +
                     Advice(report, MassUnit(axis.kind)),
          .metadata = {{"mass", Figure(report.requested_mass)},
                       {"force_noise", Figure(report.force_noise.value_or(0))},
                       {"force_noise_limit", Figure(axis.force_noise_limit.value_or(0))},
                       {"nearest_admitted_mass", FigureTowardsZero(report.nearest_admitted_mass)}},
          .stability = report};
}

Refusal UnstableMass(const StabilityReport& report, const AxisDescription& axis) {
  const std::string unit = MassUnit(axis.kind);
  Refusal refusal{.code = RefusalCode::kFailedPrecondition,
                  .reason = kUnstableMass,
                  .message = "A virtual mass of " + Figure(report.requested_mass) + " " + unit,
                  .metadata = {{"mass", Figure(report.requested_mass)}},
                  .stability = report};
  const MassRange& range = report.range;
  if (range.admitted.empty()) {
    refusal.message +=
        " cannot be rendered: " + range.admitted.empty_reason + ". Only a mass of 0 is accepted.";
    return refusal;
  }
  refusal.message += " is outside the admitted range of " + Range(range.admitted) + " " + unit +
                     " (the loop is stable from " + Range(range.robust) + " " + unit + ", of which " +
                     Figure(range.required_gain_margin_db) + " dB of gain margin are kept). " +
                     Advice(report, unit);
  refusal.metadata["nearest_admitted_mass"] = FigureTowardsZero(report.nearest_admitted_mass);
  return refusal;
}

}  // namespace

std::optional<Refusal> CheckNumbers(const MassRequest& request, const AxisDescription& axis) {
  if (!std::isfinite(request.mass)) {
    return InvalidNumber("mass", request.mass, "a finite number");
  }
  if (!(request.ramp_s >= 0 && request.ramp_s <= kMaxRampS)) {
    return InvalidNumber("ramp", request.ramp_s, "0 to 10 s; unset means 0.2 s");
  }
  if (request.mass < axis.mass_min || request.mass > axis.mass_max) {
    const std::string unit = " " + MassUnit(axis.kind);
    return Refusal{.code = RefusalCode::kInvalidArgument,
                   .reason = kMassLimit,
                   .message = "A virtual mass of " + Figure(request.mass) + unit +
                              " is outside the limits that are configured for this axis: ask for " +
                              Figure(axis.mass_min) + " to " + Figure(axis.mass_max) + unit + ".",
                   .metadata = {{"mass", Figure(request.mass)},
                                {"mass_min", Figure(axis.mass_min)},
                                {"mass_max", Figure(axis.mass_max)}}};
  }
  return std::nullopt;
}

Refusal InadmissibleMass(const StabilityReport& report, const AxisDescription& axis) {
  return report.noisy ? NoisyMass(report, axis) : UnstableMass(report, axis);
}

}  // namespace mwidth::gate
