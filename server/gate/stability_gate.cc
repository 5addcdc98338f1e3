#include "server/gate/stability_gate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "server/gate/figures.h"
#include "server/model/force_noise.h"

namespace mwidth::gate {
namespace {

constexpr double kMaxMarginDb = 60;

Interval Shrunk(const Interval& interval, double factor) {
  return {.min = interval.min / factor, .max = interval.max / factor, .empty_reason = interval.empty_reason};
}

// The mass nearest to `mass` strictly inside `admitted` and within `limits`; 0 where `admitted` is empty.
double NearestAdmitted(double mass, const Interval& admitted, const MassLimits& limits) {
  if (admitted.empty()) {
    return 0;
  }
  const double within = std::clamp(mass, limits.min, limits.max);
  return std::clamp(within, std::nextafter(admitted.min, 0.0), std::nextafter(admitted.max, 0.0));
}

}  // namespace

StabilityGate::StabilityGate(const model::LoopParameters& loop, double required_gain_margin_db,
                             std::optional<ForceNoiseLimit> noise_limit)
    : loop_(loop), margin_factor_(std::pow(10.0, required_gain_margin_db / 20.0)), noise_limit_(noise_limit) {
  if (const auto error = model::Validate(loop)) {
    throw std::invalid_argument(error->Message());
  }
  if (!(required_gain_margin_db >= 0 && required_gain_margin_db <= kMaxMarginDb)) {
    throw std::invalid_argument("the required gain margin is " + Figure(required_gain_margin_db) +
                                " dB: 0 to 60 dB are allowed");
  }
  if (noise_limit_ && !(noise_limit_->position_quantum > 0 && noise_limit_->max_force_noise > 0)) {
    throw std::invalid_argument(
        "a limit on the force noise and the encoder's count that it is for must be above 0");
  }
  m_width_ = model::ComputeMWidth(loop);
  range_.required_gain_margin_db = required_gain_margin_db;
  if (m_width_.empty()) {
    range_.nominal.empty_reason = m_width_.empty_reason;
  } else {
    range_.nominal = {.min = m_width_.lower.mass, .max = m_width_.upper.mass, .empty_reason = {}};
    range_.min_critical_hz = m_width_.lower.critical_hz;
    range_.max_critical_hz = m_width_.upper.critical_hz;
  }
  range_.robust = range_.nominal;
  range_.admitted = Shrunk(range_.robust, margin_factor_);
}

bool StabilityGate::Admits(const model::LoopParameters& loop, double mass) const {
  return model::ComputeMWidth(loop).Contains(mass * margin_factor_) &&
         (!noise_limit_ || Keeps(*noise_limit_, loop, mass));
}

StabilityReport StabilityGate::Judge(double mass, const MassLimits& limits, model::AxisKind kind) const {
  StabilityReport report{.admitted = mass == 0 || range_.admitted.Contains(mass),
                         .noisy = false,
                         .requested_mass = mass,
                         .range = range_,
                         .loop = loop_,
                         .gain_margin_db = 20 * std::log10(model::GainMargin(m_width_, mass)),
                         .critical_hz = mass < 0 ? range_.min_critical_hz : range_.max_critical_hz,
                         .force_noise = {},
                         .binding = {},
                         .nearest_admitted_mass = NearestAdmitted(mass, range_.admitted, limits),
                         .admitting_cutoff_hz = {}};
  if (noise_limit_) {
    report.force_noise = model::ForceNoise(loop_, mass, noise_limit_->position_quantum);
    report.noisy = report.admitted && mass != 0 && !Keeps(*noise_limit_, loop_, mass);
    report.admitted = report.admitted && !report.noisy;
    report.nearest_admitted_mass = NearestQuietMass(*noise_limit_, loop_, report.nearest_admitted_mass);
  }
  report.binding = Binding(report, kind);
  if (!report.admitted && !range_.admitted.empty()) {
    report.admitting_cutoff_hz = model::HighestAdmittingCutoffHz(loop_.cutoff_hz, [&](double cutoff_hz) {
      model::LoopParameters candidate = loop_;
      candidate.cutoff_hz = cutoff_hz;
      return Admits(candidate, mass);
    });
  }
  return report;
}

std::string StabilityGate::Binding(const StabilityReport& report, model::AxisKind kind) const {
  if (range_.admitted.empty()) {
    return range_.admitted.empty_reason;
  }
  if (report.noisy) {
    return "The encoder's counts of " + Figure(noise_limit_->position_quantum) + " " + PositionUnit(kind) +
           " put a noise of " + Figure(report.force_noise.value_or(0)) + " " + ForceUnit(kind) +
           " on the force (standard deviation); " + Figure(noise_limit_->max_force_noise) + " " +
           ForceUnit(kind) + " are allowed.";
  }
  const bool lower = report.requested_mass < 0;
  const double edge = lower ? range_.nominal.min : range_.nominal.max;
  std::string binding = "With its nominal parameters the loop oscillates at " + Figure(report.critical_hz) +
                        " Hz when the mass reaches " + Figure(edge) + " " + MassUnit(kind);
  if (loop_.delay_s > 0) {
    binding += " (its delay of " + Figure(1e3 * loop_.delay_s) + " ms counted)";
  }
  return binding + "; a gain margin of " + Figure(range_.required_gain_margin_db) + " dB is kept from there.";
}

}  // namespace mwidth::gate
