#include "server/gate/stability_gate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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

void Check(const model::LoopParameters& loop, const Requirements& requirements) {
  if (const auto error = model::Validate(loop)) {
    throw std::invalid_argument(error->Message());
  }
  const auto error =
      AssumesOneLoop(loop, requirements) ? std::nullopt : model::Validate(AssumedLoops(loop, requirements));
  if (error) {
    throw std::invalid_argument("the envelope: " + error->Message());
  }
  if (!(requirements.gain_margin_db >= 0 && requirements.gain_margin_db <= kMaxMarginDb)) {
    throw std::invalid_argument("the required gain margin is " + Figure(requirements.gain_margin_db) +
                                " dB: 0 to 60 dB are allowed");
  }
  const auto& noise = requirements.noise_limit;
  if (noise && !(noise->position_quantum > 0 && noise->max_force_noise > 0)) {
    throw std::invalid_argument(
        "a limit on the force noise and the encoder's count that it is for must be above 0");
  }
}

}  // namespace

StabilityGate::StabilityGate(const model::LoopParameters& loop, const Requirements& requirements,
                             std::shared_ptr<model::CertificateCache> certificates)
    : loop_(loop),
      requirements_(requirements),
      certificates_(std::move(certificates)),
      margin_factor_(std::pow(10.0, requirements.gain_margin_db / 20.0)) {
  Check(loop, requirements);
  range_.required_gain_margin_db = requirements.gain_margin_db;
  TakeNominal();
  TakeRobust();
  range_.admitted = Shrunk(range_.robust, margin_factor_);
}

void StabilityGate::TakeNominal() {
  m_width_ = model::ComputeMWidth(loop_);
  if (m_width_.empty()) {
    range_.nominal.empty_reason = m_width_.empty_reason;
    return;
  }
  range_.nominal = {.min = m_width_.lower.mass, .max = m_width_.upper.mass, .empty_reason = {}};
  range_.min_critical_hz = m_width_.lower.critical_hz;
  range_.max_critical_hz = m_width_.upper.critical_hz;
}

void StabilityGate::TakeRobust() {
  if (AssumesOneLoop(loop_, requirements_)) {
    range_.robust = range_.nominal;
    if (!range_.robust.empty()) {
      range_.min_binding = loop_;
      range_.max_binding = loop_;
    }
    return;
  }
  certificate_ = certificates_->Get(AssumedLoops(loop_, requirements_));
  if (certificate_->empty()) {
    range_.robust.empty_reason = certificate_->empty_reason;
    return;
  }
  range_.robust = {.min = certificate_->lower.mass, .max = certificate_->upper.mass, .empty_reason = {}};
  range_.min_binding = certificate_->lower.binding;
  range_.max_binding = certificate_->upper.binding;
}

double StabilityGate::lower_critical_hz() const {
  if (range_.robust.empty()) {
    return 0;
  }
  return certificate_ ? certificate_->lower.binding_edge.critical_hz : range_.min_critical_hz;
}

StabilityReport StabilityGate::Judge(double mass, const MassLimits& limits, model::AxisKind kind) const {
  StabilityReport report{.admitted = mass == 0 || range_.admitted.Contains(mass),
                         .noisy = false,
                         .requested_mass = mass,
                         .range = range_,
                         .loop = loop_,
                         .gain_margin_db = 20 * std::log10(model::GainMargin(m_width_, mass)),
                         .critical_hz = mass < 0 ? range_.min_critical_hz : range_.max_critical_hz,
                         .margins = WorstMargins(mass),
                         .force_noise = {},
                         .binding = {},
                         .nearest_admitted_mass = NearestAdmitted(mass, range_.admitted, limits),
                         .admitting_cutoff_hz = {}};
  if (range_.robust.empty()) {
    report.critical_hz = 0;
  } else if (certificate_) {
    report.critical_hz = (mass < 0 ? certificate_->lower : certificate_->upper).binding_edge.critical_hz;
  }
  if (const auto& limit = requirements_.noise_limit) {
    report.force_noise = model::ForceNoise(loop_, mass, limit->position_quantum, limit->acceleration_quantum);
    report.noisy = report.admitted && mass != 0 && !Keeps(*limit, loop_, mass);
    report.admitted = report.admitted && !report.noisy;
    report.nearest_admitted_mass = NearestQuietMass(*limit, loop_, report.nearest_admitted_mass);
  }
  report.binding = Binding(report, kind);
  if (!report.admitted && !range_.admitted.empty()) {
    report.admitting_cutoff_hz = AdmittingCutoffHz(mass);
  }
  return report;
}

