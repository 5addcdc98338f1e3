#include "server/doctor/checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/doctor/fake_host.h"

namespace mwidth::doctor {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using Check = Finding (*)(const HostFiles&, const Needs&);

class ChecksTest : public testing::Test {
 protected:
  ChecksTest() { MakeTuned(host); }

  // What `check` finds with its advice, which stands exactly where it is not in order.
  Finding Find(Check check) const {
    Finding finding = check(host.files(), needs);
    EXPECT_THAT(finding.subject, Not(IsEmpty()));
    EXPECT_THAT(finding.seen, Not(IsEmpty()));
    EXPECT_EQ(finding.verdict == Verdict::kOk, finding.advice.empty()) << finding.advice;
    return finding;
  }
  void Expect(Check check, Verdict verdict, const std::string& seen, const std::string& advice) const {
    const Finding finding = Find(check);
    EXPECT_EQ(finding.verdict, verdict) << finding.seen;
    EXPECT_THAT(finding.seen, HasSubstr(seen));
    EXPECT_THAT(finding.advice, HasSubstr(advice));
  }

  FakeHost host;
  Needs needs{.priority = 80, .cpus = {3}};
};

TEST_F(ChecksTest, HaveNothingToSayAgainstATunedHost) {
  for (const Check check :
       {CheckKernel, CheckPriority, CheckLockedMemory, CheckThrottling, CheckQuota, CheckIsolation,
        CheckInterrupts, CheckGovernor, CheckIdleStates, CheckVirtualCpus, CheckClockSource}) {
    const Finding finding = Find(check);
    EXPECT_EQ(finding.verdict, Verdict::kOk) << finding.subject << ": " << finding.seen;
  }
}

TEST_F(ChecksTest, TellKernelsApart) {
  host.Remove("sys/kernel/realtime");
  Expect(CheckKernel, Verdict::kOk, "PREEMPT_RT", "");
  host.Write("proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC");
  Expect(CheckKernel, Verdict::kWarning, "not PREEMPT_RT", "preempt=full");
  host.Write("proc/version", "Linux version 6.1.0 #1 SMP");
  Expect(CheckKernel, Verdict::kWarning, "not preemptible", "linux-image-rt");
}

TEST_F(ChecksTest, CompareThePriorityWithTheLimitAndTheCapability) {
  needs.priority = 98;
  host.Write("proc/self/limits", "Max realtime priority     97                   99                ");
  Expect(CheckPriority, Verdict::kProblem, "limit of 97", "rtprio 99");
  host.Write("proc/self/limits", "Max realtime priority     98                   99                ");
  Expect(CheckPriority, Verdict::kOk, "within the limit of 98", "");
  host.Remove("proc/self/limits");
  Expect(CheckPriority, Verdict::kProblem, "limit of 0", "LimitRTPRIO");
  host.Write("proc/self/status", "CapEff:\t0000000000800000");
  Expect(CheckPriority, Verdict::kOk, "CAP_SYS_NICE", "");
}

TEST_F(ChecksTest, WantMemoryWithoutALimit) {
  host.Write("proc/self/limits", "Max locked memory         8388608              unlimited            bytes");
  Expect(CheckLockedMemory, Verdict::kProblem, "8192 KiB", "memlock unlimited");
  host.Write("proc/self/status", "CapEff:\t0000000000004000");
  Expect(CheckLockedMemory, Verdict::kOk, "CAP_IPC_LOCK", "");
}

TEST_F(ChecksTest, JudgeThrottlingByTheShareThatIsLeftToTheLoops) {
  Expect(CheckThrottling, Verdict::kOk, "95 % of each CPU", "");
  host.Write("proc/sys/kernel/sched_rt_runtime_us", "500000");
  Expect(CheckThrottling, Verdict::kWarning, "50 %", "sched_rt_runtime_us=950000");
  host.Write("proc/sys/kernel/sched_rt_runtime_us", "0");
  Expect(CheckThrottling, Verdict::kProblem, "0 %", "sched_rt_runtime_us=950000");
  host.Write("proc/sys/kernel/sched_rt_runtime_us", "-1");
  Expect(CheckThrottling, Verdict::kOk, "off", "");
  host.Remove("proc/sys/kernel/sched_rt_period_us");
  Expect(CheckThrottling, Verdict::kOk, "no limit", "");
}

TEST_F(ChecksTest, WarnOfAQuotaAndMoreSoWhereTheCpusAreKeptAwake) {
  host.Write("sys/fs/cgroup/cpu.max", "max 100000");
  Expect(CheckQuota, Verdict::kOk, "none", "");
  host.Write("sys/fs/cgroup/cpu.max", "150000 100000");
  Expect(CheckQuota, Verdict::kWarning, "150000 100000", "cpuset");
  needs.keep_cpus_awake = true;
  Expect(CheckQuota, Verdict::kProblem, "uses it up", "cpuset");
}

TEST_F(ChecksTest, WantALoopAloneOnAnIsolatedCpu) {
  Expect(CheckIsolation, Verdict::kOk, "CPU 3 isolated, without", "");
  host.Write("sys/devices/system/cpu/nohz_full", "(null)");
  Expect(CheckIsolation, Verdict::kOk, "tick goes on", "");
  needs.cpus = {2, 3};
  Expect(CheckIsolation, Verdict::kWarning, "CPU 2 of a loop is open", "isolcpus=");
  needs.cpus = {3, 3};
  Expect(CheckIsolation, Verdict::kWarning, "share CPU 3", "of its own");
  needs.some_loop_unpinned = true;
  Expect(CheckIsolation, Verdict::kWarning, "not pinned", "axis.realtime");
  needs.cpus = {3, 4};
  Expect(CheckIsolation, Verdict::kProblem, "CPU 4, which is not online", "0-3");
}

TEST_F(ChecksTest, FindTheInterruptsThatMeetALoop) {
  Expect(CheckInterrupts, Verdict::kOk, "none on CPU 3", "");
  host.Write("proc/irq/24/effective_affinity_list", "3");
  Expect(CheckInterrupts, Verdict::kWarning, "1 may be served on CPU 3: 24 (eth0)", "irqbalance");
  host.Remove("proc/irq/24/effective_affinity_list");
  Expect(CheckInterrupts, Verdict::kWarning, "24 (eth0)", "smp_affinity_list");
  for (int number = 30; number < 40; ++number) {
    const std::string folder = "proc/irq/" + std::to_string(number);
    host.Write(folder + "/smp_affinity_list", "1-3");
    host.MakeFolder(folder + "/nvme");
  }
  Expect(CheckInterrupts, Verdict::kWarning, "11 may be served on CPU 3: 24 (eth0), 30 (nvme)", "irqbalance");
  needs.cpus.clear();
  Expect(CheckInterrupts, Verdict::kOk, "not looked at", "");
}

TEST_F(ChecksTest, WantFullSpeedOnTheCpusOfTheLoopsAlone) {
  host.Write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave");
  Expect(CheckGovernor, Verdict::kOk, "performance", "");
  needs.some_loop_unpinned = true;
  Expect(CheckGovernor, Verdict::kWarning, "CPU 0 powersave", "cpupower");
  for (const char* cpu : {"cpu0", "cpu1", "cpu2", "cpu3"}) {
    host.Remove(std::string("sys/devices/system/cpu/") + cpu + "/cpufreq");
  }
  Expect(CheckGovernor, Verdict::kOk, "does not change", "");
}

TEST_F(ChecksTest, WantIdleStatesThatTheServerCanHoldOff) {
  Expect(CheckIdleStates, Verdict::kOk, "133 us to wake from; the server holds", "");
  host.Remove("dev/cpu_dma_latency");
  Expect(CheckIdleStates, Verdict::kProblem, "may not write /dev/cpu_dma_latency", "udev");
  needs.allow_deep_idle = true;
  Expect(CheckIdleStates, Verdict::kWarning, "133 us", "allow_deep_idle");
  host.Write("sys/devices/system/cpu/cpu3/cpuidle/state1/disable", "1");
  Expect(CheckIdleStates, Verdict::kOk, "0 us", "");
}

TEST_F(ChecksTest, KnowAVirtualCpu) {
  host.Write("proc/cpuinfo", "flags\t\t: fpu vme hypervisor lahf_lm");
  Expect(CheckVirtualCpus, Verdict::kWarning, "hypervisor", "keep_cpus_awake = true");
  needs.keep_cpus_awake = true;
  Expect(CheckVirtualCpus, Verdict::kOk, "kept awake", "");
}

TEST_F(ChecksTest, WantAClockThatIsReadWithoutASystemCall) {
  host.Write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  Expect(CheckClockSource, Verdict::kWarning, "hpet", "dmesg");
  host.Remove("sys");
  Expect(CheckClockSource, Verdict::kWarning, "unknown", "dmesg");
}

}  // namespace
}  // namespace mwidth::doctor
