#include "client/cli/interrupt.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>

namespace mwidth::cli {
namespace {

// A shell and its `timeout` may both pass on what was one Ctrl-C: what follows within this time says nothing
// new.
constexpr std::chrono::seconds kOneInterrupt{1};

void WaitForSignals(const std::stop_token& end, const std::stop_source& interrupted,
                    const sigset_t& signals) {
  // sigtimedwait cannot wait for a stop token too, hence the short turns.
  const timespec turn{.tv_sec = 0, .tv_nsec = 50'000'000};
  std::chrono::steady_clock::time_point first;
  while (!end.stop_requested()) {
    const int signal = sigtimedwait(&signals, nullptr, &turn);
    const auto now = std::chrono::steady_clock::now();
    if (signal > 0 && interrupted.request_stop()) {
      first = now;
    } else if (signal > 0 && now - first > kOneInterrupt) {
      std::_Exit(128 + signal);
    }
  }
}

}  // namespace

Interrupt::Interrupt() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    sigaddset(&signals, signal);
  }
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  waiter_ = std::jthread(
      [this, signals](const std::stop_token& end) { WaitForSignals(end, interrupted_, signals); });
}

}  // namespace mwidth::cli
