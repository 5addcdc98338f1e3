// Sessions as a server records them, with all that exports must not lose; seeded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/event.h"
#include "server/record/session/session_info.h"

namespace mwidth::testing {

struct RecordedSession {
  record::SessionInfo info;
  std::vector<exchange::Sample> samples;
  std::vector<record::Event> events;
  std::vector<record::Marker> markers;
  std::vector<record::WallClockStep> steps;
};

/// `count` samples of a rotary or linear axis at 1 kHz: doubles with all their digits, signed zeros and
/// numbers near the ends of their range among them; some ticks missed, some lost; a change of filter; texts
/// with quotes, commas, tabs, line breaks and letters beyond ASCII; three trials, the last without an end.
RecordedSession MakeSession(uint64_t seed, uint64_t count, bool rotary);

/// Writes it as a server does, in commits of about a tenth of a second, and ends it, unless `end` is false.
void Write(const RecordedSession& session, const std::filesystem::path& file, bool end = true);

}  // namespace mwidth::testing
