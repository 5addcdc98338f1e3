#include "device/canopen/node_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace mwidth::device::canopen {
namespace {

constexpr uint8_t kNode = 5;
constexpr uint8_t kOwnNode = 127;

class NodeWatchTest : public ::testing::Test {
 protected:
  NodeWatchTest() { watch.Begin(10); }
  Heard Hear(uint16_t identifier, const std::vector<uint8_t>& bytes, int64_t now_ns = 20) {
    can::Frame frame{.identifier = identifier, .size = static_cast<uint8_t>(bytes.size())};
    std::copy(bytes.begin(), bytes.end(), frame.bytes.begin());
    return watch.Hear(frame, now_ns);
  }

  NodeWatch watch{kNode, kOwnNode};
};

TEST_F(NodeWatchTest, TakesAPosition) {
  EXPECT_EQ(Hear(0x185, {0x37, 0x12, 0xFE, 0xFF, 0xFF, 0xFF, 0x18, 0xFC}), Heard::kFeedback);
  EXPECT_EQ(watch.feedback().statusword, 0x1237);
  EXPECT_EQ(watch.feedback().position, -2);
  EXPECT_EQ(watch.feedback().torque_per_mille, -1000);
}

TEST_F(NodeWatchTest, APositionOfAnotherLengthLeavesTheOldOne) {
  Hear(0x185, {0x37, 0x12, 1, 0, 0, 0, 0, 0});
  EXPECT_EQ(Hear(0x185, {0, 0, 9, 0, 0, 0, 0}), Heard::kNoted);
  EXPECT_EQ(watch.feedback().position, 1);
  EXPECT_EQ(watch.counters.malformed, 1);
}

TEST_F(NodeWatchTest, RemembersTheNewestEmergencyUntilItIsOver) {
  Hear(0x085, {0x10, 0x23, 0x02, 0, 0, 0, 0, 0});
  EXPECT_EQ(watch.emergency_code(), 0x2310);
  Hear(0x085, {0x00, 0x00, 0x00, 0, 0, 0, 0, 0});
  EXPECT_EQ(watch.emergency_code(), 0);
  EXPECT_EQ(watch.counters.emergencies, 2);
}

TEST_F(NodeWatchTest, ADriveThatIsNotOperationalAnyMoreIsNotUntilItIsSetUp) {
  Hear(0x705, {0x05}, 30);
  EXPECT_TRUE(watch.operational());
  EXPECT_EQ(watch.heartbeat_ns(), 30);
  for (const NmtState state : {NmtState::kBootUp, NmtState::kStopped, NmtState::kPreOperational}) {
    watch.Begin(40);
    EXPECT_TRUE(watch.operational());
    Hear(0x705, {static_cast<uint8_t>(state)}, 50);
    EXPECT_FALSE(watch.operational());
    Hear(0x705, {0x05}, 60);
    EXPECT_FALSE(watch.operational());
  }
}

TEST_F(NodeWatchTest, KnowsWhatOnlyWeMaySend) {
  const std::pair<uint16_t, std::vector<uint8_t>> foreign[] = {{0x080, {}},
                                                               {0x080, {1}},
                                                               {0x205, {0x0F, 0, 0, 0}},
                                                               {0x605, {0x40, 0, 0x10, 0, 0, 0, 0, 0}},
                                                               {0x77F, {0x05}},
                                                               {0x000, {0x02, kNode}},
                                                               {0x000, {0x81, 0}}};
  uint64_t count = 0;
  for (const auto& [identifier, bytes] : foreign) {
    EXPECT_EQ(Hear(identifier, bytes, 70), Heard::kNoted);
    EXPECT_EQ(watch.counters.foreign, ++count);
    EXPECT_EQ(watch.foreign_ns(), 70);
    EXPECT_EQ(watch.foreign_identifier(), identifier);
  }
  watch.Begin(80);
  EXPECT_FALSE(watch.foreign_ns().has_value());
}

TEST_F(NodeWatchTest, EverybodyElseIsWelcome) {
  for (const uint16_t identifier :
       std::initializer_list<uint16_t>{0x081, 0x186, 0x206, 0x606, 0x706, 0x100, 0x7E5}) {
    EXPECT_EQ(Hear(identifier, {0, 0, 0, 0, 0, 0, 0, 0}), Heard::kNoted);
  }
  Hear(0x000, {0x01, kNode + 1});
  for (const uint16_t identifier : std::initializer_list<uint16_t>{0x080, 0x205, 0x77F, 0x185, 0x705}) {
    EXPECT_EQ(watch.Hear({.identifier = identifier, .remote = true, .size = 8}, 90), Heard::kNoted);
  }
  EXPECT_EQ(watch.counters.foreign, 0);
  EXPECT_EQ(watch.counters.malformed, 0);
  EXPECT_TRUE(watch.operational());
  EXPECT_EQ(watch.heartbeat_ns(), 10);
}

TEST_F(NodeWatchTest, HandsOnWholeSdoAnswers) {
  EXPECT_EQ(Hear(0x585, {0x60, 0x40, 0x60, 0, 0, 0, 0, 0}), Heard::kSdoAnswer);
  EXPECT_EQ(Hear(0x585, {0x60, 0x40, 0x60, 0}), Heard::kNoted);
}

}  // namespace
}  // namespace mwidth::device::canopen
