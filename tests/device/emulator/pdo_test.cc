#include "device/emulator/pdo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>

namespace mwidth::device::emulator {
namespace {

using ::testing::ElementsAre;

class PdoTest : public ::testing::Test {
 protected:
  static void AddProfile(ObjectDictionary& objects) {
    objects.Add({0x6040, 0}, {.bytes = 2, .access = Access::kReadWrite, .mappable = true});
    objects.Add({0x6041, 0}, {.bytes = 2, .mappable = true, .initial = 0x1237});
    objects.Add({0x6064, 0}, {.is_signed = true, .mappable = true, .initial = 0x0403'0201});
    objects.Add({0x6071, 0}, {.bytes = 2, .is_signed = true, .access = Access::kReadWrite, .mappable = true});
    objects.Add({0x6076, 0}, {.initial = 250});
  }
  PdoTest() { AddProfile(objects); }

  SdoAbort Put(uint16_t index, uint8_t subindex, int64_t value, std::size_t bytes) {
    return objects.Write({index, subindex}, ToBytes(value, bytes));
  }
  // Maps statusword and position to the transmit PDO.
  void MapTransmit() {
    EXPECT_EQ(Put(0x1800, 1, 0x8000'0185, 4), SdoAbort::kNone);
    EXPECT_EQ(Put(0x1A00, 0, 0, 1), SdoAbort::kNone);
    EXPECT_EQ(Put(0x1A00, 1, 0x6041'0010, 4), SdoAbort::kNone);
    EXPECT_EQ(Put(0x1A00, 2, 0x6064'0020, 4), SdoAbort::kNone);
    EXPECT_EQ(Put(0x1A00, 0, 2, 1), SdoAbort::kNone);
    EXPECT_EQ(Put(0x1800, 1, 0x185, 4), SdoAbort::kNone);
  }

  ObjectDictionary objects;
  Pdo rpdo{objects,
           {.direction = PdoDirection::kReceive,
            .index = 0x1400,
            .identifier = 0x205,
            .type = 255,
            .mapping = {0x6040'0010}}};
  Pdo tpdo{
      objects,
      {.direction = PdoDirection::kTransmit, .index = 0x1800, .identifier = 0x185, .mapping = {0x6041'0010}}};
};

TEST_F(PdoTest, IsWhatItIsAtPowerOn) {
  EXPECT_TRUE(tpdo.valid());
  EXPECT_EQ(tpdo.identifier(), 0x185);
  EXPECT_TRUE(tpdo.synchronous());
  EXPECT_FALSE(rpdo.synchronous());
  EXPECT_EQ(tpdo.Pack(false), (can::Frame{.identifier = 0x185, .size = 2, .bytes = {0x37, 0x12}}));
}

TEST_F(PdoTest, CarriesWhatIsMapped) {
  MapTransmit();
  EXPECT_EQ(tpdo.Pack(false),
            (can::Frame{.identifier = 0x185, .size = 6, .bytes = {0x37, 0x12, 1, 2, 3, 4}}));
  EXPECT_EQ(tpdo.Pack(true), (can::Frame{.identifier = 0x185, .size = 6, .bytes = {0x37, 0x12, 3, 4, 1, 2}}));
}

TEST_F(PdoTest, WritesWhatItBrings) {
  EXPECT_EQ(Put(0x1400, 1, 0x8000'0205, 4), SdoAbort::kNone);
  EXPECT_FALSE(rpdo.valid());
  EXPECT_EQ(Put(0x1600, 0, 0, 1), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1600, 2, 0x6071'0010, 4), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1600, 0, 2, 1), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1400, 1, 0x205, 4), SdoAbort::kNone);
  EXPECT_TRUE(rpdo.Unpack({.identifier = 0x205, .size = 4, .bytes = {15, 0, 0xFE, 0xFF}}));
  EXPECT_EQ(objects.Get({0x6040, 0}), 15);
  EXPECT_EQ(objects.Get({0x6071, 0}), -2);
  // Too short a frame brings nothing at all; a longer one brings no more.
  EXPECT_FALSE(rpdo.Unpack({.identifier = 0x205, .size = 3, .bytes = {6, 0, 1}}));
  EXPECT_EQ(objects.Get({0x6040, 0}), 15);
  EXPECT_TRUE(rpdo.Unpack({.identifier = 0x205, .size = 5, .bytes = {6, 0, 1, 0, 9}}));
  EXPECT_EQ(objects.Get({0x6071, 0}), 1);
}

TEST_F(PdoTest, IsNotChangedWhileItIsValid) {
  EXPECT_EQ(Put(0x1A00, 0, 0, 1), SdoAbort::kUnsupportedAccess);
  EXPECT_EQ(Put(0x1A00, 1, 0x6064'0020, 4), SdoAbort::kUnsupportedAccess);
  EXPECT_EQ(Put(0x1800, 1, 0x186, 4), SdoAbort::kInvalidValue);
  EXPECT_EQ(Put(0x1800, 1, 0x4000'0185, 4), SdoAbort::kNone);
  EXPECT_EQ(tpdo.identifier(), 0x185);
}

TEST_F(PdoTest, IsMappedOnlyWithItsCountTakenAway) {
  EXPECT_EQ(Put(0x1800, 1, 0x8000'0185, 4), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1A00, 1, 0x6064'0020, 4), SdoAbort::kUnsupportedAccess);
}

TEST_F(PdoTest, TakesNoObjectThatCannotTravel) {
  EXPECT_EQ(Put(0x1800, 1, 0x8000'0185, 4), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1400, 1, 0x8000'0205, 4), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1A00, 0, 0, 1), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1600, 0, 0, 1), SdoAbort::kNone);
  // None such, one that is not for PDOs, and a wrong length.
  for (const int64_t entry : {0x2000'0010, 0x6076'0020, 0x6064'0010, 0x6064'0120}) {
    EXPECT_EQ(Put(0x1A00, 1, entry, 4), SdoAbort::kNotMappable) << entry;
  }
  // Read-only objects are not received.
  EXPECT_EQ(Put(0x1600, 1, 0x6041'0010, 4), SdoAbort::kNotMappable);
}

TEST_F(PdoTest, HoldsNoMoreThanAFrame) {
  EXPECT_EQ(Put(0x1800, 1, 0x8000'0185, 4), SdoAbort::kNone);
  EXPECT_EQ(Put(0x1A00, 0, 0, 1), SdoAbort::kNone);
  for (uint8_t i = 1; i <= 3; ++i) {
    EXPECT_EQ(Put(0x1A00, i, 0x6064'0020, 4), SdoAbort::kNone);
  }
  EXPECT_EQ(Put(0x1A00, 0, 3, 1), SdoAbort::kPdoTooLong);
  EXPECT_EQ(Put(0x1A00, 0, 4, 1), SdoAbort::kNotMappable);
  EXPECT_EQ(Put(0x1A00, 0, 9, 1), SdoAbort::kTooHigh);
  EXPECT_EQ(Put(0x1A00, 0, 2, 1), SdoAbort::kNone);
}

TEST_F(PdoTest, KnowsItsTransmissionTypes) {
  for (const int64_t type : {0, 1, 240, 254, 255}) {
    EXPECT_EQ(Put(0x1400, 2, type, 1), SdoAbort::kNone) << type;
    EXPECT_EQ(rpdo.synchronous(), type <= 240);
  }
  EXPECT_EQ(Put(0x1400, 2, 241, 1), SdoAbort::kInvalidValue);
  EXPECT_EQ(Put(0x1800, 2, 240, 1), SdoAbort::kNone);
  for (const int64_t type : {0, 241, 253, 255}) {
    EXPECT_EQ(Put(0x1800, 2, type, 1), SdoAbort::kInvalidValue) << type;
  }
}

TEST_F(PdoTest, HasNoIdentifierThatIsNone) {
  EXPECT_EQ(Put(0x1800, 1, 0x8000'0000, 4), SdoAbort::kInvalidValue);
  EXPECT_EQ(Put(0x1800, 1, 0x8000'0800, 4), SdoAbort::kInvalidValue);
  EXPECT_EQ(Put(0x1800, 1, 0xA000'0185, 4), SdoAbort::kInvalidValue);
}

}  // namespace
}  // namespace mwidth::device::emulator
