#include "server/render/wakeful_cpus.h"

#include <pthread.h>
#include <sched.h>

#include <system_error>

#include "server/exchange/cpu_pause.h"

namespace mwidth::render {
namespace {

// Of this process's affinity, and the further ones. A CPU that does not exist stays in, to be refused.
std::vector<int> Union(const std::vector<int>& further_cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof(set), &set);
  for (const int cpu : further_cpus) {
    if (cpu >= 0 && cpu < CPU_SETSIZE) {
      CPU_SET(static_cast<std::size_t>(cpu), &set);
    }
  }
  std::vector<int> cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) {
      cpus.push_back(cpu);
    }
  }
  return cpus;
}

int PinTo(int cpu, pthread_t thread) {
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(static_cast<std::size_t>(cpu), &only);
  return pthread_setaffinity_np(thread, sizeof(only), &only);
}

int LowerToIdle(pthread_t thread) {
  const sched_param parameters{.sched_priority = 0};
  return pthread_setschedparam(thread, SCHED_IDLE, &parameters);
}

}  // namespace

WakefulCpus::WakefulCpus(const std::vector<int>& further_cpus) : cpus_(Union(further_cpus)) {
  for (const int cpu : cpus_) {
    if (refusal_.empty()) {
      StartOn(cpu);
    }
  }
  if (!refusal_.empty()) {
    cpus_.clear();
  }
  Tell(refusal_.empty() ? Order::kSpin : Order::kEnd);
}

WakefulCpus::~WakefulCpus() {
  Tell(Order::kEnd);
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

// The thread waits: one that spun at an ordinary priority, or on another CPU, would do harm.
void WakefulCpus::StartOn(int cpu) {
  threads_.emplace_back([this] { Run(); });
  const pthread_t thread = threads_.back().native_handle();
  int error = PinTo(cpu, thread);
  if (error == 0) {
    error = LowerToIdle(thread);
  }
  if (error != 0) {
    refusal_ = "CPU " + std::to_string(cpu) +
               " is not kept awake: " + std::generic_category().message(error) +
               "; let this process use it (taskset, the container's --cpuset-cpus, AllowedCPUs= in the "
               "service unit), or set keep_cpus_awake = false";
  }
}

void WakefulCpus::Tell(Order order) noexcept {
  order_.store(order, std::memory_order_relaxed);
  order_.notify_all();
}

void WakefulCpus::Run() const noexcept {
  order_.wait(Order::kWait, std::memory_order_relaxed);
  while (order_.load(std::memory_order_relaxed) == Order::kSpin) {
    exchange::PauseCpu();
  }
}

}  // namespace mwidth::render
