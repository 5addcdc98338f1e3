// What the loop's samples tell that is an event: states, faults, ticks that are absent.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/record/event_log.h"
#include "server/record/sample_sink.h"

namespace mwidth::record {

/// Words and figures of a change of state, from those who know more than samples say: the fault that is
/// latched, who has control. Called by the drain's thread.
struct StateNote {
  std::string message;
  EventLog::Metadata metadata;
};

/// Publishes to an axis's log. The drain's thread.
class LoopEvents final : public SampleSink {
 public:
  /// Absent ticks are told at most once in so long: a loop that misses every other tick must not push
  /// everything else out of what is remembered.
  static constexpr int64_t kAbsencePeriodNs = 1'000'000'000;

  /// `describe` gets the state that was left and the one that was entered. `log` outlives this.
  LoopEvents(EventLog& log, std::function<StateNote(exchange::State, exchange::State)> describe);

  void Consume(std::shared_ptr<const SampleBlock> block) override;

 private:
  void Follow(const exchange::Sample& sample);
  void TellAbsences(const exchange::Sample& sample);

  EventLog& log_;
  const std::function<StateNote(exchange::State, exchange::State)> describe_;
  bool started_ = false;
  exchange::Sample last_;
  // Not told yet.
  uint64_t missed_ = 0;
  uint64_t dropped_ = 0;
  int64_t told_ns_ = 0;
};

}  // namespace mwidth::record
