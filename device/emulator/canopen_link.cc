#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <stdexcept>
#include <utility>
#include <variant>

#include "device/emulator/can_bus.h"
#include "device/emulator/canopen_node.h"
#include "device/emulator/link.h"
#include "device/emulator/socketcan_bus.h"
#include "device/emulator/socketcand_gateway.h"

namespace mwidth::device::emulator {
namespace {

namespace asio = boost::asio;
using canopen::CanopenDriveConfig;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

int64_t NowNs() { return steady_clock::now().time_since_epoch() / nanoseconds(1); }

/// What a node sends, with the faults of a link that is no stream: nothing, or late.
class Outbox {
 public:
  /// References outlive it.
  Outbox(asio::io_context& context, const LinkFaults& faults, std::function<void(const can::Frame&)> send)
      : timer_(context), faults_(faults), send_(std::move(send)) {}

  void Send(const can::Frame& frame) {
    const nanoseconds delay(faults_.delay_ns);
    if (faults_.silent) {
      return;
    }
    if (delay.count() == 0 && late_.empty()) {
      send_(frame);
      return;
    }
    late_.push_back({steady_clock::now() + delay, frame});
    if (late_.size() == 1) {
      AwaitFirst();
    }
  }

 private:
  struct Late {
    steady_clock::time_point due;
    can::Frame frame;
  };

  void AwaitFirst() {
    timer_.expires_at(late_.front().due);
    timer_.async_wait([this](auto error) {
      if (error) {
        return;
      }
      send_(late_.front().frame);
      late_.pop_front();
      if (!late_.empty()) {
        AwaitFirst();
      }
    });
  }

  asio::steady_timer timer_;
  const LinkFaults& faults_;
  const std::function<void(const can::Frame&)> send_;
  std::deque<Late> late_;
};

class CanopenLink final : public Link {
 public:
  CanopenLink(asio::io_context& context, const CanopenDriveConfig& drive, const LinkPlace& place,
              bool has_watchdog, Joint& joint, const LinkFaults& faults)
      : outbox_(context, faults, [this](const can::Frame& frame) { bus_->Send(frame); }),
        node_(drive, has_watchdog, joint, faults, [this](const can::Frame& frame) { outbox_.Send(frame); }),
        bus_(OpenBus(context, drive, place, faults)) {}

  std::string Where() const override { return bus_->Where(); }
  bool Has(std::string_view fault) const override {
    const bool stream = dynamic_cast<const SocketcandGateway*>(bus_.get()) != nullptr;
    return fault != "exceptions" && (fault != "dribble" || stream);
  }
  void Turn(int64_t now_ns) override { node_.Turn(now_ns); }
  void Fail(uint16_t code) override { node_.Fail(code, NowNs()); }

 private:
  std::unique_ptr<CanBus> OpenBus(asio::io_context& context, const CanopenDriveConfig& drive,
                                  const LinkPlace& place, const LinkFaults& faults) {
    TakeFrame take = [this](const can::Frame& frame) { node_.Receive(frame, NowNs()); };
    const std::string interface = std::visit([](const auto& bus) { return bus.interface; }, drive.bus);
    if (std::holds_alternative<can::SocketCan>(drive.bus) && !place.port) {
      return std::make_unique<SocketcanBus>(context, interface, std::move(take));
    }
    return std::make_unique<SocketcandGateway>(context, place.address, place.port.value_or(0), interface,
                                               std::move(take), faults);
  }

  Outbox outbox_;
  CanopenNode node_;
  std::unique_ptr<CanBus> bus_;
};

}  // namespace

std::unique_ptr<Link> OpenLink(asio::io_context& context, const CanopenDriveConfig& drive,
                               const LinkPlace& place, bool has_watchdog, Joint& joint,
                               const LinkFaults& faults) {
  if (place.pty || !place.device.empty()) {
    throw std::invalid_argument(kSerialOnly);
  }
  return std::make_unique<CanopenLink>(context, drive, place, has_watchdog, joint, faults);
}

}  // namespace mwidth::device::emulator
