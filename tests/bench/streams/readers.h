// The far end: many subscribers in one process, each with a connection of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace mwidth::bench {

/// What all subscribers got so far.
struct Received {
  std::atomic<uint64_t> subscribers = 0;  ///< that got something
  std::atomic<uint64_t> samples = 0;
  std::atomic<uint64_t> messages = 0;
  std::atomic<uint64_t> absent_ticks = 0;
};

/// Reads until `over`. Batches of exactly `batch` samples; 1: whatever the server sends.
void ReadGrpc(const std::string& address, std::size_t subscribers, std::size_t batch, Received& received,
              const std::atomic<bool>& over);
void ReadTcp(const std::string& address, std::size_t subscribers, Received& received,
             const std::atomic<bool>& over);

}  // namespace mwidth::bench
