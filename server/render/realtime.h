// What a thread asks of the host so that it wakes on time.
#pragma once

#include <string>

#include "server/render/loop_config.h"

namespace mwidth::render {

/// What the host granted.
struct RealtimeReport {
  /// Everything that was asked for was granted: real-time scheduling, locked memory, the CPU, idle states.
  bool realtime = false;
  /// For a person: what was granted or, for each refusal, the reason and what to do about it.
  std::string message;
};

/// Locks the process's memory, faults in the calling thread's stack, pins the thread and raises its priority.
/// What is refused is left as it was. The loop's thread before its first tick; not Rt: it allocates.
RealtimeReport EnterRealtime(const RealtimeConfig& config);

/// Adds what else was refused; an empty text changes nothing.
void AddRefusal(const std::string& refusal, RealtimeReport& report);

}  // namespace mwidth::render
