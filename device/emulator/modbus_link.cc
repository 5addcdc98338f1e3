#include <memory>
#include <string>
#include <variant>

#include "device/emulator/link.h"
#include "device/emulator/modbus_registers.h"
#include "device/emulator/modbus_rtu_server.h"
#include "device/emulator/modbus_tcp_server.h"
#include "device/emulator/serial_line.h"

namespace mwidth::device::emulator {
namespace {

namespace asio = boost::asio;
using modbus::ModbusDriveConfig;
using modbus::SerialLine;

class ModbusLink : public Link {
 public:
  bool Has(std::string_view fault) const override {
    return fault != "abort" && fault != "emcy" && fault != "heartbeat-loss";
  }
};

class TcpLink final : public ModbusLink {
 public:
  TcpLink(asio::io_context& context, const ModbusDriveConfig& drive, const LinkPlace& place, Joint& joint,
          const LinkFaults& faults)
      : address_(place.address),
        registers_(drive, joint, faults),
        server_(context, place.address, place.port.value_or(0), drive.link.unit, registers_, faults) {}

  std::string Where() const override { return address_ + ":" + std::to_string(server_.port()); }

 private:
  const std::string address_;
  ModbusRegisters registers_;
  ModbusTcpServer server_;
};

class SerialLink final : public ModbusLink {
 public:
  SerialLink(asio::io_context& context, const ModbusDriveConfig& drive, const SerialLine& line,
             const std::string& device, Joint& joint, const LinkFaults& faults)
      : device_(device),
        registers_(drive, joint, faults),
        server_(OpenSerialPort(context, device, line), drive.link.unit, RtuSilence(line.baud), registers_,
                faults) {}

  std::string Where() const override { return device_; }

 private:
  const std::string device_;
  ModbusRegisters registers_;
  ModbusRtuServer server_;
};

class PtyLink final : public ModbusLink {
 public:
  PtyLink(asio::io_context& context, const ModbusDriveConfig& drive, const SerialLine& line, Joint& joint,
          const LinkFaults& faults)
      : terminal_(context),
        registers_(drive, joint, faults),
        server_(terminal_.TakeLine(), drive.link.unit, RtuSilence(line.baud), registers_, faults) {}

  std::string Where() const override { return terminal_.path(); }

 private:
  PseudoTerminal terminal_;
  ModbusRegisters registers_;
  ModbusRtuServer server_;
};

}  // namespace

std::unique_ptr<Link> OpenLink(asio::io_context& context, const ModbusDriveConfig& drive,
                               const LinkPlace& place, Joint& joint, const LinkFaults& faults) {
  const auto* configured = std::get_if<SerialLine>(&drive.link.peer);
  const SerialLine line = configured != nullptr ? *configured : SerialLine{};
  if (place.pty) {
    return std::make_unique<PtyLink>(context, drive, line, joint, faults);
  }
  if (configured == nullptr && place.device.empty()) {
    return std::make_unique<TcpLink>(context, drive, place, joint, faults);
  }
  return std::make_unique<SerialLink>(context, drive, line, place.device.empty() ? line.device : place.device,
                                      joint, faults);
}

}  // namespace mwidth::device::emulator
