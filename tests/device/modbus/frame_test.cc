// Requests and replies against the examples of the Modbus Application Protocol Specification V1.1b3.
#include "device/modbus/frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace mwidth::device::modbus {
namespace {

using testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

Bytes Of(const Request& request) { return {request.pdu().begin(), request.pdu().end()}; }

// Section 6.3: registers 108 to 110.
const Request kRead = ReadRegisters(0x6B, 3);
const Bytes kReadReply{0x03, 0x06, 0x02, 0x2B, 0x00, 0x00, 0x00, 0x64};

TEST(ModbusRequest, HasTheBytesOfTheSpecification) {
  EXPECT_THAT(Of(kRead), ElementsAre(0x03, 0x00, 0x6B, 0x00, 0x03));
  // Section 6.12.
  const std::array<uint16_t, 2> two{0x000A, 0x0102};
  EXPECT_THAT(Of(WriteRegisters(1, two)),
              ElementsAre(0x10, 0x00, 0x01, 0x00, 0x02, 0x04, 0x00, 0x0A, 0x01, 0x02));
  // Section 6.17.
  const std::array<uint16_t, 3> three{0xFF, 0xFF, 0xFF};
  EXPECT_THAT(Of(ReadWriteRegisters(3, 6, 14, three)),
              ElementsAre(0x17, 0x00, 0x03, 0x00, 0x06, 0x00, 0x0E, 0x00, 0x03, 0x06, 0x00, 0xFF, 0x00, 0xFF,
                          0x00, 0xFF));
}

TEST(ModbusReply, BringsTheRegistersThatWereAskedFor) {
  std::array<uint16_t, 3> values{};
  EXPECT_EQ(ParseReply(kRead, kReadReply, values).kind, ReplyKind::kAnswer);
  EXPECT_THAT(values, ElementsAre(0x022B, 0x0000, 0x0064));
}

TEST(ModbusReply, OfAWriteRepeatsItsAddressAndCount) {
  const std::array<uint16_t, 2> two{0x000A, 0x0102};
  const Request request = WriteRegisters(1, two);
  EXPECT_EQ(ParseReply(request, Bytes{0x10, 0, 1, 0, 2}, {}).kind, ReplyKind::kAnswer);
  EXPECT_EQ(ParseReply(request, Bytes{0x10, 0, 1, 0, 1}, {}).kind, ReplyKind::kMalformed);
  EXPECT_EQ(ParseReply(request, Bytes{0x10, 0, 1, 0}, {}).kind, ReplyKind::kMalformed);
}

TEST(ModbusReply, TellsTheExceptionOfTheDrive) {
  std::array<uint16_t, 3> values{};
  const Reply reply = ParseReply(kRead, Bytes{0x83, 0x02}, values);
  EXPECT_EQ(reply.kind, ReplyKind::kException);
  EXPECT_EQ(reply.exception, 2);
  EXPECT_EQ(ParseReply(kRead, Bytes{0x90, 0x02}, values).kind, ReplyKind::kMalformed);
  EXPECT_EQ(ParseReply(kRead, Bytes{0x83, 0x02, 0x00}, values).kind, ReplyKind::kMalformed);
}

TEST(ModbusReply, WithALengthThatLiesIsMalformedAndLeavesTheValuesAlone) {
  std::array<uint16_t, 3> values{7, 8, 9};
  for (const uint8_t length : std::to_array<uint8_t>({0, 5, 7, 8, 255})) {
    Bytes reply = kReadReply;
    reply[1] = length;
    EXPECT_EQ(ParseReply(kRead, reply, values).kind, ReplyKind::kMalformed) << int{length};
  }
  for (std::size_t size = 0; size < kReadReply.size(); ++size) {
    EXPECT_EQ(ParseReply(kRead, std::span(kReadReply).first(size), values).kind, ReplyKind::kMalformed)
        << size;
  }
  EXPECT_THAT(values, ElementsAre(7, 8, 9));
}

Bytes Framed(uint16_t transaction, uint8_t unit, const Bytes& pdu) {
  Bytes frame{static_cast<uint8_t>(transaction >> 8),
              static_cast<uint8_t>(transaction),
              0,
              0,
              0,
              static_cast<uint8_t>(pdu.size() + 1),
              unit};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

TEST(ModbusTcp, FramesBearTransactionLengthAndUnit) {
  std::array<uint8_t, kMaxTcpBytes> frame{};
  const std::size_t size = WrapTcp(kRead, 0x1501, 0xFF, frame);
  EXPECT_EQ(Bytes(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size)),
            Framed(0x1501, 0xFF, Of(kRead)));
}

TEST(ModbusTcp, RepliesToOthersAreToldApart) {
  std::array<uint16_t, 3> values{};
  EXPECT_EQ(ParseTcpReply(kRead, 9, 1, Framed(9, 1, kReadReply), values).kind, ReplyKind::kAnswer);
  EXPECT_EQ(ParseTcpReply(kRead, 9, 1, Framed(8, 1, kReadReply), values).kind, ReplyKind::kOtherTransaction);
  EXPECT_EQ(ParseTcpReply(kRead, 9, 1, Framed(9, 2, kReadReply), values).kind, ReplyKind::kOtherUnit);
  Bytes protocol = Framed(9, 1, kReadReply);
  protocol[2] = 1;
  EXPECT_EQ(ParseTcpReply(kRead, 9, 1, protocol, values).kind, ReplyKind::kMalformed);
  Bytes length = Framed(9, 1, kReadReply);
  length[5] += 1;
  EXPECT_EQ(ParseTcpReply(kRead, 9, 1, length, values).kind, ReplyKind::kMalformed);
}

TEST(ModbusTcp, NoBytesAreReadAsAnAnswerThatIsNone) {
  std::mt19937 random(5);
  for (int i = 0; i < 100'000; ++i) {
    Bytes frame = Framed(9, 1, kReadReply);
    const std::size_t place = random() % frame.size();
    const auto byte = static_cast<uint8_t>(random());
    const bool in_the_values = place >= kTcpHeaderBytes + 2;
    const bool same = frame[place] == byte;
    frame[place] = byte;
    frame.resize(random() % 8 == 0 ? random() % (frame.size() + 1) : frame.size());
    std::array<uint16_t, 3> values{};
    const bool whole = frame.size() == kTcpHeaderBytes + kReadReply.size();
    EXPECT_EQ(ParseTcpReply(kRead, 9, 1, frame, values).kind == ReplyKind::kAnswer,
              whole && (in_the_values || same));
  }
}

}  // namespace
}  // namespace mwidth::device::modbus
