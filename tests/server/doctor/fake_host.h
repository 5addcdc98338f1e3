// A host made of files, in a folder that is gone when the test is over.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "server/doctor/host_files.h"
#include "tests/support/temporary_folder.h"

namespace mwidth::doctor {

class FakeHost {
 public:
  void Write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text << "\n";
  }
  void MakeFolder(const std::string& folder) const { std::filesystem::create_directories(root_ / folder); }
  void Remove(const std::string& file) const { std::filesystem::remove_all(root_ / file); }
  HostFiles files() const { return HostFiles(root_); }

 private:
  TemporaryFolder temporary_;
  std::filesystem::path root_ = temporary_.path();
};

/// Four CPUs, of which the last is a loop's alone; nothing to complain about.
inline void MakeTuned(const FakeHost& host) {
  host.Write("proc/version", "Linux version 6.1.0-rt-amd64 #1 SMP PREEMPT_RT Debian 6.1");
  host.Write("sys/kernel/realtime", "1");
  host.Write("proc/self/limits",
             "Limit                     Soft Limit           Hard Limit           Units     \n"
             "Max locked memory         unlimited            unlimited            bytes     \n"
             "Max realtime priority     99                   99                             \n"
             "Max realtime timeout      unlimited            unlimited            us        ");
  host.Write("proc/self/status", "Name:\tmwidthd\nCapEff:\t0000000000000000\nCapBnd:\t000001ffffffffff");
  host.Write("proc/sys/kernel/sched_rt_runtime_us", "950000");
  host.Write("proc/sys/kernel/sched_rt_period_us", "1000000");
  host.Write("proc/cpuinfo", "flags\t\t: fpu vme de pse tsc");
  host.Write("proc/irq/0/smp_affinity_list", "0-3");  // No device behind it.
  host.Write("proc/irq/24/smp_affinity_list", "0-3");
  host.Write("proc/irq/24/effective_affinity_list", "2");
  host.MakeFolder("proc/irq/24/eth0");
  host.Write("sys/devices/system/cpu/online", "0-3");
  host.Write("sys/devices/system/cpu/isolated", "3");
  host.Write("sys/devices/system/cpu/nohz_full", "3");
  for (const char* cpu : {"cpu0", "cpu1", "cpu2", "cpu3"}) {
    const std::string folder = std::string("sys/devices/system/cpu/") + cpu;
    host.Write(folder + "/cpufreq/scaling_governor", "performance");
    host.Write(folder + "/cpuidle/state0/latency", "0");
    host.Write(folder + "/cpuidle/state1/latency", "133");
  }
  host.Write("dev/cpu_dma_latency", "");
  host.Write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
}

}  // namespace mwidth::doctor
