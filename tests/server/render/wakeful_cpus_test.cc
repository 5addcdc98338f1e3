#include "server/render/wakeful_cpus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace mwidth::render {
namespace {

using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::IsEmpty;

struct IdleThread {
  int id;
  /// -1 where it may run on several.
  int cpu;
};

int OnlyCpuOf(int thread) {
  cpu_set_t set;
  if (sched_getaffinity(thread, sizeof(set), &set) != 0 || CPU_COUNT(&set) != 1) {
    return -1;
  }
  int cpu = 0;
  while (!CPU_ISSET(static_cast<std::size_t>(cpu), &set)) {
    ++cpu;
  }
  return cpu;
}

// Of this process, in the order of their CPUs.
std::vector<IdleThread> IdleThreads() {
  std::vector<IdleThread> threads;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    const int id = std::stoi(task.path().filename());
    if (sched_getscheduler(id) == SCHED_IDLE) {
      threads.push_back({.id = id, .cpu = OnlyCpuOf(id)});
    }
  }
  std::sort(threads.begin(), threads.end(), [](auto& a, auto& b) { return a.cpu < b.cpu; });
  return threads;
}

// Time that a thread has had a CPU so far.
uint64_t RunNs(int thread) {
  uint64_t run_ns = 0;
  std::ifstream("/proc/self/task/" + std::to_string(thread) + "/schedstat") >> run_ns;
  return run_ns;
}

TEST(WakefulCpusTest, SpinsAtIdlePriorityOnEveryCpuOfTheProcessAndEnds) {
  ASSERT_THAT(IdleThreads(), IsEmpty());
  {
    const WakefulCpus awake({});
    EXPECT_EQ(awake.refusal(), "");
    cpu_set_t own;
    ASSERT_EQ(sched_getaffinity(0, sizeof(own), &own), 0);
    EXPECT_EQ(awake.cpus().size(), CPU_COUNT(&own));
    std::vector<int> cpus;
    for (const IdleThread& thread : IdleThreads()) {
      cpus.push_back(thread.cpu);
      const uint64_t before = RunNs(thread.id);
      while (RunNs(thread.id) < before + 1'000'000) {
        std::this_thread::yield();  // It spins: its time goes on, as fast as the host lets it.
      }
    }
    EXPECT_THAT(cpus, ElementsAreArray(awake.cpus()));
  }
  EXPECT_THAT(IdleThreads(), IsEmpty());
}

TEST(WakefulCpusTest, CountsACpuOfALoopOnce) {
  const WakefulCpus process({});
  const WakefulCpus awake({process.cpus().front(), process.cpus().front()});
  EXPECT_EQ(awake.cpus(), process.cpus());
}

TEST(WakefulCpusTest, KeepsNoneAwakeWhereOneIsRefusedAndSaysWhich) {
  const WakefulCpus awake({CPU_SETSIZE - 1});
  EXPECT_THAT(awake.refusal(), HasSubstr("CPU " + std::to_string(CPU_SETSIZE - 1)));
  EXPECT_THAT(awake.refusal(), HasSubstr("taskset"));
  EXPECT_THAT(awake.cpus(), IsEmpty());
}

}  // namespace
}  // namespace mwidth::render
