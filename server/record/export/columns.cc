#include "server/record/export/columns.h"

#include "server/model/estimator_kind.h"

namespace mwidth::record {
namespace {

using exchange::Sample;

Coded StateOf(exchange::State state) { return {static_cast<uint8_t>(state), StateWord(state)}; }

Coded EstimatorOf(uint8_t kind) { return {kind, model::Name(static_cast<model::EstimatorKind>(kind))}; }

std::vector<std::string_view> StateWords() {
  std::vector<std::string_view> words;
  for (uint8_t state = 0; state <= static_cast<uint8_t>(exchange::State::kFault); ++state) {
    words.push_back(StateWord(static_cast<exchange::State>(state)));
  }
  return words;
}

std::vector<std::string_view> EstimatorWords() {
  std::vector<std::string_view> words;
  for (uint8_t kind = 0; EstimatorOf(kind).word != "unknown"; ++kind) {
    words.push_back(EstimatorOf(kind).word);
  }
  return words;
}

Column Counts(const char* name, const char* description, Value (*of)(const Sample&)) {
  return {name, name, "1", description, of, {}};
}

std::vector<Column> Quantities(bool rotary) {
  const auto quantity = [rotary](const std::string& name, const char* linear_unit, const char* linear_suffix,
                                 const char* rotary_unit, const char* rotary_suffix, const char* description,
                                 Value (*of)(const Sample&)) {
    return Column{name,
                  name + '_' + (rotary ? rotary_suffix : linear_suffix),
                  rotary ? rotary_unit : linear_unit,
                  description,
                  of,
                  {}};
  };
  return {
      quantity("position", "m", "m", "rad", "rad", "Position of the axis: position_counts in its unit",
               [](const Sample& s) -> Value { return s.position; }),
      quantity("velocity", "m/s", "m_per_s", "rad/s", "rad_per_s",
               "First difference of the position, unfiltered",
               [](const Sample& s) -> Value { return s.velocity; }),
      quantity("acceleration", "m/s^2", "m_per_s2", "rad/s^2", "rad_per_s2",
               "The estimate that the force follows",
               [](const Sample& s) -> Value { return s.acceleration; }),
      quantity("force", "N", "n", "N m", "n_m",
               "Commanded force or torque, positive against positive acceleration at a positive mass",
               [](const Sample& s) -> Value { return s.force; }),
      quantity("mass", "kg", "kg", "kg m^2", "kg_m2", "The virtual mass that was rendered, ramps included",
               [](const Sample& s) -> Value { return s.mass; })};
}

// What the stream has not.
std::vector<Column> Remainder() {
  return {
      Counts("slew_limited", "1 where the limit on its change cut the commanded force",
             [](const Sample& s) -> Value { return s.slew_limited; }),
      Counts("position_stale",
             "1 where the drive did not answer: position, velocity and acceleration are the last ones known",
             [](const Sample& s) -> Value { return s.position_stale; }),
      Counts("force_taken", "1 where the drive was enabled and took the force",
             [](const Sample& s) -> Value { return s.force_taken; }),
      Counts("missed_ticks", "Ticks that the loop had missed by then, since it began",
             [](const Sample& s) -> Value { return s.missed_ticks; }),
      {"estimator", "estimator", "1", "What estimated the acceleration",
       [](const Sample& s) -> Value { return EstimatorOf(s.filter.estimator); }, EstimatorWords()},
      {"cutoff_hz",
       "cutoff_hz",
       "Hz",
       "Cut-off of the estimator's filter",
       [](const Sample& s) -> Value { return s.filter.cutoff_hz; },
       {}}};
}

}  // namespace

std::string_view StateWord(exchange::State state) {
  switch (state) {
    case exchange::State::kIdle:
      return "idle";
    case exchange::State::kReady:
      return "ready";
    case exchange::State::kRendering:
      return "rendering";
    case exchange::State::kFault:
      return "fault";
  }
  return "unknown";
}

std::vector<Column> SampleColumns(bool rotary) {
  std::vector<Column> columns{
      Counts("tick", "Number of the tick since the loop began; a number left out is a tick without a sample",
             [](const Sample& s) -> Value { return s.tick; }),
      {"monotonic_ns",
       "monotonic_ns",
       "ns",
       "When the tick ran, on the axis's clock",
       [](const Sample& s) -> Value { return s.monotonic_ns; },
       {}}};
  for (auto& column : Quantities(rotary)) {
    columns.push_back(std::move(column));
  }
  columns.push_back({"state", "state", "1", "What the axis was doing",
                     [](const Sample& s) -> Value { return StateOf(s.state); }, StateWords()});
  columns.push_back(Counts("saturated", "1 where the force limit, or the limit on its change, cut the force",
                           [](const Sample& s) -> Value { return s.saturated; }));
  columns.push_back(Counts("position_counts", "Raw counts of the encoder",
                           [](const Sample& s) -> Value { return s.position_counts; }));
  columns.push_back(Counts("force_counts", "Raw counts of the commanded force",
                           [](const Sample& s) -> Value { return s.force_counts; }));
  columns.push_back(Counts("acceleration_counts", "Raw counts of the accelerometer; 0 where there is none",
                           [](const Sample& s) -> Value { return s.acceleration_counts; }));
  for (auto& column : Remainder()) {
    columns.push_back(std::move(column));
  }
  return columns;
}

}  // namespace mwidth::record
