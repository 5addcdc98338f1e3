#include "server/record/session/session_writer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/record/session/session_reader.h"

namespace mwidth::record {
namespace {

std::string Milliseconds(int64_t ns) { return std::to_string(ns / 1'000'000) + " ms"; }

}  // namespace

SessionWriter::SessionWriter(NewSession session, uint64_t first_tick,
                             const std::optional<exchange::Sample>& seen, std::size_t queue_samples,
                             SessionReport report, SessionClocks clocks)
    : session_(std::move(session)),
      first_tick_(first_tick),
      seen_(seen),
      queue_samples_(queue_samples),
      report_(std::move(report)),
      clocks_(std::move(clocks)),
      wall_offset_ns_(session_.info.start_wall_ns - session_.info.start_monotonic_ns) {}

void SessionWriter::Offer(std::shared_ptr<const SampleBlock> block) {
  const std::lock_guard lock(mutex_);
  if (queued_samples_ + block->size() > queue_samples_) {
    dropping_ += block->size();
    dropped_samples_ += block->size();
    drop_reason_ =
        failure_.empty() ? "the disk did not keep up with the loop" : "storage failed: " + failure_;
    return;
  }
  queued_samples_ += block->size();
  queue_.push_back(
      {.block = std::move(block), .dropped = std::exchange(dropping_, 0), .drop_reason = drop_reason_});
}

void SessionWriter::AddEvent(const Event& event) {
  const std::lock_guard lock(mutex_);
  if (events_.size() < kQueueEntries) {
    events_.push_back(event);
  } else {
    ++dropped_events_;
  }
}

Marker SessionWriter::AddMarker(Marker marker) {
  const std::lock_guard lock(mutex_);
  if (ending_) {
    throw SessionRefused(SessionRefusal::kNoSession, "the session is just being ended");
  }
  if (given_up_ || markers_.size() >= kQueueEntries) {
    throw SessionRefused(SessionRefusal::kStorageFailed,
                         "the session's disk takes no more markers: make it work again, or end the session");
  }
  marker.number = ++marker_count_;
  markers_.push_back(marker);
  return marker;
}

SessionInfo SessionWriter::info() const {
  const std::lock_guard lock(mutex_);
  SessionInfo info = session_.info;
  info.sample_count = sample_count_;
  info.first_tick = first_sample_tick_;
  info.last_tick = last_sample_tick_;
  return info;
}

template <typename Action>
void SessionWriter::GiveUpWhere(const Action& action) noexcept {
  if (given_up_) {
    return;
  }
  std::string why = "unknown";
  try {
    try {
      action();
      return;
    } catch (const std::exception& error) {
      given_up_ = true;
      why = error.what();
    }
    report_(EventKind::kStorageFailed,
            "session " + session_.info.id + " is written no more, after an error inside the server (" + why +
                "). The loop runs on; end the session, and its file is recovered when the server starts next",
            {{"session_id", session_.info.id}, {"disk_full", "false"}});
  } catch (...) {  // of the report, or no std::exception: the loop, which holds a person, must run on
    given_up_ = true;
  }
}

void SessionWriter::Step() noexcept {
  GiveUpWhere([this] {
    if (commit_failing_ && clocks_.monotonic_ns() < retry_ns_) {
      return;
    }
    CheckWallClock();
    // While the disk fails, what waits stays in the queue, which is bounded.
    if (commit_failing_ && !TryCommit()) {
      return;
    }
    TakeQueue();
    TryCommit();
    TellDroppedEvents();
  });
}

void SessionWriter::TakeQueue() {
  std::deque<Waiting> blocks;
  std::vector<Event> events;
  std::vector<Marker> markers;
  {
    const std::lock_guard lock(mutex_);
    blocks.swap(queue_);
    events.swap(events_);
    markers.swap(markers_);
    queued_samples_ = 0;
  }
  for (const Waiting& waiting : blocks) {
    Append(waiting);
  }
  for (const Event& event : events) {
    session_.file.Add(event);
  }
  for (const Marker& marker : markers) {
    session_.file.Add(marker);
  }
}

void SessionWriter::Append(const Waiting& waiting) {
  const SampleBlock& block = *waiting.block;
  const auto first = std::find_if(block.begin(), block.end(), [this](const exchange::Sample& sample) {
    return sample.tick >= first_tick_;
  });
  if (first == block.end()) {
    return;
  }
  if (sample_count_ == 0) {
    NoteStart(*first);
  }
  session_.file.Append({first, block.end()}, waiting.dropped > 0
                                                 ? waiting.drop_reason
                                                 : "the record did not keep up with the loop");
  if (waiting.dropped > 0) {
    report_(EventKind::kSamplesDropped,
            "session " + session_.info.id + " lost " + std::to_string(waiting.dropped) +
                " samples: " + waiting.drop_reason,
            {{"session_id", session_.info.id}, {"lost_samples", std::to_string(waiting.dropped)}});
  }
  const std::lock_guard lock(mutex_);
  sample_count_ += static_cast<uint64_t>(block.end() - first);
  first_sample_tick_ = first_sample_tick_ == 0 ? first->tick : first_sample_tick_;
  last_sample_tick_ = block.back().tick;
}

void SessionWriter::NoteStart(const exchange::Sample& first) {
  const uint64_t absent = first.tick - first_tick_;
  if (absent == 0) {
    return;
  }
  // Where the sample before the session was seen its count tells what was missed since.
  const uint64_t missed = seen_ ? std::min(absent, first.missed_ticks - seen_->missed_ticks) : 0;
  session_.file.Add(Gap{.after_tick = first_tick_ - 1,
                        .before_tick = first.tick,
                        .missed_ticks = missed,
                        .lost_ticks = absent - missed,
                        .reason = missed == absent ? "the loop missed its deadlines"
                                                   : "the record did not keep up as the session began"});
}

void SessionWriter::CheckWallClock() {
  const int64_t before_ns = clocks_.monotonic_ns();
  const int64_t wall_ns = clocks_.wall_ns();
  const int64_t monotonic_ns = clocks_.monotonic_ns();
  if (monotonic_ns - before_ns > kWallClockStepNs / 10) {
    return;  // held up between the two clocks
  }
  const int64_t offset_ns = wall_ns - monotonic_ns;
  const int64_t change_ns = offset_ns - wall_offset_ns_;
  if (std::abs(change_ns) <= kWallClockStepNs) {
    return;
  }
  wall_offset_ns_ = offset_ns;
  session_.file.Add(WallClockStep{.monotonic_ns = monotonic_ns, .offset_ns = offset_ns});
  report_(EventKind::kWallClockStepped,
          "the wall clock was set by " + Milliseconds(change_ns) +
              " against the axis's clock; samples keep the axis's, and the session notes the step",
          {{"session_id", session_.info.id}, {"change_ns", std::to_string(change_ns)}});
}

bool SessionWriter::TryCommit() {
  try {
    if (session_.file.HasPending()) {
      session_.file.Commit(Durability::kProcess);
    }
  } catch (const StorageError& error) {
    commit_failing_ = true;
    retry_ns_ = clocks_.monotonic_ns() + kRetryNs;
    TellFailure(error.what(), error.disk_full());
    return false;
  }
  commit_failing_ = false;
  std::optional<StorageError> sync_failure;
  {
    const std::lock_guard lock(mutex_);
    sync_failure = sync_failure_;
  }
  if (sync_failure) {
    TellFailure(sync_failure->what(), sync_failure->disk_full());
  } else {
    TellRestored();
  }
  return true;
}

// Those of a failing disk are told when it is back.
void SessionWriter::TellDroppedEvents() {
  uint64_t dropped = 0;
  if (!failure_told_) {
    const std::lock_guard lock(mutex_);
    dropped = std::exchange(dropped_events_, 0);
  }
  if (dropped > 0) {
    report_(EventKind::kSamplesDropped,
            "session " + session_.info.id + " lost " + std::to_string(dropped) +
                " events: more came at once than wait for the disk",
            {{"session_id", session_.info.id}, {"lost_events", std::to_string(dropped)}});
  }
}

void SessionWriter::TellFailure(const std::string& what, bool disk_full) {
  {
    const std::lock_guard lock(mutex_);
    failure_ = what;
    if (std::exchange(failure_told_, true)) {
      return;
    }
    dropped_before_failure_ = dropped_samples_;
  }
  report_(EventKind::kStorageFailed,
          "session " + session_.info.id +
              (disk_full ? " has filled the disk: make room" : " cannot be written") +
              ". The loop runs on, and the session can be ended when the disk works again; samples wait as "
              "long as there is memory for them, and are lost after that. (" +
              what + ")",
          {{"session_id", session_.info.id}, {"disk_full", disk_full ? "true" : "false"}});
}

void SessionWriter::TellRestored() {
  if (!std::exchange(failure_told_, false)) {
    return;
  }
  uint64_t lost = 0;
  uint64_t lost_events = 0;
  {
    const std::lock_guard lock(mutex_);
    lost = dropped_samples_ - dropped_before_failure_;
    lost_events = std::exchange(dropped_events_, 0);
    failure_.clear();
  }
  report_(EventKind::kStorageRestored,
          "session " + session_.info.id + " is written again; " + std::to_string(lost) + " samples and " +
              std::to_string(lost_events) + " events were lost",
          {{"session_id", session_.info.id},
           {"lost_samples", std::to_string(lost)},
           {"lost_events", std::to_string(lost_events)}});
}

void SessionWriter::Sync() noexcept {
  GiveUpWhere([this] {
    std::optional<StorageError> failure;
    try {
      session_.file.Sync();
    } catch (const StorageError& error) {
      failure = error;
    }
    const std::lock_guard lock(mutex_);
    sync_failure_ = failure;
  });
}

std::optional<Gap> SessionWriter::LastGap() const {
  const std::lock_guard lock(mutex_);
  if (dropping_ == 0) {
    return std::nullopt;
  }
  return Gap{.after_tick = last_sample_tick_,
             .before_tick = 0,
             .missed_ticks = 0,
             .lost_ticks = dropping_,
             .reason = drop_reason_ + ", and the session ended"};
}

void SessionWriter::SetEnding(bool ending) {
  const std::lock_guard lock(mutex_);
  ending_ = ending;
}

SessionInfo SessionWriter::End() {
  if (given_up_) {
    throw SessionRefused(SessionRefusal::kStorageFailed,
                         "session " + session_.info.id +
                             " was given up after an error inside the server. It is no longer recorded; its "
                             "file is recovered when the server starts next");
  }
  try {
    // As in Step: while the disk fails, what waits stays in the queue, which is bounded.
    session_.file.Commit(Durability::kProcess);
    SetEnding(true);
    TakeQueue();
    TellDroppedEvents();
    TakeQueue();
    session_.file.End(SessionState::kEnded, clocks_.wall_ns(), LastGap());
  } catch (const StorageError& error) {
    SetEnding(false);
    commit_failing_ = true;
    retry_ns_ = clocks_.monotonic_ns() + kRetryNs;
    TellFailure(error.what(), error.disk_full());
    throw SessionRefused(
        error.disk_full() ? SessionRefusal::kStorageFull : SessionRefusal::kStorageFailed,
        std::string(error.what()) + ". Session " + session_.info.id +
            " goes on: " + (error.disk_full() ? "make room" : "see to the disk") +
            ", and end it again (where the server stops before, its file is recovered at the next start)");
  }
  try {
    return SessionReader(session_.path).info();
  } catch (const SessionFileError&) {  // it is closed all the same
    SessionInfo ended = info();
    ended.state = SessionState::kEnded;
    ended.end_wall_ns = clocks_.wall_ns();
    return ended;
  }
}

}  // namespace mwidth::record
