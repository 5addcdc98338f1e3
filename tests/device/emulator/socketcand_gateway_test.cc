#include "device/emulator/socketcand_gateway.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "device/emulator/socketcand_text.h"

namespace mwidth::device::emulator {
namespace {

using boost::asio::ip::tcp;
using can::Frame;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;

class SocketcandGatewayTest : public ::testing::Test {
 protected:
  /// A client's socket, which never blocks.
  struct Client {
    explicit Client(SocketcandGatewayTest& owner) : socket(owner.context), test(owner) {
      const std::string where = test.gateway->Where();
      const auto port = static_cast<uint16_t>(std::stoi(where.substr(where.rfind(':') + 1)));
      // Small, so that it is full soon.
      socket.open(tcp::v4());
      socket.set_option(tcp::socket::receive_buffer_size(64 * 1024));
      socket.connect({boost::asio::ip::make_address("127.0.0.1"), port});
      socket.non_blocking(true);
    }
    void Say(const std::string& text) { boost::asio::write(socket, boost::asio::buffer(text)); }
    // All that comes until it ends with `end`, or the connection does.
    std::string HearUntil(const std::string& end) {
      std::string heard;
      const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
      while (!heard.ends_with(end) && !closed && std::chrono::steady_clock::now() < deadline) {
        test.context.run_for(std::chrono::milliseconds(1));
        std::string part(4096, ' ');
        boost::system::error_code error;
        part.resize(socket.read_some(boost::asio::buffer(part), error));
        heard += part;
        closed = error && error != boost::asio::error::would_block;
      }
      return heard;
    }
    bool IsHungUpOn() {
      HearUntil("nothing that is ever said");
      return closed;
    }
    void JoinBus() {
      EXPECT_EQ(HearUntil(">"), "< hi >");
      Say("< open can0 >");
      EXPECT_EQ(HearUntil(">"), "< ok >");
      Say("< rawmode >");
      EXPECT_EQ(HearUntil(">"), "< ok >");
    }

    tcp::socket socket;
    SocketcandGatewayTest& test;
    bool closed = false;
  };

  boost::asio::io_context context{1};
  LinkFaults faults;
  std::vector<Frame> taken;
  std::unique_ptr<SocketcandGateway> gateway = std::make_unique<SocketcandGateway>(
      context, "127.0.0.1", 0, "can0", [this](const Frame& frame) { taken.push_back(frame); }, faults);
};

TEST_F(SocketcandGatewayTest, HandsFramesToTheNodeAndToAllOtherClients) {
  Client one(*this);
  Client two(*this);
  one.JoinBus();
  two.JoinBus();
  one.Say("< send 123 2 1 ff >");
  EXPECT_THAT(two.HearUntil(">"), MatchesRegex("< frame 123 [0-9]+\\.[0-9]{6} 01FF >"));
  EXPECT_THAT(taken, ElementsAre(Frame{.identifier = 0x123, .size = 2, .bytes = {1, 0xFF}}));
  gateway->Send({.identifier = 0x181, .size = 1, .bytes = {7}});
  // The first thing that the sender hears is somebody else's frame.
  EXPECT_THAT(one.HearUntil(">"), MatchesRegex("< frame 181 .* 07 >"));
  EXPECT_THAT(two.HearUntil(">"), MatchesRegex("< frame 181 .* 07 >"));
}

TEST_F(SocketcandGatewayTest, ShowsFramesInRawModeAlone) {
  Client client(*this);
  client.HearUntil("< hi >");
  client.Say("< open can0 >");
  client.HearUntil("< ok >");
  gateway->Send({.identifier = 0x181});
  client.Say("< send 80 0  >< echo >");
  EXPECT_EQ(client.HearUntil("< echo >"), "< echo >");
  EXPECT_THAT(taken, ElementsAre(Frame{.identifier = 0x80}));
}

TEST_F(SocketcandGatewayTest, HangsUpOnWhoeverWantsAnotherBus) {
  Client client(*this);
  client.HearUntil("< hi >");
  client.Say("< open can1 >");
  EXPECT_EQ(client.HearUntil("anything else"), "< error could not open bus >");
  EXPECT_TRUE(client.closed);
}

TEST_F(SocketcandGatewayTest, SaysWhatItDoesNotUnderstand) {
  Client client(*this);
  client.HearUntil("< hi >");
  client.Say("< send 123 0 >");
  EXPECT_EQ(client.HearUntil(">"), "< error unknown command >");
  client.Say("< open can0 >");
  client.HearUntil(">");
  client.Say("< dance >");
  EXPECT_EQ(client.HearUntil(">"), "< error unknown command >");
  EXPECT_THAT(taken, IsEmpty());
}

TEST_F(SocketcandGatewayTest, DropsAClientThatNeverEndsAnElement) {
  Client client(*this);
  client.HearUntil("< hi >");
  client.Say("< " + std::string(2 * kMaxElementBytes, 'x'));
  EXPECT_TRUE(client.IsHungUpOn());
}

TEST_F(SocketcandGatewayTest, DropsAClientThatDoesNotRead) {
  Client slow(*this);
  slow.JoinBus();
  Client quick(*this);
  quick.JoinBus();
  // Far more than the sockets' buffers hold.
  for (int i = 0; i < 200; ++i) {
    for (int n = 0; n < 200; ++n) {
      gateway->Send({.identifier = 0x181, .size = 8});
    }
    gateway->Send({.identifier = 0x7FF, .size = 1});
    EXPECT_THAT(quick.HearUntil(" 00 >"), ::testing::HasSubstr("< frame 7FF"));
  }
  EXPECT_TRUE(slow.IsHungUpOn());
  EXPECT_FALSE(quick.closed);
}

TEST_F(SocketcandGatewayTest, HasRoomForSoManyClientsOnly) {
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t i = 0; i < SocketcandGateway::kMaxClients; ++i) {
    clients.push_back(std::make_unique<Client>(*this));
    EXPECT_EQ(clients.back()->HearUntil(">"), "< hi >");
  }
  EXPECT_TRUE(Client(*this).IsHungUpOn());
  clients.pop_back();
  context.run_for(std::chrono::milliseconds(20));
  EXPECT_EQ(Client(*this).HearUntil(">"), "< hi >");
}

TEST_F(SocketcandGatewayTest, DribblesOnDemand) {
  Client client(*this);
  client.JoinBus();
  faults.dribble_ns = 1'000'000;
  gateway->Send({.identifier = 0x181});
  EXPECT_THAT(client.HearUntil(">"), MatchesRegex("< frame 181 .*  >"));
  // The second byte would come when the test has long been over.
  faults.dribble_ns = 3'600'000'000'000;
  gateway->Send({.identifier = 0x181});
  EXPECT_EQ(client.HearUntil("<"), "<");
  EXPECT_FALSE(client.closed);
}

TEST_F(SocketcandGatewayTest, LeavesNobodyBehindWhenItEnds) {
  Client client(*this);
  client.JoinBus();
  gateway.reset();
  EXPECT_TRUE(client.IsHungUpOn());
}

}  // namespace
}  // namespace mwidth::device::emulator
