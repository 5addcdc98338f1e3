#include "client/cli/session/analysis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "server/model/accuracy.h"

namespace mwidth::cli::session {
namespace {

constexpr double kNsPerS = 1e9;
// Of the picture that lays movements over each other: before onset, after the end, and how many of a mass.
constexpr double kBeforeS = 0.2;
constexpr double kAfterS = 0.3;
constexpr std::size_t kCurvesOfAMass = 20;

std::vector<Point> CurveOf(const Motion& motion, const std::vector<double>& column) {
  std::vector<Point> points(column.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k] = {motion.TimeOf(k), column[k]};
  }
  return Thin(points, kCurvePairs);
}

std::vector<Point> WayOf(const Motion& motion, const Movement& movement) {
  const auto samples = [&motion](double time_s) {
    return static_cast<std::size_t>(std::lround(time_s / motion.period_s));
  };
  const std::size_t first = movement.onset - std::min(movement.onset, samples(kBeforeS));
  const std::size_t last = std::min(movement.end + samples(kAfterS), motion.position.size() - 1);
  std::vector<Point> points;
  for (std::size_t k = first; k <= last; ++k) {
    points.push_back({(static_cast<double>(k) - static_cast<double>(movement.onset)) * motion.period_s,
                      (motion.position[k] - movement.start) / (movement.target - movement.start)});
  }
  return Thin(points, kCurvePairs / 2);
}

// The least and the largest stand where a mass is first set, as the gate compares numbers exactly.
using GroupKey = std::tuple<double, uint8_t, double>;
GroupKey KeyOf(double mass, const exchange::Filter& filter) {
  return {mass, filter.estimator, filter.cutoff_hz};
}

Spread SpreadOf(const std::vector<double>& values) {
  Spread spread{.count = values.size()};
  if (values.empty()) {
    return spread;
  }
  const auto count = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  const double mean = sum / count;
  spread.mean = mean;
  if (values.size() > 1) {
    double squares = 0;
    for (const double value : values) {
      squares += (value - mean) * (value - mean);
    }
    spread.deviation = std::sqrt(squares / (count - 1));
  }
  return spread;
}

template <typename Figure>
Spread SpreadOf(const std::vector<const Movement*>& movements, const Figure& figure) {
  std::vector<double> values;
  for (const Movement* movement : movements) {
    if (const std::optional<double> value = figure(*movement)) {
      values.push_back(*value);
    }
  }
  return SpreadOf(values);
}

std::optional<double> ChirpError(const AxisFacts& facts, double mass, const exchange::Filter& filter) {
  if (!facts.loop) {
    return std::nullopt;
  }
  model::LoopParameters loop = *facts.loop;
  loop.estimator = static_cast<model::EstimatorKind>(filter.estimator);
  loop.cutoff_hz = filter.cutoff_hz;
  const model::MotionBand band;
  if (model::Validate(loop) || model::Validate(band, loop.period_s)) {
    return std::nullopt;
  }
  const model::PerceivedMass perceived = model::PredictPerceivedMass(loop, mass, band);
  return perceived.perception == model::Perception::kKnown ? perceived.error : std::nullopt;
}

MassGroup GroupOf(const std::vector<const Movement*>& movements) {
  // What a trial cuts off tells neither how far it would have gone nor how long.
  const auto overshoot = [](const Movement& m) {
    return m.turned ? std::optional(m.overshoot) : std::nullopt;
  };
  const auto time_s = [](const Movement& m) {
    return m.came_to_rest ? std::optional(m.movement_time_s) : std::nullopt;
  };
  const auto magnitude = [](const Movement& m) { return std::optional(std::abs(m.peak_velocity)); };
  return {.movements = movements.size(),
          .overshoot = SpreadOf(movements, overshoot),
          .movement_time_s = SpreadOf(movements, time_s),
          .peak_velocity = SpreadOf(movements, magnitude),
          .peak_force = SpreadOf(movements, [](const Movement& m) { return std::optional(m.peak_force); }),
          .perceived_mass = SpreadOf(movements, [](const Movement& m) { return m.perceived_mass; }),
          .error = SpreadOf(movements, [](const Movement& m) { return m.error; }),
          .expected_error = SpreadOf(movements, [](const Movement& m) { return m.expected_error; }),
          .chirp_error = std::nullopt};
}

std::vector<MassGroup> GroupsOf(const std::vector<TrialResult>& trials, const AxisFacts& facts) {
  std::map<GroupKey, std::pair<exchange::Filter, std::vector<const Movement*>>> by_mass;
  for (const TrialResult& trial : trials) {
    for (const Movement& movement : trial.movements.found) {
      if (movement.mass && !trial.more_filters) {
        auto& group = by_mass[KeyOf(*movement.mass, trial.filter)];
        group.first = trial.filter;
        group.second.push_back(&movement);
      }
    }
  }
  std::vector<MassGroup> groups;
  for (const auto& [key, group] : by_mass) {
    MassGroup figures = GroupOf(group.second);
    figures.mass = std::get<0>(key);
    figures.filter = group.first;
    figures.chirp_error = ChirpError(facts, figures.mass, figures.filter);
    groups.push_back(figures);
  }
  return groups;
}

class TrialReader {
 public:
  explicit TrialReader(Analysis& analysis) : analysis_(analysis), margins_(MarginsOf(analysis.events)) {
    if (analysis.facts.loop) {
      device_ = Device{analysis.facts.loop->device_mass, analysis.facts.loop->device_damping};
    }
  }

