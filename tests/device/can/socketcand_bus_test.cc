#include "device/can/socketcand_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

#include "device/can/wait.h"
#include "tests/device/can/scripted_gateway.h"

namespace mwidth::device::can {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::ScriptedGateway;

constexpr int64_t kLong = 2'000'000'000;

class SocketcandBusTest : public ::testing::Test {
 protected:
  void Connect() {
    const std::jthread gateway_thread([this] { gateway.AcceptIntoRawMode(); });
    bus.Connect();
  }
  // What Connect throws while `speak` is what the gateway does.
  template <typename Speak>
  std::string ErrorWhile(Speak speak) {
    const std::jthread gateway_thread([this, speak] {
      gateway.Accept();
      speak();
    });
    try {
      bus.Connect();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "connected";
  }
  Reception Receive(int64_t patience_ns = kLong) { return bus.Receive(frame, NowNs() + patience_ns); }

  ScriptedGateway gateway;
  SocketcandBus bus{{.host = "127.0.0.1", .port = gateway.port(), .interface = "can0"}};
  Frame frame;
};

TEST_F(SocketcandBusTest, OpensTheInterfaceInRawMode) {
  Connect();
  EXPECT_EQ(gateway.asked, "< open can0 >< rawmode >");
}

TEST_F(SocketcandBusTest, SendsAndReceivesFrames) {
  Connect();
  EXPECT_TRUE(bus.Send({.identifier = 0x80}));
  EXPECT_TRUE(bus.Send({.identifier = 0x201, .size = 2, .bytes = {0x0F, 0}}));
  EXPECT_EQ(gateway.Hear("0F 00 >"), "< send 080 0 >< send 201 2 0F 00 >");
  gateway.Say("< frame 181 1.5 2706 >");
  ASSERT_EQ(Receive(), Reception::kFrame);
  EXPECT_EQ(frame, (Frame{.identifier = 0x181, .size = 2, .bytes = {0x27, 0x06}}));
}

TEST_F(SocketcandBusTest, PutsPiecesTogetherAndTakesSeveralFramesApart) {
  Connect();
  gateway.Say("< frame 181 1.5 01 >< frame 182 1.5 02 >\n< fra");
  ASSERT_EQ(Receive(), Reception::kFrame);
  EXPECT_EQ(frame.identifier, 0x181);
  ASSERT_EQ(Receive(), Reception::kFrame);
  EXPECT_EQ(frame.identifier, 0x182);
  EXPECT_EQ(Receive(1'000'000), Reception::kNothing);
  gateway.Say("me 183 1.5 03 >");
  ASSERT_EQ(Receive(), Reception::kFrame);
  EXPECT_EQ(frame.identifier, 0x183);
}

TEST_F(SocketcandBusTest, PassesOverWhatIsNoFrameAndCountsIt) {
  Connect();
  gateway.Say("< frame 00000181 1.5 01 >< error 004 1.5 >rubbish< frame 1 >< frame 181 1.5 01 >");
  ASSERT_EQ(Receive(), Reception::kFrame);
  EXPECT_EQ(frame.identifier, 0x181);
  EXPECT_EQ(bus.counters().not_classical, 1);
  EXPECT_EQ(bus.counters().error_frames, 1);
  EXPECT_EQ(bus.counters().malformed, 2);
}

TEST_F(SocketcandBusTest, ADeadlineInThePastTakesWhatIsThere) {
  Connect();
  EXPECT_EQ(bus.Receive(frame, 0), Reception::kNothing);
  gateway.Say("< frame 181 1.5 01 >");
  while (bus.Receive(frame, 0) == Reception::kNothing) {
    std::this_thread::yield();
  }
  EXPECT_EQ(frame.identifier, 0x181);
}

TEST_F(SocketcandBusTest, AFloodOfNothingDoesNotHoldTheLoop) {
  Connect();
  std::atomic<bool> ended{false};
  std::jthread flood([this, &ended](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      gateway.Say(std::string(1000, ' ') + std::string(500, 'x'));
    }
    ended = true;
  });
  for (int i = 0; i < 200 || bus.counters().malformed < 100; ++i) {
    EXPECT_EQ(bus.Receive(frame, 0), Reception::kNothing);
  }
  flood.request_stop();
  while (!ended) {  // It may be in the middle of a send that somebody must take.
    bus.Receive(frame, 0);
  }
}

TEST_F(SocketcandBusTest, TellsOfAGatewayThatHangsUpAndOfBusOffUntilItJoinsAnew) {
  Connect();
  gateway.Say("< error 040 1.5 >< frame 181 1.5 01 >");
  EXPECT_EQ(Receive(), Reception::kLost);
  EXPECT_EQ(Receive(), Reception::kLost);
  EXPECT_FALSE(bus.Send({.identifier = 0x80}));
  Connect();
  EXPECT_TRUE(bus.Send({.identifier = 0x80}));
  // What the connection before has left is gone.
  EXPECT_EQ(Receive(1'000'000), Reception::kNothing);
  gateway.HangUp();
  EXPECT_EQ(Receive(), Reception::kLost);
  EXPECT_EQ(bus.counters().lost, 2);
  EXPECT_EQ(bus.counters().not_sent, 1);
}

TEST_F(SocketcandBusTest, AGatewayThatTakesNothingIsLost) {
  Connect();
  int sent = 0;
  while (bus.Send({.identifier = 0x80})) {
    ASSERT_LT(++sent, 10'000'000);
  }
  EXPECT_EQ(Receive(), Reception::kLost);
}

TEST_F(SocketcandBusTest, SaysWhatToDoWhereItCannotJoin) {
  EXPECT_THAT(ErrorWhile([this] {
                gateway.Say("< hi >");
                gateway.Hear("< open can0 >");
                gateway.Say("< error could not open bus >");
              }),
              AllOf(HasSubstr("CAN gateway at 127.0.0.1:"), HasSubstr("does not open can0"),
                    HasSubstr("check that it offers this interface")));
  EXPECT_THAT(ErrorWhile([this] { gateway.HangUp(); }), HasSubstr("it hung up"));
  EXPECT_THAT(ErrorWhile([this] { gateway.Say("SSH-2.0-OpenSSH_9.2"); }),
              HasSubstr("check that nothing else listens there"));
}

TEST(SocketcandBus, SaysWhatToDoWhereNobodyListens) {
  uint16_t port = 0;
  {
    const ScriptedGateway gone;
    port = gone.port();
  }
  SocketcandBus bus({.host = "127.0.0.1", .port = port, .interface = "can0"});
  try {
    bus.Connect();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("refused"), HasSubstr("check that socketcand runs there")));
  }
  Frame frame;
  EXPECT_FALSE(bus.Send({}));
  EXPECT_EQ(bus.Receive(frame, 0), Reception::kLost);
}

}  // namespace
}  // namespace mwidth::device::can
