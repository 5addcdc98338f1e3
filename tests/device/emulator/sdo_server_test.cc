#include "device/emulator/sdo_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

namespace mwidth::device::emulator {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

class SdoServerTest : public ::testing::Test {
 protected:
  SdoServerTest() {
    objects.Add({0x6041, 0}, {.bytes = 2, .initial = 0x1237});
    objects.Add({0x1016, 1}, {.bytes = 4, .access = Access::kReadWrite});
    objects.Add({0x6060, 0}, {.bytes = 1, .is_signed = true, .access = Access::kReadWrite});
  }
  Bytes Ask(const Bytes& request) { return AnswerSdo(request, objects, false).value_or(Bytes{}); }

  ObjectDictionary objects;
};

// The bytes are those of CiA 301, sections 7.2.4.3.3 to 7.2.4.3.6.
TEST_F(SdoServerTest, Uploads) {
  EXPECT_THAT(Ask({0x40, 0x41, 0x60, 0, 0, 0, 0, 0}), ElementsAre(0x4B, 0x41, 0x60, 0, 0x37, 0x12, 0, 0));
  EXPECT_THAT(Ask({0x40, 0x60, 0x60, 0, 0, 0, 0, 0}), ElementsAre(0x4F, 0x60, 0x60, 0, 0, 0, 0, 0));
  EXPECT_THAT(Ask({0x40, 0x16, 0x10, 1, 0, 0, 0, 0}), ElementsAre(0x43, 0x16, 0x10, 1, 0, 0, 0, 0));
}

TEST_F(SdoServerTest, Downloads) {
  EXPECT_THAT(Ask({0x23, 0x16, 0x10, 1, 50, 0, 0x7F, 0}), ElementsAre(0x60, 0x16, 0x10, 1, 0, 0, 0, 0));
  EXPECT_EQ(objects.Get({0x1016, 1}), 0x7F'0032);
  EXPECT_THAT(Ask({0x2F, 0x60, 0x60, 0, 10, 0, 0, 0}), ElementsAre(0x60, 0x60, 0x60, 0, 0, 0, 0, 0));
  // Without a size: the object's.
  EXPECT_THAT(Ask({0x22, 0x60, 0x60, 0, 9, 0, 0, 0}), ElementsAre(0x60, 0x60, 0x60, 0, 0, 0, 0, 0));
  EXPECT_EQ(objects.Get({0x6060, 0}), 9);
}

TEST_F(SdoServerTest, AbortsWithTheReason) {
  EXPECT_THAT(Ask({0x40, 0x00, 0x20, 0, 0, 0, 0, 0}), ElementsAre(0x80, 0, 0x20, 0, 0, 0, 0x02, 0x06));
  EXPECT_THAT(Ask({0x2B, 0x41, 0x60, 0, 1, 0, 0, 0}), ElementsAre(0x80, 0x41, 0x60, 0, 0x02, 0, 0x01, 0x06));
  EXPECT_THAT(Ask({0x2B, 0x60, 0x60, 0, 1, 0, 0, 0}), ElementsAre(0x80, 0x60, 0x60, 0, 0x12, 0, 0x07, 0x06));
}

TEST_F(SdoServerTest, KnowsNoTransfersInSegmentsOrBlocks) {
  for (const uint8_t command : Bytes{0x00, 0x20, 0x21, 0x60, 0xA0, 0xC0, 0xE0}) {
    EXPECT_THAT(Ask({command, 0x60, 0x60, 0, 1, 0, 0, 0}),
                ElementsAre(0x80, 0x60, 0x60, 0, 0x01, 0, 0x04, 0x05));
  }
}

TEST_F(SdoServerTest, SaysNothingToAbortsAndToWhatIsNoSdo) {
  EXPECT_TRUE(Ask({0x80, 0x60, 0x60, 0, 0, 0, 0, 0}).empty());
  EXPECT_TRUE(Ask({0x40, 0x41, 0x60}).empty());
  EXPECT_TRUE(Ask({}).empty());
}

TEST_F(SdoServerTest, AbortsEverythingWhereItIsBroken) {
  EXPECT_EQ(AnswerSdo(Bytes{0x40, 0x41, 0x60, 0, 0, 0, 0, 0}, objects, true),
            (Bytes{0x80, 0x41, 0x60, 0, 0, 0, 0, 0x08}));
}

TEST_F(SdoServerTest, SurvivesAnyBytes) {
  std::mt19937 random(5);
  for (int i = 0; i < 200'000; ++i) {
    Bytes request(random() % 10);
    for (uint8_t& byte : request) {
      byte = static_cast<uint8_t>(random());
    }
    const auto answer = AnswerSdo(request, objects, false);
    EXPECT_EQ(answer.value_or(Bytes(8)).size(), 8U);
  }
}

}  // namespace
}  // namespace mwidth::device::emulator
