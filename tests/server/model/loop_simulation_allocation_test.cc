// Counts what the process allocates, by standing in for operator new.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

#include "server/model/loop_simulation.h"

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

namespace mwidth::model {
namespace {

TEST(LoopSimulationAllocation, NoStepAllocates) {
  const uint64_t before_counting = allocations.load();
  std::vector<double> hand(1000);
  ASSERT_GT(allocations.load(), before_counting) << "the counter sees nothing";
  for (std::size_t tick = 0; tick < hand.size(); ++tick) {
    hand[tick] = 1e-6 * static_cast<double>(tick * tick % 3000);
  }
  const LoopParameters loop{.device_mass = 0.07,
                            .hand_damping = 5,
                            .hand_stiffness = 700,
                            .period_s = 1e-3,
                            .cutoff_hz = 10,
                            .delay_s = 1.5e-3};
  for (const double friction : {0.0, 0.5}) {
    const uint64_t before = allocations.load();
    LoopSimulation simulation(
        loop, 0.2,
        {.position_quantum = 1e-5, .force_quantum = 1e-3, .coulomb_friction = friction, .force_limit = 1});
    double position = 0;
    for (const double hand_position : hand) {
      position = simulation.Step(hand_position).position;
    }
    simulation.Reset(0, 1, 0);
    EXPECT_NE(position, 0);
    EXPECT_EQ(allocations.load(), before);
  }
}

}  // namespace
}  // namespace mwidth::model
