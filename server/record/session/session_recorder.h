// Records one axis into sessions, one at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "server/record/event.h"
#include "server/record/sample_sink.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_store.h"
#include "server/record/session/session_writer.h"

namespace mwidth::record {

struct SessionLimits {
  /// Samples that may wait for the disk; beyond that they are dropped, and the session notes the gap.
  std::size_t queue_samples = 100'000;
};

/// A marker as it was numbered, and in which session.
struct RecordedMarker {
  Marker marker;
  std::string session_id;
};

/// Stays attached to an axis's drain, and is idle without a session. A session has two threads of its own:
/// one commits every kCommitPeriod, so that the death of this process loses no more; one brings the commits
/// to the disk every kSyncPeriod, so that a loss of power does not either, and no commit waits for a slow
/// disk. Calls are for any thread, Consume for the drain's; none of them waits for the disk but Start and
/// End.
class SessionRecorder final : public SampleSink {
 public:
  static constexpr std::chrono::milliseconds kCommitPeriod{50};
  static constexpr std::chrono::milliseconds kSyncPeriod{500};

  /// `store` outlives it. `report` may call AddEvent.
  SessionRecorder(SessionStore& store, const SessionLimits& limits, SessionReport report,
                  SessionClocks clocks);
  /// Ends the session, if there is one; where its disk fails, the file is recovered at the next start.
  ~SessionRecorder() override;

  /// Begins a session with tick `first_tick`, or the first that comes once there is a file; run 0 is the next
  /// that is free. Throws SessionRefused: kSessionOpen, kSessionExists, kStorageFull, kStorageFailed; then
  /// nothing is left of it.
  SessionInfo Start(const SessionLabels& labels, const SessionAxis& axis, const SessionProvenance& provenance,
                    uint64_t first_tick);
  /// Ends the session `id` with all that was consumed, and returns when it is on the disk. Throws
  /// SessionRefused: kNoSession where that is not being recorded; kStorageFull and kStorageFailed where the
  /// disk did not take it, and then it is still being recorded with all that it had, unless it had been given
  /// up after an error inside the server.
  SessionInfo End(const std::string& id);
  /// The session that is being recorded, as it stands.
  std::optional<SessionInfo> Active() const;

  /// Numbers a marker and records it. Throws SessionRefused: kNoSession, kStorageFailed.
  RecordedMarker AddMarker(const Marker& marker);
  /// Does nothing without a session.
  void AddEvent(const Event& event);

  void Consume(std::shared_ptr<const SampleBlock> block) override;

 private:
  std::shared_ptr<SessionWriter> Writer() const;
  void StartThreads(const std::shared_ptr<SessionWriter>& writer);
  void StopThreads();
  bool Resume(const std::shared_ptr<SessionWriter>& writer);
  SessionInfo Finish();

  SessionStore& store_;
  const SessionLimits limits_;
  const SessionReport report_;
  const SessionClocks clocks_;

  // Held by Start and End from beginning to end, so that they do not cross.
  std::mutex lifecycle_;
  mutable std::mutex mutex_;
  std::shared_ptr<SessionWriter> writer_;
  std::optional<exchange::Sample> seen_;
  std::jthread committing_;
  std::jthread syncing_;
};

}  // namespace mwidth::record
