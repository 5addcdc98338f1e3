#include "device/emulator/object_dictionary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace mwidth::device::emulator {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

class ObjectDictionaryTest : public ::testing::Test {
 protected:
  ObjectDictionaryTest() {
    objects.Add({0x2000, 0}, {.bytes = 4, .initial = 0x0102'0304});
    objects.Add({0x2001, 2}, {.bytes = 2,
                              .is_signed = true,
                              .access = Access::kReadWrite,
                              .initial = -2,
                              .min = -5,
                              .max = 5,
                              .write = [this](int64_t value) {
                                told.push_back(value);
                                return value == 3 ? SdoAbort::kInvalidValue : SdoAbort::kNone;
                              }});
    objects.Add({0x2002, 0}, {.bytes = 1, .read = [] { return 77; }});
  }
  Bytes Read(ObjectId id) {
    Bytes bytes;
    EXPECT_EQ(objects.Read(id, bytes), SdoAbort::kNone);
    return bytes;
  }
  SdoAbort Write(int64_t value) { return objects.Write({0x2001, 2}, ToBytes(value, 2)); }

  ObjectDictionary objects;
  std::vector<int64_t> told;
};

TEST_F(ObjectDictionaryTest, TellsValuesLeastSignificantByteFirst) {
  EXPECT_THAT(Read({0x2000, 0}), ElementsAre(4, 3, 2, 1));
  EXPECT_THAT(Read({0x2001, 2}), ElementsAre(0xFE, 0xFF));
  EXPECT_THAT(Read({0x2002, 0}), ElementsAre(77));
}

TEST_F(ObjectDictionaryTest, TakesWhatIsInRange) {
  EXPECT_EQ(Write(-5), SdoAbort::kNone);
  EXPECT_EQ(objects.Get({0x2001, 2}), -5);
  EXPECT_EQ(Write(5), SdoAbort::kNone);
  EXPECT_THAT(told, ElementsAre(-5, 5));
}

TEST_F(ObjectDictionaryTest, SaysWhyItRefuses) {
  Bytes bytes;
  EXPECT_EQ(objects.Read({0x3000, 0}, bytes), SdoAbort::kNoObject);
  EXPECT_EQ(objects.Read({0x2001, 1}, bytes), SdoAbort::kNoSubindex);
  EXPECT_EQ(objects.Read({0x2001, 3}, bytes), SdoAbort::kNoSubindex);
  EXPECT_EQ(objects.Write({0x2000, 0}, ToBytes(1, 4)), SdoAbort::kReadOnly);
  EXPECT_EQ(objects.Write({0x2001, 2}, ToBytes(1, 4)), SdoAbort::kTooLong);
  EXPECT_EQ(objects.Write({0x2001, 2}, ToBytes(1, 1)), SdoAbort::kTooShort);
  EXPECT_EQ(Write(6), SdoAbort::kTooHigh);
  EXPECT_EQ(Write(-6), SdoAbort::kTooLow);
  EXPECT_EQ(Write(3), SdoAbort::kInvalidValue);
  EXPECT_EQ(objects.Get({0x2001, 2}), -2);
}

TEST_F(ObjectDictionaryTest, ForgetsOnAResetWhatLiesInIt) {
  EXPECT_EQ(Write(4), SdoAbort::kNone);
  objects.Reset(0x1000, 0x2000);
  EXPECT_EQ(objects.Get({0x2001, 2}), 4);
  objects.Reset(0x2001, 0x2001);
  EXPECT_EQ(objects.Get({0x2001, 2}), -2);
}

TEST_F(ObjectDictionaryTest, KnowsNoValueOfWhatDoesNotExist) {
  EXPECT_EQ(objects.Find({0x2001, 1}), nullptr);
  EXPECT_THROW(objects.Get({0x2001, 1}), std::out_of_range);
}

TEST(Bytes, AreNumbersWithOrWithoutASign) {
  EXPECT_EQ(FromBytes(Bytes{0xFE, 0xFF}, true), -2);
  EXPECT_EQ(FromBytes(Bytes{0xFE, 0xFF}, false), 0xFFFE);
  EXPECT_EQ(FromBytes(Bytes{0, 0, 0, 0x80}, true), INT32_MIN);
  EXPECT_EQ(FromBytes(ToBytes(-123'456, 4), true), -123'456);
}

}  // namespace
}  // namespace mwidth::device::emulator
