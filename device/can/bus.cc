#include "device/can/bus.h"

#include "device/can/socket_can_bus.h"
#include "device/can/socketcand_bus.h"

namespace mwidth::device::can {

std::string NameOf(const BusConfig& config) {
  if (const auto* gateway = std::get_if<Socketcand>(&config)) {
    return gateway->interface + " of " + gateway->host + ":" + std::to_string(gateway->port);
  }
  return std::get<SocketCan>(config).interface;
}

std::unique_ptr<Bus> MakeBus(const BusConfig& config) {
  if (const auto* gateway = std::get_if<Socketcand>(&config)) {
    return std::make_unique<SocketcandBus>(*gateway);
  }
  return std::make_unique<SocketCanBus>(std::get<SocketCan>(config));
}

}  // namespace mwidth::device::can
