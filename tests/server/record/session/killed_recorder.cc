// A recorder that is going to be killed: `killed_recorder FOLDER SEED` records ten ticks a millisecond until
// then, and keeps in FOLDER/witness, which outlives it, the newest one, and for how long the host held up the
// thread that commits.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <thread>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "server/record/session/session_recorder.h"
#include "tests/server/record/session/recording.h"
#include "tests/server/record/session/witness.h"

namespace {

using mwidth::exchange::Sample;
namespace record = mwidth::record;

constexpr int64_t kPeriodNs = std::chrono::nanoseconds(record::SessionRecorder::kCommitPeriod).count();

int64_t Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

record::Witness* WitnessIn(const std::filesystem::path& folder) {
  const int file = open((folder / "witness").c_str(), O_CREAT | O_RDWR, 0600);
  if (file < 0 || ftruncate(file, sizeof(record::Witness)) != 0) {
    std::abort();
  }
  void* memory = mmap(nullptr, sizeof(record::Witness), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return static_cast<record::Witness*>(memory);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::mt19937_64 random(std::strtoull(argv[2], nullptr, 10));
  record::Witness* witness = WitnessIn(folder);
  record::SwingingArm arm;
  record::SessionStore store(folder, 0);
  record::SessionRecorder recorder(
      store, {}, [](record::EventKind, const std::string&, const std::map<std::string, std::string>&) {},
      {.wall_ns =
           [witness, caller = std::this_thread::get_id()] {
             // The thread that commits asks for it once a step, and before its commit.
             const int64_t now_ns = Now();
             if (std::this_thread::get_id() != caller) {
               const int64_t last_ns = witness->step_ns.exchange(now_ns);
               const int64_t late_ns = last_ns == 0 ? 0 : now_ns - last_ns - kPeriodNs;
               witness->held_up_ns = std::max(witness->held_up_ns.load(), late_ns);
             }
             return now_ns;
           },
       .monotonic_ns = Now});
  const record::SessionInfo info = record::InfoOf(arm.axis());
  recorder.Start(info.labels, info.axis, info.provenance, 1);
  int64_t none = 0;
  witness->step_ns.compare_exchange_strong(none, Now());  // where the first step did not come yet
  std::puts("recording");
  std::fflush(stdout);
  for (uint64_t i = 1;; ++i) {
    // As much as was slept, no more: a computer that is busy makes a slow loop, not a burst.
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    auto block = std::make_shared<record::SampleBlock>(arm.Take(50));
    const uint64_t tick = block->back().tick;
    if (random() % 40 == 0) {
      block->erase(block->begin() + 10, block->begin() + 20);  // lost on the way here
    }
    recorder.Consume(block);
    recorder.AddMarker({.label = "m", .kind = "", .metadata = {}});
    witness->newest_tick = tick;
  }
}
