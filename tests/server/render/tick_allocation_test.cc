// Counts what the process allocates, by standing in for the C library's allocator.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#include "server/exchange/clock.h"
#include "server/exchange/tick_statistics.h"
#include "server/render/timed_drive.h"
#include "tests/server/render/axis.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MWIDTH_ALLOCATOR_IS_THE_SANITIZERS 1
#else
#define MWIDTH_ALLOCATOR_IS_THE_SANITIZERS 0
#endif

namespace {

std::atomic<uint64_t> allocations{0};

}  // namespace

#if !MWIDTH_ALLOCATOR_IS_THE_SANITIZERS
// glibc's own names for the functions that are replaced; operator new ends in malloc.
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-identifier-naming)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  allocations.fetch_add(1);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  allocations.fetch_add(1);
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  allocations.fetch_add(1);
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  allocations.fetch_add(1);
  return __libc_memalign(alignment, size);
}
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-identifier-naming)
#endif

namespace mwidth::render {
namespace {

class TickAllocationTest : public testing::Test {
 protected:
  void SetUp() override {
    if (MWIDTH_ALLOCATOR_IS_THE_SANITIZERS != 0) {
      GTEST_SKIP() << "the sanitizer brings its own allocator";
    }
  }
};

TEST_F(TickAllocationTest, TheCounterSeesAllocations) {
  const uint64_t before = allocations.load();
  auto* memory = new (std::nothrow) volatile int(3);
  EXPECT_GT(allocations.load(), before);
  delete memory;
}

TEST_F(TickAllocationTest, NoTickAllocatesInAnyState) {
  Axis axis;
  const uint64_t before = allocations.load();
  axis.RunTicks(100);
  axis.RenderSwinging(0.3);
  for (const model::EstimatorKind kind : model::kEstimatorKinds) {
    axis.settings.filter = {.estimator = static_cast<uint8_t>(kind), .cutoff_hz = 30};
    axis.Post();
    for (int k = 0; k < 500; ++k) {
      axis.Swing();
    }
    EXPECT_EQ(axis.status.filter, axis.settings.filter);
  }
  axis.Swing(3);
  axis.drive.answers_reads = false;
  axis.Swing();
  axis.drive.answers_reads = true;
  axis.StopRendering();
  axis.RunTicks(300);
  axis.Start(-0.1, 0.01);
  axis.RunTicks(50);
  axis.SetPosition(2);  // A position and velocity fault, its ramp, and the disabled drive after it.
  axis.RunTicks(100);
  axis.ClearFault();
  axis.RunTicks(10);
  axis.SetPosition(0);
  axis.Start(0.2, 0);
  axis.RunTicks(10);
  axis.settings.mass = std::nan("");
  axis.Post();
  axis.RunTicks(10);
  axis.EmergencyStop();
  axis.RunTicks(10);
  axis.ClearFault();
  axis.MoveTo(-0.5);
  axis.RunTicks(1000);
  axis.Start(0.3, 0);  // Gaps and late forces, until that is a fault.
  for (int i = 0; i < 500; ++i) {
    axis.drive.answers_reads = i % 2 == 0;
    axis.tick_under_test().ReportLoopDelay(2'000'000);
    axis.Run();
  }
  EXPECT_EQ(axis.status.fault.fault, exchange::Fault::kLoopDelay);
  axis.EmergencyStop();
  axis.Run();
  // Enough to fill the ring: dropping must not allocate either.
  for (uint64_t k = 0; k < exchange::kSampleRingCapacity + 10; ++k) {
    axis.tick_under_test().Run(++axis.tick, axis.now_ns, 0);
  }
  axis.tick_under_test().Close();
  const uint64_t after = allocations.load();
  EXPECT_EQ(after - before, 0);
  EXPECT_EQ(axis.status.fault.fault, exchange::Fault::kEmergencyStop);
}

TEST_F(TickAllocationTest, NothingAroundATickAllocates) {
  ScriptedDrive drive;
  exchange::MonotonicClock clock(10'000);
  const auto statistics = std::make_unique<exchange::TickStatistics>();
  const uint64_t before = allocations.load();
  TimedDrive timed(drive, clock);
  timed.Enable();
  for (uint64_t tick = 1; tick <= 100; ++tick) {
    clock.SleepUntilNs(clock.NowNs() + 20'000);
    timed.Read(tick);
    timed.Write(1);
    const DriveTimes times = timed.TakeTimes();
    statistics->Record({.io_ns = times.io_ns, .loop_delay_ns = times.loop_delay_ns, .missed_ticks = tick});
  }
  timed.Disable();
  EXPECT_EQ(statistics->loop_delay().Figures().count, 100);
  EXPECT_EQ(allocations.load() - before, 0);
}

}  // namespace
}  // namespace mwidth::render
