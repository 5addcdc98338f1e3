// Threads that keep CPUs from halting, for hosts on which a halted CPU wakes slowly.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace mwidth::render {

/// One thread for each CPU that this process may use, pinned to it, that spins at SCHED_IDLE as long as the
/// object lives. A virtual CPU that halts is taken away by the hypervisor and comes back late; one that spins
/// stays. Every other thread goes before these: a real-time one at once, an ordinary one within its usual
/// time, at 0.3 % of its share. They cost all the power of the CPUs, what a hyper-thread's sibling would gain
/// from its rest, and, under a CPU quota of a container, the quota. Not Rt.
class WakefulCpus {
 public:
  /// `further_cpus`: CPUs outside of the process's affinity that its loops are pinned to, such as isolated
  /// ones. All CPUs are kept awake, or none.
  explicit WakefulCpus(const std::vector<int>& further_cpus);
  WakefulCpus(const WakefulCpus&) = delete;
  WakefulCpus& operator=(const WakefulCpus&) = delete;
  ~WakefulCpus();

  /// Empty where the CPUs are kept awake; else the reason, and what to do about it.
  const std::string& refusal() const noexcept { return refusal_; }
  /// Those that are kept awake, in rising order.
  const std::vector<int>& cpus() const noexcept { return cpus_; }

 private:
  enum class Order : uint8_t { kWait, kSpin, kEnd };

  void StartOn(int cpu);
  void Tell(Order order) noexcept;
  void Run() const noexcept;

  std::atomic<Order> order_{Order::kWait};
  std::vector<int> cpus_;
  std::string refusal_;
  std::vector<std::thread> threads_;
};

}  // namespace mwidth::render
