#include "server/render/realtime.h"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <system_error>

namespace mwidth::render {
namespace {

// More than the tick's deepest call ever needs, links of real drives included.
constexpr std::size_t kStackBytes = 512UL * 1024;
constexpr std::size_t kPageBytes = 4096;

std::string Reason(int error) { return std::generic_category().message(error); }

// A limit does not bind whoever has CAP_IPC_LOCK; a user identity says nothing about that inside a container.
bool MayLockWithoutLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) {
    return true;
  }
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> data{};
  return syscall(SYS_capget, &header, data.data()) == 0 &&
         (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

// Empty, or the refusal.
std::string LockMemory() {
  // Under a finite limit mlockall can succeed today and make an allocation of another thread fail tomorrow.
  if (!MayLockWithoutLimit()) {
    return "memory is not locked (RLIMIT_MEMLOCK is finite): set 'memlock unlimited' in "
           "/etc/security/limits.conf "
           "or LimitMEMLOCK=infinity in the service unit, or grant CAP_IPC_LOCK";
  }
  // All that is mapped now is brought in and stays, code included: an emergency must not wait for the disk.
  // What is mapped later, such as other threads' stacks, stays once it is touched, and does not cost before.
  if (mlockall(MCL_CURRENT) != 0 || mlockall(MCL_FUTURE | MCL_ONFAULT) != 0) {
    return "memory is not locked (" + Reason(errno) + "): grant CAP_IPC_LOCK, or give the host more memory";
  }
  return {};
}

// Touches the stack once, so that the tick never waits for a page of it.
[[gnu::noinline]] void PrefaultStack() {
  std::array<volatile std::byte, kStackBytes>
      stack;  // NOLINT(*-member-init): touching it is all that it is for
  for (std::size_t i = 0; i < stack.size(); i += kPageBytes) {
    stack[i] = std::byte{0};  // NOLINT(*-constant-array-index): the loop's bound is the array's
  }
}

std::string Pin(int cpu) {
  if (cpu < 0) {
    return {};
  }
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  if (cpu < CPU_SETSIZE) {
    CPU_SET(static_cast<std::size_t>(cpu), &cpus);
  }
  const int error = pthread_setaffinity_np(pthread_self(), sizeof(cpus), &cpus);
  if (error == 0) {
    return {};
  }
  return "not pinned to CPU " + std::to_string(cpu) + " (" + Reason(error) +
         "): choose a CPU that this process may use (taskset -cp " + std::to_string(getpid()) +
         " lists them)";
}

std::string Schedule(int priority) {
  if (priority == 0) {
    return "real-time scheduling is not asked for: set a priority of 1 to 99";
  }
  const sched_param parameters{.sched_priority = priority};
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error == 0) {
    return {};
  }
  return "real-time scheduling is refused (SCHED_FIFO, priority " + std::to_string(priority) + ": " +
         Reason(error) +
         "): set 'rtprio 99' in /etc/security/limits.conf or LimitRTPRIO=99 in the service unit, or grant "
         "CAP_SYS_NICE; in a container, --cap-add=SYS_NICE --ulimit rtprio=99";
}

}  // namespace

RealtimeReport EnterRealtime(const RealtimeConfig& config) {
  const std::array<std::string, 3> refusals = {LockMemory(), Pin(config.cpu), Schedule(config.priority)};
  PrefaultStack();
  RealtimeReport report{.realtime = true,
                        .message = "SCHED_FIFO priority " + std::to_string(config.priority) +
                                   ", memory locked" +
                                   (config.cpu < 0 ? "" : ", CPU " + std::to_string(config.cpu))};
  for (const std::string& refusal : refusals) {
    AddRefusal(refusal, report);
  }
  return report;
}

void AddRefusal(const std::string& refusal, RealtimeReport& report) {
  if (refusal.empty()) {
    return;
  }
  report.message = report.realtime ? refusal : report.message + "; " + refusal;
  report.realtime = false;
}

}  // namespace mwidth::render
