#include "server/render/realtime.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <thread>

namespace mwidth::render {
namespace {

using testing::HasSubstr;
using testing::Not;

// On a thread of its own, so that the test's own thread keeps its scheduling and its rights.
template <typename Function>
void OnAThread(Function function) {
  std::thread(function).join();
  munlockall();
}

// Capabilities are each thread's own.
void DropAllCapabilities() {
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  ASSERT_EQ(syscall(SYS_capset, &header, none.data()), 0);
}

// Sets the soft limit of the process to zero for the length of a test.
class NoAllowance {
 public:
  explicit NoAllowance(__rlimit_resource resource) : resource_(resource) {
    getrlimit(resource_, &before_);
    const rlimit none{.rlim_cur = 0, .rlim_max = before_.rlim_max};
    setrlimit(resource_, &none);
  }
  NoAllowance(const NoAllowance&) = delete;
  NoAllowance& operator=(const NoAllowance&) = delete;
  ~NoAllowance() { setrlimit(resource_, &before_); }

 private:
  __rlimit_resource resource_;
  rlimit before_{};
};

TEST(RealtimeTest, SaysWhatWasRefusedAndHowToGetIt) {
  const NoAllowance no_priority(RLIMIT_RTPRIO);
  const NoAllowance no_memory(RLIMIT_MEMLOCK);
  OnAThread([] {
    DropAllCapabilities();
    const RealtimeReport report = EnterRealtime({.priority = 80, .cpu = -1});
    EXPECT_FALSE(report.realtime);
    EXPECT_THAT(report.message, HasSubstr("SCHED_FIFO, priority 80"));
    EXPECT_THAT(report.message, HasSubstr("rtprio"));
    EXPECT_THAT(report.message, HasSubstr("CAP_SYS_NICE"));
    EXPECT_THAT(report.message, HasSubstr("RLIMIT_MEMLOCK"));
    EXPECT_THAT(report.message, HasSubstr("memlock unlimited"));
    int policy = -1;
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    EXPECT_EQ(policy, SCHED_OTHER);
  });
}

TEST(RealtimeTest, SaysWhichCpuItCannotHave) {
  OnAThread([] {
    const RealtimeReport report = EnterRealtime({.priority = 0, .cpu = 1'000'000});
    EXPECT_FALSE(report.realtime);
    EXPECT_THAT(report.message, HasSubstr("CPU 1000000"));
    EXPECT_THAT(report.message, HasSubstr("taskset"));
  });
}

TEST(RealtimeTest, PinsTheThreadToItsCpu) {
  OnAThread([] {
    cpu_set_t allowed;
    ASSERT_EQ(pthread_getaffinity_np(pthread_self(), sizeof(allowed), &allowed), 0);
    int last = -1;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      last = CPU_ISSET(static_cast<std::size_t>(cpu), &allowed) ? cpu : last;
    }
    const RealtimeReport report = EnterRealtime({.priority = 0, .cpu = last});
    EXPECT_THAT(report.message, Not(HasSubstr("CPU")));
    cpu_set_t pinned;
    ASSERT_EQ(pthread_getaffinity_np(pthread_self(), sizeof(pinned), &pinned), 0);
    EXPECT_EQ(CPU_COUNT(&pinned), 1);
    EXPECT_TRUE(CPU_ISSET(static_cast<std::size_t>(last), &pinned));
  });
}

TEST(RealtimeTest, AddsEveryFurtherRefusalAndNoneThatIsEmpty) {
  RealtimeReport report{.realtime = true, .message = "granted"};
  AddRefusal("", report);
  EXPECT_TRUE(report.realtime);
  EXPECT_EQ(report.message, "granted");
  AddRefusal("one", report);
  AddRefusal("two", report);
  EXPECT_FALSE(report.realtime);
  EXPECT_EQ(report.message, "one; two");
}

TEST(RealtimeTest, DoesNotCallAnUnaskedForPriorityRealTime) {
  OnAThread([] {
    const RealtimeReport report = EnterRealtime({.priority = 0, .cpu = -1});
    EXPECT_FALSE(report.realtime);
    EXPECT_THAT(report.message, HasSubstr("not asked for"));
  });
}

TEST(RealtimeTest, ReportsRealTimeExactlyWhereTheSchedulerGrantedIt) {
  OnAThread([] {
    const RealtimeReport report = EnterRealtime({.priority = 1, .cpu = -1});
    int policy = -1;
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    if (report.realtime) {
      EXPECT_EQ(policy, SCHED_FIFO);
      EXPECT_EQ(parameters.sched_priority, 1);
      EXPECT_EQ(report.message, "SCHED_FIFO priority 1, memory locked");
    } else {
      EXPECT_TRUE(policy == SCHED_OTHER || report.message.find("memory is not locked") != std::string::npos)
          << report.message;
    }
  });
}

}  // namespace
}  // namespace mwidth::render
