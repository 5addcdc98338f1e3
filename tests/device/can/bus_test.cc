#include "device/can/bus.h"

#include <gtest/gtest.h>

#include "device/can/socket_can_bus.h"
#include "device/can/socketcand_bus.h"

namespace mwidth::device::can {
namespace {

TEST(Bus, IsMadeAndNamedAsItIsConfigured) {
  const BusConfig here = SocketCan{.interface = "can3"};
  EXPECT_NE(dynamic_cast<SocketCanBus*>(MakeBus(here).get()), nullptr);
  EXPECT_EQ(NameOf(here), "can3");
  const BusConfig elsewhere = Socketcand{.host = "gateway", .port = 29'537, .interface = "can0"};
  EXPECT_NE(dynamic_cast<SocketcandBus*>(MakeBus(elsewhere).get()), nullptr);
  EXPECT_EQ(NameOf(elsewhere), "can0 of gateway:29537");
}

}  // namespace
}  // namespace mwidth::device::can
