// A recorder that is going to be killed: `killed_recorder FOLDER SEED` records ten ticks a millisecond until
// then, and keeps the newest one in FOLDER/newest-tick, which outlives it.
#include <atomic>
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

namespace {

using mwidth::exchange::Sample;
namespace record = mwidth::record;

int64_t Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::atomic<uint64_t>* NewestTick(const std::filesystem::path& folder) {
  const int file = open((folder / "newest-tick").c_str(), O_CREAT | O_RDWR, 0600);
  if (file < 0 || ftruncate(file, sizeof(std::atomic<uint64_t>)) != 0) {
    std::abort();
  }
  void* memory = mmap(nullptr, sizeof(std::atomic<uint64_t>), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return static_cast<std::atomic<uint64_t>*>(memory);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::mt19937_64 random(std::strtoull(argv[2], nullptr, 10));
  std::atomic<uint64_t>* newest = NewestTick(folder);
  record::SwingingArm arm;
  record::SessionStore store(folder, 0);
  record::SessionRecorder recorder(
      store, {}, [](record::EventKind, const std::string&, const std::map<std::string, std::string>&) {},
      {.wall_ns = Now, .monotonic_ns = Now});
  const record::SessionInfo info = record::InfoOf(arm.axis());
  recorder.Start(info.labels, info.axis, info.provenance, 1);
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
    newest->store(tick);
  }
}
