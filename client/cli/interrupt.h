// Ctrl-C as a stop token.
#pragma once

#include <stop_token>
#include <thread>

namespace mwidth::cli {

/// While it lives, SIGINT, SIGTERM and SIGHUP request stop instead of ending the process, so that the caller
/// can give control back. Another one, more than a second later, ends it at once; the lease then expires by
/// itself.
///
/// Construct it before any other thread starts: the threads inherit the mask that keeps the signals for this
/// one.
class Interrupt {
 public:
  Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt() = default;

  std::stop_token token() const { return interrupted_.get_token(); }

 private:
  std::stop_source interrupted_;
  std::jthread waiter_;
};

}  // namespace mwidth::cli
