// One session while it is recorded: what waits for the disk, and what becomes of it when the disk fails.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/record/event.h"
#include "server/record/sample_sink.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_store.h"

namespace mwidth::record {

/// The wall clock (ns since 1970), and the axis's. Any thread.
struct SessionClocks {
  std::function<int64_t()> wall_ns;
  std::function<int64_t()> monotonic_ns;
};

/// Tells an axis's log what happened to its session. Called without locks held, by the thread that writes.
using SessionReport =
    std::function<void(EventKind kind, std::string message, std::map<std::string, std::string> metadata)>;

/// Without threads of its own: one offers samples (the drain's), one calls Step, and one may call Sync; the
/// rest is for any. Where Step or Sync meet anything but a disk that fails (no memory) they give the session
/// up: they tell it, write no more, and leave the file to be recovered.
class SessionWriter {
 public:
  /// After a failure Step leaves the disk alone for this long.
  static constexpr int64_t kRetryNs = 1'000'000'000;
  /// Events, and markers, that may wait for the disk.
  static constexpr std::size_t kQueueEntries = 1000;
  /// A smaller change of the wall clock against the axis's is none.
  static constexpr int64_t kWallClockStepNs = 10'000'000;

  /// Records from `first_tick` on; `seen` is the last sample before, if any was seen. At most `queue_samples`
  /// wait for Step.
  SessionWriter(NewSession session, uint64_t first_tick, const std::optional<exchange::Sample>& seen,
                std::size_t queue_samples, SessionReport report, SessionClocks clocks);

  /// Takes a share of the block, or drops it where too much waits; never waits for the disk.
  void Offer(std::shared_ptr<const SampleBlock> block);
  /// Dropped, and counted, where too many wait.
  void AddEvent(const Event& event);
  /// Numbers it. Throws SessionRefused: kStorageFailed where too many wait, kNoSession while End runs.
  Marker AddMarker(Marker marker);

  /// Commits what waits, so that the death of this process loses none of it; tells of the disk's failure and
  /// of its return; of events that were dropped; notes steps of the wall clock.
  void Step() noexcept;
  /// Brings what was committed to the disk.
  void Sync() noexcept;
  /// Ends the session with all that waited when it was called; Step and Sync may not run meanwhile, and
  /// nothing but destruction may follow. Throws SessionRefused (kStorageFailed): then the session goes on,
  /// and may be ended again, unless it was given up.
  SessionInfo End();
  /// It will never be ended: its file is left to be recovered.
  bool given_up() const { return given_up_; }

  /// As it stands now.
  SessionInfo info() const;

 private:
  struct Waiting {
    std::shared_ptr<const SampleBlock> block;
    /// How many samples were dropped before it, and why.
    uint64_t dropped = 0;
    std::string drop_reason;
  };

  template <typename Action>
  void GiveUpWhere(const Action& action) noexcept;
  void SetEnding(bool ending);
  void TakeQueue();
  void Append(const Waiting& waiting);
  void NoteStart(const exchange::Sample& first);
  void CheckWallClock();
  bool TryCommit();
  void TellDroppedEvents();
  void TellFailure(const std::string& what, bool disk_full);
  void TellRestored();
  std::optional<Gap> LastGap() const;

  NewSession session_;
  const uint64_t first_tick_;
  const std::optional<exchange::Sample> seen_;
  const std::size_t queue_samples_;
  const SessionReport report_;
  const SessionClocks clocks_;

  mutable std::mutex mutex_;
  std::deque<Waiting> queue_;
  std::size_t queued_samples_ = 0;
  // Since the newest block that waits, and in all.
  uint64_t dropping_ = 0;
  uint64_t dropped_samples_ = 0;
  // Of the newest that were dropped.
  std::string drop_reason_;
  // Why the disk does not take anything, while it does not.
  std::string failure_;
  uint64_t dropped_events_ = 0;
  std::vector<Event> events_;
  std::vector<Marker> markers_;
  uint64_t marker_count_ = 0;
  uint64_t sample_count_ = 0;
  uint64_t first_sample_tick_ = 0;
  uint64_t last_sample_tick_ = 0;
  // What Sync met, for Step to tell.
  std::optional<StorageError> sync_failure_;
  bool ending_ = false;
  std::atomic<bool> given_up_ = false;

  // The writing thread's alone.
  int64_t wall_offset_ns_ = 0;
  bool commit_failing_ = false;
  bool failure_told_ = false;
  int64_t retry_ns_ = 0;
  uint64_t dropped_before_failure_ = 0;
};

}  // namespace mwidth::record
