#include "server/record/loop_events.h"

#include <algorithm>
#include <utility>

namespace mwidth::record {

LoopEvents::LoopEvents(EventLog& log, std::function<StateNote(exchange::State, exchange::State)> describe)
    : log_(log), describe_(std::move(describe)) {}

void LoopEvents::Consume(std::shared_ptr<const SampleBlock> block) {
  for (const exchange::Sample& sample : *block) {
    if (started_) {
      Follow(sample);
    }
    started_ = true;
    last_ = sample;
  }
  log_.NoteTick(last_.tick);
}

void LoopEvents::Follow(const exchange::Sample& sample) {
  const uint64_t absent = sample.tick - last_.tick - 1;
  const uint64_t missed = std::min(absent, sample.missed_ticks - last_.missed_ticks);
  missed_ += missed;
  dropped_ += absent - missed;
  if (missed_ + dropped_ > 0 && sample.monotonic_ns - told_ns_ >= kAbsencePeriodNs) {
    TellAbsences(sample);
  }
  if (sample.state != last_.state) {
    StateNote note = describe_(last_.state, sample.state);
    const bool fault = sample.state == exchange::State::kFault;
    log_.Publish(fault ? EventKind::kFault : EventKind::kStateChanged, std::move(note.message),
                 std::move(note.metadata), sample.tick);
  }
}

void LoopEvents::TellAbsences(const exchange::Sample& sample) {
  told_ns_ = sample.monotonic_ns;
  if (const uint64_t ticks = std::exchange(missed_, 0); ticks > 0) {
    log_.Publish(EventKind::kTicksMissed,
                 std::to_string(ticks) + " ticks were skipped, because their deadlines were missed.",
                 {{"ticks", std::to_string(ticks)}}, sample.tick);
  }
  if (const uint64_t ticks = std::exchange(dropped_, 0); ticks > 0) {
    log_.Publish(EventKind::kSamplesDropped,
                 std::to_string(ticks) + " samples were lost: the server could not keep up with the loop.",
                 {{"ticks", std::to_string(ticks)}}, sample.tick);
  }
}

}  // namespace mwidth::record
