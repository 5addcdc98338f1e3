// Everything that a report says of a session, gathered in one pass over its samples.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/session/axis_facts.h"
#include "client/cli/session/movement.h"
#include "client/cli/session/overview.h"
#include "client/cli/session/svg.h"
#include "client/cli/session/trial.h"
#include "server/record/session/session_reader.h"

namespace mwidth::cli::session {

/// Curves of a movement about its onset, for the picture that lays movements over each other.
struct MovementCurve {
  double mass = 0;
  exchange::Filter filter{};
  /// Seconds from onset; fraction of the way from start to target.
  std::vector<Point> way;
};

/// One trial as it is shown: its samples are gone.
struct TrialResult {
  std::string label{};
  std::map<std::string, std::string> metadata{};
  bool marked = false;
  bool cut = false;
  /// From the session's start.
  double start_s = 0;
  double duration_s = 0;
  uint64_t first_tick = 0;
  Task task{};
  Movements movements{};
  /// Why no movement could be judged; empty where they were looked for.
  std::string not_judged{};
  /// The first filter that ran; its others are `more_filters`.
  exchange::Filter filter{};
  bool more_filters = false;
  /// As commanded, unlike that of movements.
  double largest_force = 0;
  uint64_t stale_ticks = 0;
  uint64_t saturated_ticks = 0;
  uint64_t slew_limited_ticks = 0;
  uint64_t not_rendering_ticks = 0;
  std::optional<MarginsInForce> margins{};
  /// Seconds from the trial's first sample; m or rad, and so on; at most kCurvePoints pairs.
  std::vector<Point> position{};
  std::vector<Point> velocity{};
  std::vector<Point> force{};
};

inline constexpr std::size_t kCurvePairs = 250;

/// Mean and standard deviation (with n - 1; none of a single value).
struct Spread {
  std::size_t count = 0;
  std::optional<double> mean{};
  std::optional<double> deviation{};
};

/// Movements under one commanded mass and one filter.
struct MassGroup {
  double mass = 0;
  exchange::Filter filter{};
  std::size_t movements = 0;
  Spread overshoot;
  Spread movement_time_s;
  Spread peak_velocity;
  Spread peak_force;
  Spread perceived_mass;
  Spread error;
  Spread expected_error;
  /// Eq. 24 for the paper's chirp of 0.1 to 5 Hz (Figure 9), from the model of the axis.
  std::optional<double> chirp_error;
};

struct Analysis {
  record::SessionInfo info;
  std::vector<record::Event> events;
  std::vector<record::Marker> markers;
  std::vector<record::Gap> gaps;
  std::vector<record::WallClockStep> wall_clock_steps;
  std::vector<record::DamagedBlock> damaged;
  AxisFacts facts;
  bool marked_trials = false;
  std::vector<TrialResult> trials;
  std::vector<MassGroup> groups;
  std::vector<MovementCurve> curves;
  Overview overview;
};

/// Gives the next samples in the order of ticks; false at the end (SessionReader::Next).
using SampleSource = std::function<bool(std::vector<exchange::Sample>&)>;

/// Reads all samples; fills all that is still empty in `analysis`. Memory: one trial, and what is shown.
void ReadSamples(const SampleSource& next, Analysis& analysis);

}  // namespace mwidth::cli::session
