// Which system calls the loop's thread makes, by a seccomp filter that lets it sleep and nothing else.

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "server/render/loop.h"
#include "tests/server/render/axis.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MWIDTH_SANITIZER_MAKES_SYSTEM_CALLS 1
#else
#define MWIDTH_SANITIZER_MAKES_SYSTEM_CALLS 0
#endif

namespace mwidth::render {
namespace {

std::atomic<int> stray_calls{0};
std::atomic<int> last_stray_call{0};

// A call that was not let through: counted, and answered as one that the kernel does not have.
void CountStrayCall(int, siginfo_t* info, void* context) {
  stray_calls.fetch_add(1);
  last_stray_call.store(info->si_syscall);
  auto* registers = &static_cast<ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  registers->gregs[REG_RAX] = -ENOSYS;
#elif defined(__aarch64__)
  registers->regs[0] = -ENOSYS;
#endif
}

// From here on the calling thread may sleep until a deadline, read the clock (a system call only where the
// kernel cannot show it in memory), return from the handler above, and end. False where the host has no
// seccomp.
bool LetOnlySleep() {
  struct sigaction action {};
  action.sa_sigaction = CountStrayCall;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);
  constexpr std::array<uint32_t, 4> kAllowed = {SYS_clock_nanosleep, SYS_clock_gettime, SYS_rt_sigreturn,
                                                SYS_exit};
  std::array<sock_filter, kAllowed.size() + 3> filter{};
  filter[0] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  for (std::size_t i = 0; i < kAllowed.size(); ++i) {
    // Where it matches: to the last statement.
    const auto to_the_end = static_cast<uint8_t>(kAllowed.size() - i);
    filter.at(1 + i) = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kAllowed.at(i), to_the_end, 0);
  }
  filter.at(kAllowed.size() + 1) = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
  filter.at(kAllowed.size() + 2) = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  sock_fprog program{.len = filter.size(), .filter = filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

// Swings the arm, filters the thread that reads it, and notes what was counted when it was last disabled: the
// end of the thread, after that, is the library's.
class FilteringDrive final : public device::Drive {
 public:
  explicit FilteringDrive(std::function<void()> also = [] {}) : also_(std::move(also)) {}

  device::DriveInfo Info() const noexcept override { return drive_.Info(); }
  device::Enabling Enable() noexcept override { return drive_.Enable(); }
  void Disable() noexcept override {
    drive_.Disable();
    calls_at_last_disable = stray_calls.load();
  }
  device::Reading Read(uint64_t tick) noexcept override {
    if (!filtered_) {
      filtered_ = true;
      can_filter = LetOnlySleep();
    }
    also_();
    drive_.answers_reads = answers;
    drive_.position_counts = std::llround(1e5 * (1 - std::cos(0.012 * static_cast<double>(tick))));
    return drive_.Read(tick);
  }
  bool Write(int32_t force_counts) noexcept override { return drive_.Write(force_counts); }

  std::atomic<bool> can_filter{true};
  std::atomic<bool> answers{true};
  std::atomic<int> calls_at_last_disable{0};

 private:
  const std::function<void()> also_;
  ScriptedDrive drive_;
  bool filtered_ = false;
};

class LoopSystemCallTest : public testing::Test {
 protected:
  void SetUp() override {
    if (MWIDTH_SANITIZER_MAKES_SYSTEM_CALLS != 0) {
      GTEST_SKIP() << "the sanitizer makes system calls of its own";
    }
  }
  void Start(FilteringDrive& drive, exchange::Clock& clock) {
    stray_calls = 0;
    loop = std::make_unique<Loop>(drive, *crossing, clock, config);
    loop->Start();
    WaitUntil([this] { return status.tick > 20; });
  }
  void WaitUntil(const std::function<bool()>& reached) {
    exchange::Sample sample;
    do {
      std::this_thread::yield();
      crossing->status.Take(status);
      while (crossing->samples.Pop(sample)) {
      }
    } while (!reached());
  }
  void WaitTicks(uint64_t ticks) {
    WaitUntil([this, end = status.tick + ticks] { return status.tick >= end; });
  }
  void Post() {
    ++settings.sequence;
    crossing->settings.Post(settings);
  }
  // Until RENDERING, however often a stall of the host ends it as an overrun.
  void Render(double mass) {
    settings.rendering = true;
    settings.mass = mass;
    settings.ramp_s = 0.01;
    settings.lease_deadline_ns = INT64_MAX;
    do {
      settings.cleared_fault_number = status.fault.number;
      Post();
      WaitTicks(3);
      ++settings.render_epoch;
      Post();
      WaitTicks(30);
    } while (status.state != exchange::State::kRendering);
  }

  const LoopConfig config = TestConfig();
  const std::unique_ptr<exchange::Crossing> crossing = std::make_unique<exchange::Crossing>();
  exchange::Settings settings;
  exchange::LoopStatus status;
  std::unique_ptr<Loop> loop;
};

TEST_F(LoopSystemCallTest, TheFilterSeesACallThatDoesNotBelong) {
  FilteringDrive drive([] { getppid(); });
  exchange::MonotonicClock clock;
  Start(drive, clock);
  if (!drive.can_filter) {
    GTEST_SKIP() << "this host has no seccomp filters";
  }
  loop->Stop();
  EXPECT_GT(drive.calls_at_last_disable.load(), 0);
}

TEST_F(LoopSystemCallTest, TheLoopOnlySleepsWhateverHappens) {
  for (const int64_t spin_ns : {0, 200'000}) {
    FilteringDrive drive;
    exchange::MonotonicClock clock(spin_ns);
    Start(drive, clock);
    if (!drive.can_filter) {
      GTEST_SKIP() << "this host has no seccomp filters";
    }
    Render(0.1);
    settings.filter.cutoff_hz = 30;  // A change of filter, by way of a mass of zero.
    settings.mass = -0.02;
    Post();
    WaitTicks(500);
    Render(-0.02);
    drive.answers = false;  // A silent drive, its fault, and a second start.
    WaitUntil([this] { return status.state == exchange::State::kFault; });
    drive.answers = true;
    Render(0.05);
    ++settings.emergency_stops;
    Post();
    WaitUntil([this] { return status.state == exchange::State::kFault; });
    Render(0.05);
    settings.rendering = false;
    Post();
    WaitTicks(300);
    Render(0.05);  // So that the stop of the loop has a ramp.
    loop->Stop();
    EXPECT_EQ(drive.calls_at_last_disable.load(), 0) << "the last one was number " << last_stray_call.load();
  }
}

}  // namespace
}  // namespace mwidth::render
