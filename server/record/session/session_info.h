// What a session says of itself, beside its samples.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/exchange/crossing.h"

namespace mwidth::record {

/// Who did what. Labels are letters and digits; subject, visit and task are BIDS entities without their
/// prefix.
struct SessionLabels {
  std::string subject;
  /// BIDS's "session"; empty: there is only one.
  std::string visit;
  std::string task;
  /// From 1.
  int run = 1;
  /// Who ran the session, if it is told.
  std::string operator_name;
  /// Free, for the study.
  std::map<std::string, std::string> metadata{};

  bool operator==(const SessionLabels&) const = default;
};

/// What turns integers into quantities, and what ran: enough to compute every derived column again.
struct SessionAxis {
  std::string name;
  /// kg m^2, rad, N m; otherwise kg, m, N.
  bool rotary = false;
  double period_s = 0;
  double position_quantum = 0;
  double force_quantum = 0;
  /// 0: no accelerometer.
  double acceleration_quantum = 0;
  double force_limit = 0;
  /// Infinite: none.
  double force_slew_limit = 0;

  bool operator==(const SessionAxis&) const = default;
};

/// What was in force when it began, as the texts that people and programs read.
struct SessionProvenance {
  std::string software_version;
  /// The configuration file, as it was read (TOML), and what the command line changed.
  std::string configuration;
  std::string command_line;
  /// The axis's state at the start as JSON (proto3 mapping of mwidth.v1.AxisState): loop, envelope,
  /// tolerance, M-width.
  std::string axis_state;

  bool operator==(const SessionProvenance&) const = default;
};

enum class SessionState : uint8_t {
  /// Its server writes it now, or died: nobody has recovered it.
  kOpen = 0,
  kEnded = 1,
  /// Its server died or lost its disk; what it had written was found and closed.
  kRecovered = 2,
};

struct SessionInfo {
  /// The file's name without its ending.
  std::string id;
  SessionLabels labels;
  SessionAxis axis;
  SessionProvenance provenance;
  SessionState state = SessionState::kOpen;
  /// Wall clock (ns since 1970) and the axis's clock at the same moment.
  int64_t start_wall_ns = 0;
  int64_t start_monotonic_ns = 0;
  /// None while open; of a recovered session that of its last sample.
  std::optional<int64_t> end_wall_ns;
  uint64_t sample_count = 0;
  /// 0 where there are no samples.
  uint64_t first_tick = 0;
  uint64_t last_tick = 0;

  bool operator==(const SessionInfo&) const = default;
};

/// A moment that the study marks, on the axis's clock.
struct Marker {
  /// From 1 within the session.
  uint64_t number = 0;
  std::string label{};
  /// "trial_start" and "trial_end" bound a trial (reports and exports know them); anything else is the
  /// study's own.
  std::string kind{};
  std::map<std::string, std::string> metadata{};
  /// When it was, on the axis's clock, and how far off that may be; when it arrived.
  int64_t monotonic_ns = 0;
  int64_t error_ns = 0;
  int64_t arrival_ns = 0;
  /// The client's own time of it; 0 where it gave none.
  int64_t client_ns = 0;

  bool operator==(const Marker&) const = default;
};

/// Ticks of the session without a sample.
struct Gap {
  /// The last tick before, and the first after; no last tick where the session ended in the gap.
  uint64_t after_tick = 0;
  uint64_t before_tick = 0;
  /// Never ran, because their deadline was missed.
  uint64_t missed_ticks = 0;
  /// Ran, and were lost on the way to the file or within it.
  uint64_t lost_ticks = 0;
  /// Why, for a person.
  std::string reason;

  bool operator==(const Gap&) const = default;
};

struct GapTotals {
  uint64_t missed_ticks = 0;
  uint64_t lost_ticks = 0;
};

/// The sums of all gaps.
inline GapTotals TotalsOf(const std::vector<Gap>& gaps) noexcept {
  GapTotals totals;
  for (const Gap& gap : gaps) {
    totals.missed_ticks += gap.missed_ticks;
    totals.lost_ticks += gap.lost_ticks;
  }
  return totals;
}

/// The wall clock jumped against the axis's clock: from here on wall = monotonic + offset.
struct WallClockStep {
  int64_t monotonic_ns = 0;
  int64_t offset_ns = 0;

  bool operator==(const WallClockStep&) const = default;
};

}  // namespace mwidth::record
