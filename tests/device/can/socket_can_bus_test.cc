// Here the kernel may have no CAN: what then is said. Frames over a virtual bus are tested where there is
// one.
#include "device/can/socket_can_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

#include "device/can/wait.h"

namespace mwidth::device::can {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

bool KernelHasCan() {
  const int file = socket(PF_CAN, SOCK_RAW, 1);
  if (file >= 0) {
    close(file);
  }
  return file >= 0;
}

std::string ErrorOf(SocketCanBus& bus) {
  try {
    bus.Connect();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "connected";
}

TEST(SocketCanBus, SaysWhatToDoWhereThereIsNoInterface) {
  SocketCanBus bus({.interface = "nocan9"});
  const std::string error = ErrorOf(bus);
  EXPECT_THAT(error, HasSubstr("CAN interface nocan9: "));
  if (KernelHasCan()) {
    EXPECT_THAT(error, AllOf(HasSubstr("there is none of this name"), HasSubstr("ip link set nocan9 up")));
  } else {
    EXPECT_THAT(error, AllOf(HasSubstr("this kernel speaks no CAN"), HasSubstr("socketcand")));
  }
  Frame frame;
  EXPECT_FALSE(bus.Send({.identifier = 0x80}));
  EXPECT_EQ(bus.Receive(frame, 0), Reception::kLost);
  EXPECT_EQ(bus.counters().not_sent, 1);
}

TEST(SocketCanBus, CarriesFramesWhereThereIsAVirtualBus) {
  if (!KernelHasCan() || if_nametoindex("vcan0") == 0) {
    GTEST_SKIP() << "no vcan0 here";
  }
  SocketCanBus one({.interface = "vcan0"});
  SocketCanBus other({.interface = "vcan0"});
  one.Connect();
  other.Connect();
  const Frame sent{.identifier = 0x181, .size = 3, .bytes = {1, 2, 3}};
  ASSERT_TRUE(one.Send(sent));
  Frame frame;
  constexpr int64_t kLong = 1'000'000'000;
  ASSERT_EQ(other.Receive(frame, NowNs() + kLong), Reception::kFrame);
  EXPECT_EQ(frame, sent);
  EXPECT_EQ(one.Receive(frame, NowNs() + kLong / 100), Reception::kNothing) << "its own frame came back";
  ASSERT_TRUE(other.Send({.identifier = 0x701, .remote = true, .size = 1}));
  ASSERT_EQ(one.Receive(frame, NowNs() + kLong), Reception::kFrame);
  EXPECT_EQ(frame, (Frame{.identifier = 0x701, .remote = true, .size = 1, .bytes = {}}));
}

}  // namespace
}  // namespace mwidth::device::can
