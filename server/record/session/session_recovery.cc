#include "server/record/session/session_recovery.h"

#include <vector>

#include "server/record/session/session_file.h"
#include "server/record/session/session_reader.h"
#include "server/record/session/wall_time.h"

namespace mwidth::record {
namespace {

// When the last sample that can be read was, by the wall clock.
int64_t EndOf(SessionReader& reader) {
  const SessionInfo& info = reader.info();
  std::vector<exchange::Sample> samples;
  int64_t monotonic_ns = info.start_monotonic_ns;
  // From the last block, or, where that is damaged, from the first.
  for (const uint64_t tick : {info.last_tick, uint64_t{0}}) {
    reader.Seek(tick);
    bool any = false;
    while (reader.Next(samples)) {
      monotonic_ns = samples.back().monotonic_ns;
      any = true;
    }
    if (any) {
      break;
    }
  }
  return WallTime(info, reader.WallClockSteps(), monotonic_ns);
}

}  // namespace

void RecoverSession(const std::filesystem::path& file) {
  int64_t end_wall_ns = 0;
  uint64_t last_tick = 0;
  {
    SessionReader reader(file);
    end_wall_ns = EndOf(reader);
    last_tick = reader.info().last_tick;
  }
  SessionFile session = SessionFile::Reopen(file);
  session.Add(
      Gap{.after_tick = last_tick,
          .before_tick = 0,
          .missed_ticks = 0,
          .lost_ticks = 0,
          .reason = "the server died or lost its disk: what it recorded after this tick is lost, and nobody "
                    "knows how much that was (with a sound disk at most the last 0.1 s, or the last second "
                    "where the power failed)"});
  session.End(SessionState::kRecovered, end_wall_ns);
}

}  // namespace mwidth::record
