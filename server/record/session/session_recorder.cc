#include "server/record/session/session_recorder.h"

#include <algorithm>
#include <condition_variable>
#include <stop_token>
#include <system_error>
#include <utility>

namespace mwidth::record {
namespace {

// Calls `work` once a period until it is to stop.
template <typename Work>
std::jthread Every(std::chrono::milliseconds period, Work work) {
  return std::jthread([period, work = std::move(work)](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopping;
    std::unique_lock lock(mutex);
    auto next = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      work();
      next = std::max(next + period, std::chrono::steady_clock::now());
      // Nobody notifies but the stop token: this is a sleep that it ends at once.
      stopping.wait_until(lock, stop, next, [] { return false; });
    }
  });
}

}  // namespace

SessionRecorder::SessionRecorder(SessionStore& store, const SessionLimits& limits, SessionReport report,
                                 SessionClocks clocks)
    : store_(store), limits_(limits), report_(std::move(report)), clocks_(std::move(clocks)) {}

SessionRecorder::~SessionRecorder() {
  const std::lock_guard lifecycle(lifecycle_);
  if (Writer()) {
    try {
      Finish();
    } catch (
        const std::exception&) {  // NOLINT(bugprone-empty-catch): its file is recovered at the next start
    }
  }
}

std::shared_ptr<SessionWriter> SessionRecorder::Writer() const {
  const std::lock_guard lock(mutex_);
  return writer_;
}

SessionInfo SessionRecorder::Start(const SessionLabels& labels, const SessionAxis& axis,
                                   const SessionProvenance& provenance, uint64_t first_tick) {
  const std::lock_guard lifecycle(lifecycle_);
  if (const auto writer = Writer()) {
    throw SessionRefused(
        SessionRefusal::kSessionOpen,
        "axis " + axis.name + " is being recorded: end session " + writer->info().id + " first");
  }
  SessionInfo info;
  info.labels = labels;
  info.axis = axis;
  info.provenance = provenance;
  info.start_wall_ns = clocks_.wall_ns();
  info.start_monotonic_ns = clocks_.monotonic_ns();
  NewSession session = store_.Create(std::move(info));
  info = session.info;
  const std::filesystem::path path = session.path;
  try {
    const std::lock_guard lock(mutex_);
    // What ran while the file was made came too early, and was not lost.
    const uint64_t first_kept = std::max(first_tick, seen_ ? seen_->tick + 1 : 0);
    const auto writer = std::make_shared<SessionWriter>(std::move(session), first_kept, seen_,
                                                        limits_.queue_samples, report_, clocks_);
    StartThreads(writer);
    writer_ = writer;
  } catch (const std::exception& error) {  // std::system_error or std::bad_alloc
    StopThreads();
    SessionStore::Discard(path);
    throw SessionRefused(SessionRefusal::kStorageFailed,
                         std::string("the session's threads cannot be made: ") + error.what());
  }
  return info;
}

void SessionRecorder::StartThreads(const std::shared_ptr<SessionWriter>& writer) {
  committing_ = Every(kCommitPeriod, [writer] { writer->Step(); });
  syncing_ = Every(kSyncPeriod, [writer] { writer->Sync(); });
}

SessionInfo SessionRecorder::End(const std::string& id) {
  const std::lock_guard lifecycle(lifecycle_);
  const auto writer = Writer();
  if (!writer || writer->info().id != id) {
    throw SessionRefused(SessionRefusal::kNoSession, "session " + id + " is not being recorded");
  }
  return Finish();
}

void SessionRecorder::StopThreads() {
  // Both before either is waited for.
  committing_.request_stop();
  syncing_.request_stop();
  committing_ = {};
  syncing_ = {};
}

SessionInfo SessionRecorder::Finish() {
  const auto writer = Writer();
  const auto leave = [this] {
    const std::lock_guard lock(mutex_);
    writer_ = nullptr;
  };
  StopThreads();
  try {
    // Meanwhile it takes what comes: where it cannot end, nothing is lost of that.
    SessionInfo ended = writer->End();
    leave();
    return ended;
  } catch (const SessionRefused&) {
    if (writer->given_up() || !Resume(writer)) {
      leave();
    }
    throw;
  } catch (...) {  // no memory: what the writer has is no longer sure
    leave();
    throw;
  }
}

bool SessionRecorder::Resume(const std::shared_ptr<SessionWriter>& writer) {
  try {
    StartThreads(writer);
    return true;
  } catch (const std::system_error&) {
    StopThreads();
    return false;
  }
}

std::optional<SessionInfo> SessionRecorder::Active() const {
  const auto writer = Writer();
  return writer ? std::optional(writer->info()) : std::nullopt;
}

RecordedMarker SessionRecorder::AddMarker(const Marker& marker) {
  // Under the lock, so that the session does not end before it is in.
  const std::lock_guard lock(mutex_);
  if (!writer_) {
    throw SessionRefused(SessionRefusal::kNoSession, "nothing is being recorded: start a session first");
  }
  return {.marker = writer_->AddMarker(marker), .session_id = writer_->info().id};
}

void SessionRecorder::AddEvent(const Event& event) {
  const std::lock_guard lock(mutex_);
  if (writer_) {
    writer_->AddEvent(event);
  }
}

void SessionRecorder::Consume(std::shared_ptr<const SampleBlock> block) {
  const std::lock_guard lock(mutex_);
  seen_ = block->back();
  if (writer_) {
    writer_->Offer(std::move(block));
  }
}

}  // namespace mwidth::record
