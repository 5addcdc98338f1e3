#include "server/rpc/background.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <optional>
#include <thread>

namespace mwidth::rpc {
namespace {

int Policy() {
  int policy = -1;
  sched_param parameters{};
  EXPECT_EQ(pthread_getschedparam(pthread_self(), &policy, &parameters), 0);
  return policy;
}

TEST(LowerPriority, LetsEveryOtherThreadGoFirst) {
  const int before = Policy();
  int lowered = -1;
  std::thread([&lowered] {
    LowerPriority();
    lowered = Policy();
  }).join();
  EXPECT_EQ(lowered, SCHED_IDLE);
  EXPECT_EQ(Policy(), before);
}

TEST(ComputationLimit, GivesSoManyPlacesAndTakesThemBack) {
  ComputationLimit limit(2);
  std::optional<ComputationLimit::Place> first(std::in_place, limit);
  const ComputationLimit::Place second(limit);
  EXPECT_TRUE(first->taken());
  EXPECT_TRUE(second.taken());
  {
    const ComputationLimit::Place third(limit);
    EXPECT_FALSE(third.taken());
  }
  // A place that was not had is not given back.
  EXPECT_FALSE(ComputationLimit::Place(limit).taken());
  first.reset();
  EXPECT_TRUE(ComputationLimit::Place(limit).taken());
}

}  // namespace
}  // namespace mwidth::rpc
