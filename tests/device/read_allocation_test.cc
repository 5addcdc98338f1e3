// Counts what the process allocates, by standing in for operator new, which every container ends in.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <sstream>

#include "device/simulated_drive.h"
#include "tests/support/temporary_file.h"

namespace {

std::atomic<uint64_t> allocations{0};

}  // namespace

// Not inlined: the compiler would see malloc's memory go to delete, and warn.
// NOLINTBEGIN(cppcoreguidelines-no-malloc,misc-new-delete-overloads)
[[gnu::noinline]] void* operator new(std::size_t size) {
  allocations.fetch_add(1);
  if (void* memory = std::malloc(size)) {
    return memory;
  }
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc,misc-new-delete-overloads)

namespace mwidth::device {
namespace {

TEST(SimulatedDriveAllocation, NeitherReadsNorWritesAllocate) {
  std::ostringstream recording;
  recording << "time_s,angle_rad\n";
  for (int sample = 0; sample < 100; ++sample) {
    recording << sample * 0.01 << ',' << sample % 7 * 0.01 << '\n';
  }
  const TemporaryFile file(recording.str());
  const uint64_t before_set_up = allocations.load();
  SimulatedDrive drive({.loop = {.device_mass = 0.2,
                                 .device_damping = 0.1,
                                 .hand_damping = 1,
                                 .hand_stiffness = 25,
                                 .period_s = 1e-3,
                                 .cutoff_hz = 20,
                                 .delay_s = 1.5e-3},
                        .position_quantum = 1e-5,
                        .force_quantum = 1e-3},
                       std::make_unique<RecordedMotion>(file.path(), model::AxisKind::kRotary));
  const uint64_t before = allocations.load();
  ASSERT_GT(before, before_set_up) << "the counter sees nothing";
  drive.Enable();
  for (uint64_t tick = 0; tick < 20'000; tick += 1 + tick % 3) {
    drive.Read(tick);
    drive.Write(static_cast<int32_t>(tick % 100));
  }
  drive.Disable();
  drive.Read(1'000'000);
  EXPECT_EQ(allocations.load(), before);
}

}  // namespace
}  // namespace mwidth::device
