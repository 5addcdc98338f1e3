// What else a server may have to do: many streams, a storm of requests, a busy disk. A process of its own.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace mwidth::bench {

/// What the other process did and saw. Sums over its streams.
struct OverloadReport {
  uint64_t streams = 0;
  uint64_t samples = 0;
  uint64_t batches = 0;
  /// Ticks that ran but did not reach a stream.
  uint64_t lost = 0;
  uint64_t masses_set = 0;
  uint64_t megabytes_written = 0;
  /// Why it is no use; empty where it is.
  std::string error;
};

/// The body of that process: 256 streams in batches of at most 10, eight threads that set masses as fast as
/// they are answered, and one that writes and syncs a file. Takes control and renders first; prints "ready",
/// goes on until standard input ends, and prints the report. Returns the exit code.
int RunOverload(const std::string& address);

/// That process, as seen from the one that starts it.
class Overload {
 public:
  /// Starts this very program with `--overload ADDRESS`, and waits until it renders. Throws
  /// std::runtime_error.
  explicit Overload(const std::string& address);
  Overload(const Overload&) = delete;
  Overload& operator=(const Overload&) = delete;
  ~Overload();

  /// Ends it; once.
  OverloadReport End();

 private:
  std::string ReadLine() const;
  void CloseInput();

  pid_t process_ = -1;
  int input_ = -1;
  int output_ = -1;
};

}  // namespace mwidth::bench
