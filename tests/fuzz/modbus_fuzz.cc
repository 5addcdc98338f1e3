// Any bytes from a Modbus line: a reply is judged without reading beyond it, and only what was asked for
// counts; a request to the emulated drive gets an answer of the protocol.
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "device/emulator/modbus_registers.h"
#include "device/modbus/frame.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

namespace modbus = mwidth::device::modbus;
namespace emulator = mwidth::device::emulator;

class Still final : public mwidth::device::HandMotion {
 public:
  double PositionAt(double /*time_s*/) const noexcept override { return 0; }
};

modbus::ModbusDriveConfig Map() {
  modbus::ModbusDriveConfig config;
  config.map.position = {.address = 0, .type = modbus::RegisterType::kInt32, .scale = 1e-4};
  config.map.force = {.address = 2, .type = modbus::RegisterType::kFloat32, .scale = 1};
  config.map.enable = modbus::EnableRegister{.address = 4};
  config.position_quantum = 1e-4;
  config.force_quantum = 1e-3;
  return config;
}

void JudgeReply(std::span<const uint8_t> bytes) {
  // A copy of its own, so that the sanitizer sees any read beyond the end.
  const std::vector<uint8_t> frame(bytes.begin(), bytes.end());
  std::array<uint16_t, modbus::kMaxRegisters> values{};
  values.fill(0xABCD);
  const modbus::Request request = modbus::ReadRegisters(0, 2);
  const modbus::Reply reply = modbus::ParseTcpReply(request, 1, 1, frame, values);
  const bool untouched = values[0] == 0xABCD && values[1] == 0xABCD;
  mwidth::fuzz::Require(reply.kind == modbus::ReplyKind::kAnswer || untouched,
                        "only an answer brings values");
  mwidth::fuzz::Require(values[2] == 0xABCD, "no more values than were asked for");
  if (reply.kind == modbus::ReplyKind::kAnswer) {
    mwidth::fuzz::Require(frame.size() == modbus::kTcpHeaderBytes + 2 + 4, "an answer of the right length");
  }
}

void AskDrive(std::span<const uint8_t> bytes) {
  static emulator::Joint joint(
      {.plant = {.device_mass = 0.2, .hand_damping = 1, .hand_stiffness = 25, .cutoff_hz = 10},
       .position_quantum = 1e-4,
       .force_quantum = 1e-3},
      std::make_unique<Still>());
  static const emulator::LinkFaults faults;
  static emulator::ModbusRegisters registers(Map(), joint, faults);
  const std::vector<uint8_t> request(bytes.begin(), bytes.end());
  const std::vector<uint8_t> answer = registers.Answer(request, 1);
  mwidth::fuzz::Require(answer.size() <= modbus::kMaxPduBytes, "an answer that fits");
  mwidth::fuzz::Require(answer.empty() == request.empty(), "an answer to every request");
  if (!answer.empty()) {
    mwidth::fuzz::Require((answer[0] & 0x7F) == (request[0] & 0x7F), "the function that was asked for");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  JudgeReply({data, size});
  AskDrive({data, size});
  return 0;
}