  void Take(const Trial& trial) {
    TrialResult result = Described(trial);
    if (const auto motion = MotionOf(trial, analysis_.info.axis, result.not_judged)) {
      result.movements = FindMovements(*motion, result.task, device_);
      result.position = CurveOf(*motion, motion->position);
      result.velocity = CurveOf(*motion, motion->velocity);
      result.force = CurveOf(*motion, motion->force);
      KeepCurves(*motion, result);
    }
    // Where the first movement begins: a study sets its mass before.
    const uint64_t at =
        result.first_tick + (result.movements.found.empty() ? 0 : result.movements.found[0].onset);
    if (const MarginsInForce* margins = InForceAt(margins_, at)) {
      result.margins = *margins;
    }
    analysis_.trials.push_back(std::move(result));
  }

 private:
  TrialResult Described(const Trial& trial) const {
    const record::SessionInfo& info = analysis_.info;
    TrialResult result{.label = trial.label,
                       .metadata = trial.metadata,
                       .marked = trial.marked,
                       .cut = trial.cut,
                       .start_s = static_cast<double>(trial.start_ns - info.start_monotonic_ns) / kNsPerS,
                       .task = TaskOf(trial, info.axis.rotary),
                       .stale_ticks = trial.stale_ticks,
                       .saturated_ticks = trial.saturated_ticks,
                       .slew_limited_ticks = trial.slew_limited_ticks,
                       .not_rendering_ticks = trial.not_rendering_ticks};
    if (!trial.tick.empty()) {
      result.first_tick = trial.tick.front();
      result.duration_s =
          static_cast<double>(trial.tick.back() - trial.tick.front() + 1) * info.axis.period_s;
      for (const double force : trial.force) {
        result.largest_force = std::max(result.largest_force, std::abs(force));
      }
      result.filter = trial.filters.front().second;
      result.more_filters = trial.filters.size() > 1;
    }
    return result;
  }
  void KeepCurves(const Motion& motion, const TrialResult& result) {
    for (const Movement& movement : result.movements.found) {
      if (movement.mass && !result.more_filters &&
          kept_[KeyOf(*movement.mass, result.filter)]++ < kCurvesOfAMass) {
        analysis_.curves.push_back(
            {.mass = *movement.mass, .filter = result.filter, .way = WayOf(motion, movement)});
      }
    }
  }

  Analysis& analysis_;
  std::vector<MarginsInForce> margins_;
  std::optional<Device> device_;
  std::map<GroupKey, std::size_t> kept_;
};

}  // namespace

void ReadSamples(const SampleSource& next, Analysis& analysis) {
  const record::SessionInfo& info = analysis.info;
  analysis.facts = FactsOf(info.provenance.axis_state);
  analysis.overview = Overview(info.first_tick, info.last_tick, info.axis.period_s);
  TrialReader reader(analysis);
  TrialSplitter splitter(analysis.markers, info.axis.period_s,
                         [&reader](Trial&& trial) { reader.Take(trial); });
  analysis.marked_trials = splitter.marked();
  std::vector<exchange::Sample> samples;
  while (next(samples)) {
    for (const exchange::Sample& sample : samples) {
      analysis.overview.Add(sample);
      splitter.Add(sample);
    }
  }
  splitter.End();
  analysis.groups = GroupsOf(analysis.trials, analysis.facts);
}

}  // namespace mwidth::cli::session
