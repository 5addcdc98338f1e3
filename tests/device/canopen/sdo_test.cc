#include "device/canopen/sdo.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace mwidth::device::canopen {
namespace {

can::Frame Reply(std::array<uint8_t, 8> bytes) { return {.identifier = 0x585, .size = 8, .bytes = bytes}; }

TEST(Sdo, AsksForAnObject) {
  EXPECT_EQ(UploadRequest(5, kDeviceType),
            (can::Frame{.identifier = 0x605, .size = 8, .bytes = {0x40, 0x00, 0x10, 0, 0, 0, 0, 0}}));
  EXPECT_EQ(UploadRequest(127, kInterpolationExponent),
            (can::Frame{.identifier = 0x67F, .size = 8, .bytes = {0x40, 0xC2, 0x60, 2, 0, 0, 0, 0}}));
}

TEST(Sdo, PutsValuesOfEveryWidth) {
  EXPECT_EQ(DownloadRequest(5, kModeOfOperation, 10),
            (can::Frame{.identifier = 0x605, .size = 8, .bytes = {0x2F, 0x60, 0x60, 0, 10, 0, 0, 0}}));
  EXPECT_EQ(DownloadRequest(5, kMaxTorque, 0x1234),
            (can::Frame{.identifier = 0x605, .size = 8, .bytes = {0x2B, 0x72, 0x60, 0, 0x34, 0x12, 0, 0}}));
  EXPECT_EQ(DownloadRequest(5, kConsumerHeartbeat, 0x007F'0032),
            (can::Frame{.identifier = 0x605, .size = 8, .bytes = {0x23, 0x16, 0x10, 1, 0x32, 0, 0x7F, 0}}));
  // No more than the object holds.
  EXPECT_EQ(DownloadRequest(5, kInterpolationExponent, 0xFFFF'FFFD).bytes,
            (std::array<uint8_t, 8>{0x2F, 0xC2, 0x60, 2, 0xFD, 0, 0, 0}));
}

TEST(Sdo, ReadsAValue) {
  const SdoReply four = UploadReply(Reply({0x43, 0x76, 0x60, 0, 0xD2, 0x04, 0, 0x80}), kRatedTorque);
  EXPECT_EQ(four.kind, SdoKind::kValue);
  EXPECT_EQ(four.value, 0x8000'04D2U);
  const SdoReply one = UploadReply(Reply({0x4F, 0x61, 0x60, 0, 10, 0xAA, 0xBB, 0xCC}), kModeDisplay);
  EXPECT_EQ(one.kind, SdoKind::kValue);
  EXPECT_EQ(one.value, 10U);
  // A node may leave out how long it is.
  EXPECT_EQ(UploadReply(Reply({0x42, 0x61, 0x60, 0, 10, 0, 0, 0}), kModeDisplay).value, 10U);
}

TEST(Sdo, TakesNoValueOfAnotherWidth) {
  EXPECT_EQ(UploadReply(Reply({0x4B, 0x61, 0x60, 0, 10, 0, 0, 0}), kModeDisplay).kind, SdoKind::kWrongSize);
  EXPECT_EQ(UploadReply(Reply({0x4F, 0x76, 0x60, 0, 10, 0, 0, 0}), kRatedTorque).kind, SdoKind::kWrongSize);
  // In segments.
  EXPECT_EQ(UploadReply(Reply({0x41, 0x76, 0x60, 0, 20, 0, 0, 0}), kRatedTorque).kind, SdoKind::kWrongSize);
}

TEST(Sdo, ReadsAnAbort) {
  for (const auto judge : {UploadReply, DownloadReply}) {
    const SdoReply reply = judge(Reply({0x80, 0x72, 0x60, 0, 0x31, 0x00, 0x09, 0x06}), kMaxTorque);
    EXPECT_EQ(reply.kind, SdoKind::kAborted);
    EXPECT_EQ(reply.value, 0x0609'0031U);
    EXPECT_STREQ(AbortWords(reply.value), "value of the parameter is too high");
  }
  EXPECT_STREQ(AbortWords(0x0602'0000), "object does not exist in the object dictionary");
  EXPECT_STREQ(AbortWords(0x1234'5678), "unknown abort code");
}

TEST(Sdo, AnAnswerToSomethingElseIsNone) {
  EXPECT_EQ(DownloadReply(Reply({0x60, 0x72, 0x60, 0, 0, 0, 0, 0}), kMaxTorque).kind, SdoKind::kTaken);
  EXPECT_EQ(DownloadReply(Reply({0x60, 0x73, 0x60, 0, 0, 0, 0, 0}), kMaxTorque).kind, SdoKind::kOther);
  EXPECT_EQ(DownloadReply(Reply({0x60, 0x72, 0x60, 1, 0, 0, 0, 0}), kMaxTorque).kind, SdoKind::kOther);
  EXPECT_EQ(DownloadReply(Reply({0x4B, 0x72, 0x60, 0, 0, 0, 0, 0}), kMaxTorque).kind, SdoKind::kOther);
  EXPECT_EQ(UploadReply(Reply({0x60, 0x72, 0x60, 0, 0, 0, 0, 0}), kMaxTorque).kind, SdoKind::kOther);
  can::Frame odd = Reply({0x60, 0x72, 0x60, 0, 0, 0, 0, 0});
  odd.size = 4;
  EXPECT_EQ(DownloadReply(odd, kMaxTorque).kind, SdoKind::kOther);
  odd.size = 8;
  odd.remote = true;
  EXPECT_EQ(DownloadReply(odd, kMaxTorque).kind, SdoKind::kOther);
}

TEST(Sdo, AnyBytesAreSomething) {
  std::mt19937 random(20120712);
  int values = 0;
  for (int round = 0; round < 200'000; ++round) {
    can::Frame frame = Reply({static_cast<uint8_t>(random()), 0x72, 0x60, 0});
    for (std::size_t at = 4; at < 8; ++at) {
      frame.bytes[at] = static_cast<uint8_t>(random());
    }
    frame.size = random() % 4 == 0 ? static_cast<uint8_t>(random() % 9) : uint8_t{8};
    const SdoReply reply = UploadReply(frame, kMaxTorque);
    values += reply.kind == SdoKind::kValue ? 1 : 0;
    ASSERT_TRUE(reply.kind != SdoKind::kValue || reply.value <= 0xFFFF);
    ASSERT_NE(reply.kind, SdoKind::kTaken);
    ASSERT_NE(DownloadReply(frame, kMaxTorque).kind, SdoKind::kValue);
  }
  EXPECT_GT(values, 100);
}

}  // namespace
}  // namespace mwidth::device::canopen
