// A stored session as a stream of batches, events and markers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "mwidth/v1/session.pb.h"
#include "server/record/batcher.h"
#include "server/record/session/session_reader.h"

namespace mwidth::rpc {

struct PlaybackRequest {
  uint64_t first_tick = 0;
  uint64_t last_tick = std::numeric_limits<uint64_t>::max();
  std::size_t max_batch = 0;
};

/// Hands what the session has, in the order of time, to `take`. An event or a marker comes before the first
/// sample that is later. Of a session that grows, what it had when it was opened. Ends early where `take`
/// returns false. Throws record::SessionFileError.
void Play(record::SessionReader& session, const PlaybackRequest& request,
          const std::function<bool(const v1::ReadSessionResponse&)>& take);

}  // namespace mwidth::rpc
