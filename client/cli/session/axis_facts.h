// What a session's texts tell of its axis and of the margins in force: the AxisState of its start, and the
// figures of its events.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/model/loop_parameters.h"
#include "server/record/event.h"

namespace mwidth::cli::session {

/// Of virtual masses; edges excluded.
struct MassRange {
  double min = 0;
  double max = 0;
};

struct AxisFacts {
  /// Nominal; its filter is the one at the start, its estimator always the paper's: samples tell which ran.
  std::optional<model::LoopParameters> loop;
  std::optional<MassRange> nominal;
  std::optional<MassRange> robust;
  std::optional<MassRange> admitted;
  std::optional<double> required_gain_margin_db;
  /// True, false, or not told.
  std::optional<bool> simulated;
};

/// From JSON of mwidth.v1.AxisState with the names of the API or those of protobuf's JSON. What is not there,
/// or is not what it should be, is unset.
AxisFacts FactsOf(const std::string& axis_state);

/// What the gate said of a mass that it admitted.
struct MarginsInForce {
  uint64_t tick = 0;
  std::optional<double> mass;
  std::optional<double> gain_db;
  std::optional<double> phase_deg;
  std::optional<double> delay_s;
  std::optional<double> modulus;
  std::optional<MassRange> nominal;
  std::optional<MassRange> robust;
  std::optional<MassRange> admitted;
};

/// Those of the events that set a mass or a filter, in the order of ticks.
std::vector<MarginsInForce> MarginsOf(const std::vector<record::Event>& events);

/// The last one at or before `tick`; null where none is.
const MarginsInForce* InForceAt(const std::vector<MarginsInForce>& margins, uint64_t tick);

}  // namespace mwidth::cli::session
