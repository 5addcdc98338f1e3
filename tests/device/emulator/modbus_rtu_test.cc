#include "device/emulator/modbus_rtu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace mwidth::device::emulator {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

TEST(RtuChecksum, IsTheOneThatTheCatalogueOfChecksumsLists) {
  // CRC-16/MODBUS: its check value is that of the digits 1 to 9.
  const std::string_view digits = "123456789";
  EXPECT_EQ(RtuChecksum(Bytes(digits.begin(), digits.end())), 0x4B37);
  EXPECT_EQ(RtuChecksum(Bytes{}), 0xFFFF);
}

TEST(RtuFrame, EndsWithItsChecksumLowByteFirst) {
  // The specification's example, section 2.5.1.2: 1241h is sent as 41h 12h.
  const Bytes frame = RtuFrame(2, Bytes{7});
  EXPECT_THAT(frame, ElementsAre(2, 7, 0x41, 0x12));
  EXPECT_TRUE(IsWholeRtuFrame(frame));
}

TEST(RtuFrame, IsNoLongerOneWithAnyBitWrong) {
  const Bytes frame = RtuFrame(1, Bytes{3, 0, 100, 0, 2});
  for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
    Bytes wrong = frame;
    wrong[bit / 8] = static_cast<uint8_t>(wrong[bit / 8] ^ 1 << bit % 8);
    EXPECT_FALSE(IsWholeRtuFrame(wrong)) << bit;
  }
  for (std::size_t size = 0; size < frame.size(); ++size) {
    EXPECT_FALSE(IsWholeRtuFrame(std::span(frame).first(size))) << size;
  }
}

TEST(RtuRequestBytes, IsWhatTheFunctionSays) {
  for (uint8_t function = 1; function <= 6; ++function) {
    EXPECT_EQ(RtuRequestBytes(Bytes{1, function}), 8U);
  }
  EXPECT_EQ(RtuRequestBytes(Bytes{1, 16, 0, 200, 0, 2, 4}), 13U);
  EXPECT_EQ(RtuRequestBytes(Bytes{1, 23, 0, 100, 0, 2, 0, 200, 0, 1, 2}), 15U);
}

TEST(RtuRequestBytes, IsUnknownBeforeTheCountHasCome) {
  EXPECT_EQ(RtuRequestBytes(Bytes{}), std::nullopt);
  EXPECT_EQ(RtuRequestBytes(Bytes{1}), std::nullopt);
  EXPECT_EQ(RtuRequestBytes(Bytes{1, 16, 0, 200, 0, 2}), std::nullopt);
  EXPECT_EQ(RtuRequestBytes(Bytes{1, 23, 0, 100, 0, 2, 0, 200, 0, 1}), std::nullopt);
}

TEST(RtuRequestBytes, IsUnknownForFunctionsThatNobodyKnows) {
  EXPECT_EQ(RtuRequestBytes(Bytes{1, 43, 14, 1, 0, 0, 0, 0}), std::nullopt);
}

}  // namespace
}  // namespace mwidth::device::emulator
