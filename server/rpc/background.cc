#include "server/rpc/background.h"

#include <pthread.h>
#include <sched.h>

namespace mwidth::rpc {

void LowerPriority() noexcept {
  const sched_param none{};
  // Always allowed to an ordinary thread; there is nothing to do where it is not.
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_IDLE, &none));
}

}  // namespace mwidth::rpc
