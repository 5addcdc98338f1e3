#include "server/rpc/command_events.h"

#include <array>
#include <charconv>
#include <numbers>
#include <utility>

#include "server/gate/axis_gate.h"
#include "server/gate/figures.h"
#include "server/model/estimator_kind.h"
#include "server/record/event_log.h"

namespace mwidth::rpc {
namespace {

using record::EventKind;
using Metadata = record::EventLog::Metadata;

// The shortest text that reads back as the same number.
std::string Exact(double value) {
  std::array<char, 32> text{};
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), result.ptr};
}

void Add(const char* name, const gate::Interval& interval, Metadata& metadata) {
  if (!interval.empty()) {
    metadata[std::string(name) + "_min"] = Exact(interval.min);
    metadata[std::string(name) + "_max"] = Exact(interval.max);
  }
}

Metadata Figures(const gate::StabilityReport& report) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  Metadata metadata{{"mass", Exact(report.requested_mass)},
                    {"estimator", model::Name(report.loop.estimator)},
                    {"cutoff_hz", Exact(report.loop.cutoff_hz)},
                    {"gain_margin_db", Exact(report.gain_margin_db)},
                    {"phase_margin_deg", Exact(report.margins.phase_rad.value * kDegrees)},
                    {"delay_margin_s", Exact(report.margins.delay.seconds)},
                    {"modulus_margin", Exact(report.margins.modulus.value)}};
  Add("admitted", report.range.admitted, metadata);
  Add("robust", report.range.robust, metadata);
  Add("nominal", report.range.nominal, metadata);
  return metadata;
}

// Anybody may ask without a lease, again and again: that is no event.
bool Says(const gate::Refusal& refusal) {
  return refusal.reason != gate::kNoLease && refusal.reason != gate::kLeaseLost &&
         refusal.reason != gate::kControlHeld;
}

void TellRefusal(const Axis& axis, EventKind kind, const gate::Refusal& refusal) {
  if (Says(refusal)) {
    Metadata metadata = refusal.metadata;
    metadata["reason"] = refusal.reason;
    axis.events.Publish(kind, refusal.message, std::move(metadata));
  }
}

}  // namespace

void TellControl(const Axis& axis, const gate::Result<gate::Lease>& lease) {
  if (lease.ok()) {
    constexpr double kNsPerS = 1e9;
    axis.events.Publish(
        EventKind::kControlAcquired, "'" + lease->holder + "' has control.",
        {{"client_name", lease->holder}, {"ttl_s", Exact(static_cast<double>(lease->ttl_ns) / kNsPerS)}});
  }
}

void TellRelease(const Axis& axis, const std::string& holder) {
  axis.events.Publish(EventKind::kControlReleased, "'" + holder + "' gave control back.",
                      {{"client_name", holder}});
}

void TellMass(const Axis& axis, const gate::MassRequest& request,
              const gate::Result<gate::MassGrant>& answer) {
  if (request.validate_only) {
    return;
  }
  if (!answer.ok()) {
    TellRefusal(axis, EventKind::kMassRefused, answer.refusal());
    return;
  }
  Metadata metadata = Figures(answer->stability);
  metadata["ramp_s"] = Exact(request.ramp_s);
  axis.events.Publish(EventKind::kMassSet,
                      "A virtual mass of " + gate::Figure(answer->mass) + " " +
                          gate::MassUnit(axis.gate.description().kind) + " is set.",
                      std::move(metadata), answer->tick);
}

void TellFilter(const Axis& axis, bool validate_only, const gate::Result<gate::FilterGrant>& answer) {
  if (validate_only) {
    return;
  }
  if (!answer.ok()) {
    TellRefusal(axis, EventKind::kFilterRefused, answer.refusal());
    return;
  }
  axis.events.Publish(EventKind::kFilterSet,
                      "Acceleration is estimated by " + std::string(model::Name(answer->loop.estimator)) +
                          " at " + gate::Figure(answer->loop.cutoff_hz) + " Hz.",
                      Figures(answer->stability), answer->tick);
}

void TellEmergencyStop(const Axis& axis, const std::string& by, const std::string& reason) {
  axis.events.Publish(EventKind::kEmergencyStop,
                      "Emergency stop by " + by + (reason.empty() ? "." : ": " + reason),
                      {{"by", by}, {"reason", reason}});
}

}  // namespace mwidth::rpc