bool StabilityGate::AdmitsNominally(double cutoff_hz, double mass, double factor) const {
  model::LoopParameters candidate = loop_;
  candidate.cutoff_hz = cutoff_hz;
  return model::ComputeMWidth(candidate).Contains(mass * factor) &&
         (!requirements_.noise_limit || Keeps(*requirements_.noise_limit, candidate, mass));
}

std::optional<double> StabilityGate::AdmittingCutoffHz(double mass) const {
  // With an accelerometer the edges of several loops do not keep their ratio, and every proof may take
  // seconds: a client has given up by then.
  if (certificate_ && model::IsAccelerometer(loop_.estimator)) {
    return std::nullopt;
  }
  // Of several loops the robust edge is searched by way of the nominal one, whose ratio to it changes little
  // with the cut-off, so that few certificates have to be proved. Only what is proved is answered.
  constexpr int kMostProofs = 8;
  constexpr double kStep = 1.002;
  const auto nominal_to_robust = [mass](const model::MWidth& nominal,
                                        const model::RobustCertificate& robust) {
    return mass < 0 ? nominal.lower.mass / robust.lower.mass : nominal.upper.mass / robust.upper.mass;
  };
  double factor = margin_factor_ * (certificate_ ? nominal_to_robust(m_width_, *certificate_) : 1);
  for (int proof = 0; proof < kMostProofs; ++proof) {
    const std::optional<double> cutoff_hz = model::HighestAdmittingCutoffHz(
        loop_.cutoff_hz, [&](double candidate_hz) { return AdmitsNominally(candidate_hz, mass, factor); });
    if (!cutoff_hz || !certificate_) {
      return cutoff_hz;
    }
    model::LoopParameters candidate = loop_;
    candidate.cutoff_hz = *cutoff_hz;
    const auto proved = certificates_->Get(AssumedLoops(candidate, requirements_));
    if (proved->Contains(mass * margin_factor_)) {
      return cutoff_hz;
    }
    if (proved->empty()) {
      return std::nullopt;
    }
    const double ratio = nominal_to_robust(model::ComputeMWidth(candidate), *proved);
    factor = std::max(factor, margin_factor_ * ratio) * kStep;
  }
  return std::nullopt;
}

model::Margins StabilityGate::WorstMargins(double mass) const {
  const bool certified = certificate_ && !certificate_->empty();
  std::vector<model::LoopParameters> loops{loop_};
  if (certified) {
    loops.push_back(certificate_->lower.binding);
    loops.push_back(certificate_->upper.binding);
  }
  model::Margins worst = model::WorstMarginsAmong(loops, mass).margins;
  if (certified && mass != 0) {
    // Over the whole envelope, as it is proved: usually within 0.5 % of the loop that binds; where the effort
    // ended first, less is proved.
    const model::RobustEdge& edge = mass < 0 ? certificate_->lower : certificate_->upper;
    worst.gain = {.value = edge.mass / mass, .critical_hz = edge.binding_edge.critical_hz};
  }
  return worst;
}

std::string StabilityGate::Binding(const StabilityReport& report, model::AxisKind kind) const {
  if (range_.admitted.empty()) {
    return range_.admitted.empty_reason;
  }
  if (report.noisy) {
    const ForceNoiseLimit& limit = requirements_.noise_limit.value();
    const std::string counts =
        model::IsAccelerometer(loop_.estimator)
            ? "accelerometer's counts of " + Figure(limit.acceleration_quantum) + " " + PositionUnit(kind) +
                  "/s^2"
            : "encoder's counts of " + Figure(limit.position_quantum) + " " + PositionUnit(kind);
    return "The " + counts + " put a noise of " + Figure(report.force_noise.value_or(0)) + " " +
           ForceUnit(kind) + " on the force (standard deviation); " + Figure(limit.max_force_noise) + " " +
           ForceUnit(kind) + " are allowed.";
  }
  const bool lower = report.requested_mass < 0;
  const std::string at =
      " the loop oscillates at " + Figure(report.critical_hz) + " Hz when the mass reaches ";
  const std::string kept =
      "a gain margin of " + Figure(range_.required_gain_margin_db) + " dB is kept from there.";
  if (!certificate_) {
    const double edge = lower ? range_.nominal.min : range_.nominal.max;
    return "With its nominal parameters" + at + Figure(edge) + " " + MassUnit(kind) + "; " + kept;
  }
  const model::RobustEdge& edge = lower ? certificate_->lower : certificate_->upper;
  return "With " + model::DescribeBinding(*certificate_, edge) + at + Figure(edge.binding_edge.mass) + " " +
         MassUnit(kind) + ". Every loop of the envelope is proved stable up to " +
         FigureTowardsZero(edge.mass) + " " + MassUnit(kind) + "; " + kept;
}

}  // namespace mwidth::gate
