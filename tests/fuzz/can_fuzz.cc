// Any bytes from a CAN bus: text of a gateway comes to an end and is only taken for a frame where it is one;
// SDO answers are judged within their width; and whatever is on the bus between the ticks of an armed drive,
// no torque goes out but the one that was written.
#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "device/can/socketcand.h"
#include "device/canopen/canopen_drive.h"
#include "device/canopen/sdo.h"
#include "tests/device/canopen/fake_node.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

namespace can = mwidth::device::can;
namespace canopen = mwidth::device::canopen;
using canopen::testing::FakeBus;
using canopen::testing::FakeNode;
using canopen::testing::FakeNow;
using mwidth::fuzz::Require;

void ReadText(std::span<const uint8_t> bytes) {
  // A copy of its own, so that the sanitizer sees any read beyond the end.
  const std::vector<char> text(bytes.begin(), bytes.end());
  std::string_view left(text.data(), text.size());
  while (true) {
    const can::Element element = can::FirstElement(left);
    Require(element.size <= left.size(), "no more than there is");
    Require(element.kind == can::ElementKind::kFrame || element.frame == can::Frame{},
            "only a frame brings one");
    Require(element.frame.identifier <= can::kMaxIdentifier && element.frame.size <= can::kMaxFrameBytes,
            "a frame of classical CAN");
    if (element.kind == can::ElementKind::kFrame && !element.frame.remote) {
      const can::SendElement sent = can::ToSend(element.frame);
      Require(sent.size < sent.text.size() && sent.view().ends_with(" >"), "a frame that can be sent on");
    }
    left.remove_prefix(element.size);
    if (element.kind == can::ElementKind::kIncomplete) {
      break;
    }
    Require(element.size > 0, "progress");
  }
  Require(left.size() < can::kMaxElementBytes, "an element that is never closed is given up");
}

// Of an input: a byte each for what, where and when, then as many as the frame holds.
class Frames {
 public:
  explicit Frames(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  bool empty() const { return bytes_.empty(); }
  uint8_t Byte() {
    const uint8_t byte = bytes_.empty() ? uint8_t{0} : bytes_.front();
    bytes_ = bytes_.subspan(bytes_.empty() ? 0 : 1);
    return byte;
  }
  can::Frame Next() {
    constexpr std::array<uint16_t, 8> kIdentifiers{0x000, 0x080, 0x085, 0x185, 0x205, 0x585, 0x705, 0x77F};
    const uint8_t what = Byte();
    can::Frame frame{.identifier = kIdentifiers[what & 0x07],
                     .remote = (what & 0x80) != 0,
                     .size = static_cast<uint8_t>(std::min((what >> 3) & 0x0F, 8))};
    for (uint8_t at = 0; at < frame.size && !frame.remote; ++at) {
      frame.bytes[at] = Byte();
    }
    return frame;
  }

 private:
  std::span<const uint8_t> bytes_;
};

void JudgeSdo(Frames frames) {
  can::Frame frame = frames.Next();
  frame.size = frame.size == 0 ? can::kMaxFrameBytes : frame.size;
  for (const canopen::Object& object : {canopen::kModeDisplay, canopen::kMaxTorque, canopen::kRatedTorque}) {
    // As if it were about this object, so that what follows is judged as well.
    canopen::Put(frame, 1, 2, object.index);
    frame.bytes[3] = object.subindex;
    const canopen::SdoReply upload = canopen::UploadReply(frame, object);
    Require(upload.kind != canopen::SdoKind::kValue || object.size == 4 ||
                upload.value < (1U << (8 * object.size)),
            "a value of the object's width");
    Require(upload.kind != canopen::SdoKind::kTaken, "an answer to what was asked");
    Require(canopen::DownloadReply(frame, object).kind != canopen::SdoKind::kValue,
            "an answer to what was asked");
    Require(canopen::AbortWords(upload.value) != nullptr, "words for every code");
  }
}

void Tick(canopen::CanopenDrive& drive, FakeNode& node, uint64_t tick, uint8_t choice) {
  const std::size_t before = node.commands.size();
  const mwidth::device::Reading reading = drive.Read(tick);
  if (reading.trouble != mwidth::device::DriveTrouble::kNone) {
    drive.Disable();
  } else if (choice % 4 == 0) {
    drive.Enable();
  }
  const int32_t force = (choice - 128) * 20;
  const bool written = drive.Write(force);
  for (std::size_t i = before; i < node.commands.size(); ++i) {
    const auto torque = static_cast<int16_t>(canopen::Get(node.commands[i], 2, 2));
    const bool enables = canopen::Get(node.commands[i], 0, 2) == canopen::kEnableOperation;
    Require(torque == 0 || (written && enables && torque == -force),
            "no torque but the one that was written");
    Require(std::abs(torque) <= 1500, "no more torque than the drive may give");
  }
}

void Disturb(Frames frames) {
  canopen::testing::fake_now_ns = 1'000'000'000;
  FakeBus::lost = false;
  FakeBus::refuses = false;
  const auto node = std::make_shared<FakeNode>();
  canopen::CanopenDriveConfig config = canopen::testing::TestConfig();
  config.exchange =
      frames.Byte() % 2 == 0 ? canopen::TickExchange::kOnReceipt : canopen::TickExchange::kOnSync;
  canopen::CanopenDrive drive(config, std::make_unique<FakeBus>(node), FakeNow);
  FakeBus::refuses = true;  // A drive that is lost stays so: its other thread keeps off the bus.
  uint64_t tick = 0;
  for (; tick < 12; ++tick) {
    canopen::testing::fake_now_ns += canopen::testing::kTickNs;
    drive.Read(tick);
    if (drive.Enable() == mwidth::device::Enabling::kEnabled) {
      break;
    }
  }
  Require(node->state == canopen::DriveState::kOperationEnabled, "a quiet bus on which the drive is armed");
  // As many ticks as frames.
  constexpr uint64_t kMostTicks = 200;
  for (; !frames.empty() && tick < kMostTicks; ++tick) {
    canopen::testing::fake_now_ns += canopen::testing::kTickNs;
    const uint8_t choice = frames.Byte();
    node->answers_sync = choice % 8 != 1;
    constexpr int64_t kStepNs = 5'000;
    node->Say(frames.Next(), choice * kStepNs);
    Tick(drive, *node, tick, choice);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  const std::span<const uint8_t> bytes(data, size);
  ReadText(bytes);
  JudgeSdo(Frames(bytes));
  Disturb(Frames(bytes));
  return 0;
}
