// A library to preload: shows one program a wall clock that a test moves, while the monotonic clock stays
// true.
//
// The file named by WALL_CLOCK_OFFSET_FILE holds how far the wall clock is off, a 64-bit integer of
// nanoseconds. Debian's libfaketime does the same for most programs, but its version 0.9.10 lets an absolute
// sleep on the monotonic clock, which is what a real-time loop lives on, return at once.
//
// As in the kernel, who waits for a time of the wall clock is woken when that clock gets there, by passing or
// by jumping: such waits are cut into short ones, and end with what looks like a spurious wake-up until the
// time has come.

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <ctime>

namespace {

constexpr int64_t kNsPerSecond = 1'000'000'000;
constexpr int64_t kSliceNs = 20'000'000;
// A time before 2001 is none of the wall clock's: conditions may wait on the monotonic one.
constexpr int64_t kFirstWallNs = kNsPerSecond * kNsPerSecond;

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int64_t OffsetNs() {
  static const std::atomic<int64_t>* const offset = [] {
    static constexpr std::atomic<int64_t> kNone{0};
    const char* name = std::getenv("WALL_CLOCK_OFFSET_FILE");
    const int file = name == nullptr ? -1 : open(name, O_RDONLY | O_CLOEXEC);
    void* memory = file < 0 ? MAP_FAILED : mmap(nullptr, sizeof(int64_t), PROT_READ, MAP_SHARED, file, 0);
    return memory == MAP_FAILED ? &kNone : static_cast<const std::atomic<int64_t>*>(memory);
  }();
  return offset->load(std::memory_order_relaxed);
}

int64_t Ns(const timespec& time) { return time.tv_sec * kNsPerSecond + time.tv_nsec; }
timespec Time(int64_t ns) { return {.tv_sec = ns / kNsPerSecond, .tv_nsec = ns % kNsPerSecond}; }

int64_t TrueWallNs() {
  static auto* const real = Real<int(clockid_t, timespec*)>("clock_gettime");
  timespec now{};
  real(CLOCK_REALTIME, &now);
  return Ns(now);
}

// By the true wall clock: the end of a slice of the wait for `shown`, or that time itself.
timespec EndOfSlice(const timespec& shown) {
  return Time(std::min(Ns(shown) - OffsetNs(), TrueWallNs() + kSliceNs));
}
bool HasCome(const timespec& shown) { return TrueWallNs() + OffsetNs() >= Ns(shown); }

}  // namespace

// The C library's declarations name their parameters in its own way, and its syscall takes pointers as
// numbers. NOLINTBEGIN(readability-inconsistent-declaration-parameter-name,performance-no-int-to-ptr)
extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static auto* const real = Real<int(clockid_t, timespec*)>("clock_gettime");
  const int result = real(clock, time);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) {
    *time = Time(Ns(*time) + OffsetNs());
  }
  return result;
}

int gettimeofday(timeval* time, void*) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  *time = {.tv_sec = now.tv_sec, .tv_usec = now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* time) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (time != nullptr) {
    *time = now.tv_sec;
  }
  return now.tv_sec;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  static auto* const real =
      Real<int(pthread_cond_t*, pthread_mutex_t*, const timespec*)>("pthread_cond_timedwait");
  if (Ns(*until) < kFirstWallNs) {
    return real(condition, mutex, until);
  }
  const timespec end = EndOfSlice(*until);
  const int result = real(condition, mutex, &end);
  return result == ETIMEDOUT && !HasCome(*until) ? 0 : result;
}

// Waits of the C++ libraries call the futex directly.
long syscall(long number, ...) noexcept {
  static auto* const real = Real<long(long, ...)>("syscall");
  va_list list;
  va_start(list, number);
  const long a = va_arg(list, long);
  const long b = va_arg(list, long);
  const long c = va_arg(list, long);
  const long d = va_arg(list, long);
  const long e = va_arg(list, long);
  const long f = va_arg(list, long);
  va_end(list);
  const auto* until = reinterpret_cast<const timespec*>(d);
  if (number != SYS_futex || (b & FUTEX_CLOCK_REALTIME) == 0 || until == nullptr) {
    return real(number, a, b, c, d, e, f);
  }
  const timespec end = EndOfSlice(*until);
  const long result = real(number, a, b, c, &end, e, f);
  return result < 0 && errno == ETIMEDOUT && !HasCome(*until) ? 0 : result;
}
}
// NOLINTEND(readability-inconsistent-declaration-parameter-name,performance-no-int-to-ptr)
