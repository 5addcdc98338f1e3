#include "device/canopen/process_data.h"

#include <gtest/gtest.h>

#include "tests/device/canopen/fake_node.h"

namespace mwidth::device::canopen {
namespace {

using testing::FakeBus;
using testing::FakeNode;
using testing::FakeNow;
using testing::kNode;
using testing::kOwnNode;
using testing::kTickNs;
using testing::TestConfig;

constexpr int64_t kReplyNs = 400'000;

class ProcessDataTest : public ::testing::Test {
 protected:
  ProcessDataTest() {
    FakeBus::lost = false;
    node->nmt = NmtState::kOperational;
    node->Set(kRpdo1Type, kEventDriven);
    data.Begin();
  }
  /// An exchange in the next tick; how long it took.
  int64_t Exchange() {
    testing::fake_now_ns += kTickNs;
    const int64_t begin_ns = FakeNow();
    joined = data.Exchange();
    return FakeNow() - begin_ns;
  }
  can::Frame Feedback(uint8_t position) const {
    return {.identifier = kTpdo1 + kNode, .size = 8, .bytes = {0x37, 0x12, position}};
  }

  CanopenDriveConfig config = TestConfig();
  std::shared_ptr<FakeNode> node = std::make_shared<FakeNode>();
  FakeBus bus{node};
  ProcessData data{bus, config, FakeNow};
  bool joined = false;
};

TEST_F(ProcessDataTest, EndsWithTheAnswerAndAtTheLatestWithTheDeadline) {
  node->position = 42;
  EXPECT_EQ(Exchange(), node->answer_delay_ns);
  EXPECT_TRUE(joined && data.answered());
  EXPECT_EQ(data.watch().feedback().position, 42);
  node->answers_sync = false;
  EXPECT_EQ(Exchange(), kReplyNs);
  EXPECT_TRUE(joined);
  EXPECT_FALSE(data.answered());
  EXPECT_EQ(data.silent_ticks(), 1);
}

TEST_F(ProcessDataTest, SendsItsHeartbeatFirst) {
  Exchange();
  ASSERT_EQ(node->heard.size(), 2U);
  EXPECT_EQ(node->heard[0], HeartbeatFrame(kOwnNode, NmtState::kOperational));
  EXPECT_EQ(node->heard[1], SyncFrame());
  Exchange();
  EXPECT_EQ(node->heard.size(), 3U);
}

TEST_F(ProcessDataTest, WhatIsMissingIsListenedForInTwoTicksThatAskNothing) {
  Exchange();
  node->answers_sync = false;
  Exchange();
  node->answers_sync = true;
  node->heard.clear();
  for (const uint64_t silent : {2, 3}) {
    EXPECT_EQ(Exchange(), kReplyNs);
    EXPECT_TRUE(node->heard.empty());
    EXPECT_EQ(data.silent_ticks(), silent);
  }
  Exchange();
  EXPECT_TRUE(data.answered());
  EXPECT_EQ(data.silent_ticks(), 0);
}

TEST_F(ProcessDataTest, ALateAnswerIsCountedAndTheTickAsksAnew) {
  node->answers_sync = false;
  Exchange();
  node->Say(Feedback(7), kTickNs + 100'000);
  node->answers_sync = true;
  node->position = 9;
  Exchange();
  EXPECT_TRUE(data.answered());
  EXPECT_EQ(data.watch().feedback().position, 9);
  EXPECT_EQ(data.watch().counters.late_positions, 1);
}

TEST_F(ProcessDataTest, AnAnswerThatComesTwiceIsUsedOnce) {
  Exchange();
  node->Say(Feedback(7));
  node->position = 9;
  Exchange();
  EXPECT_EQ(data.watch().feedback().position, 9);
  EXPECT_EQ(data.watch().counters.late_positions, 1);
}

TEST_F(ProcessDataTest, AFloodEndsWithTheDeadline) {
  node->answers_sync = false;
  constexpr int kFrames = 20'000;
  for (int i = 0; i < kFrames; ++i) {
    node->Say({.identifier = 0x123, .size = 8}, kTickNs + i * 1'000);
  }
  EXPECT_LE(Exchange(), kReplyNs + 1'000);
  EXPECT_TRUE(joined);
  EXPECT_GT(node->said.size(), kFrames / 2);
}

TEST_F(ProcessDataTest, AnSdoAnswerIsKeptOnce) {
  const can::Frame answer{.identifier = kSdoReply + kNode, .size = 8, .bytes = {0x60}};
  node->Say(answer);
  Exchange();
  EXPECT_EQ(data.TakeSdoAnswer(), answer);
  EXPECT_FALSE(data.TakeSdoAnswer());
}

TEST_F(ProcessDataTest, ALostBusIsToldAndBringsNoPosition) {
  Exchange();
  FakeBus::lost = true;
  Exchange();
  EXPECT_FALSE(joined);
  EXPECT_FALSE(data.answered());
  EXPECT_FALSE(data.Command(kEnableOperation, 1));
}

}  // namespace
}  // namespace mwidth::device::canopen
