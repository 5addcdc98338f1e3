#include "server/gate/wait_for_loop.h"

#include <chrono>
#include <thread>

namespace mwidth::gate {

bool WaitUpToOneSecond(const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  while (!done()) {
    if (std::chrono::steady_clock::now() >= end) {
      return done();
    }
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  return true;
}

}  // namespace mwidth::gate
