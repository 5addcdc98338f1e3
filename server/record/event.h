// Something that happened on an axis and is told in words: a state, a refusal, a fault, a disk that is full.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace mwidth::record {

/// The numbers are in files: never change one, only append.
enum class EventKind : uint8_t {
  kUnknown = 0,
  kStateChanged = 1,
  kFault = 2,
  kEmergencyStop = 3,
  kControlAcquired = 4,
  kControlReleased = 5,
  kMassSet = 6,
  kMassRefused = 7,
  kFilterSet = 8,
  kFilterRefused = 9,
  kTicksMissed = 10,
  kSamplesDropped = 11,
  kSessionStarted = 12,
  kSessionEnded = 13,
  kStorageFailed = 14,
  kStorageRestored = 15,
  kWallClockStepped = 16,
  kServerStopping = 17,
};

/// One entry of an axis's log. `metadata` has the figures of `message`; its keys are those that a refusal of
/// the API carries (mass, gain_margin_db, admitted_min, ...).
struct Event {
  /// From 1, one higher with each event of the axis since the server began; 0: not numbered yet.
  uint64_t number = 0;
  EventKind kind = EventKind::kUnknown;
  /// The newest tick when it happened, or the tick that it is about.
  uint64_t tick = 0;
  /// The axis's clock.
  int64_t monotonic_ns = 0;
  /// For a person: what happened, and where there is something to do, what.
  std::string message{};
  std::map<std::string, std::string> metadata{};

  bool operator==(const Event&) const = default;
};

}  // namespace mwidth::record
