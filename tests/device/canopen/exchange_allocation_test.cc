// Counts what a tick with a CANopen drive allocates, by standing in for operator new.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <thread>

#include "device/can/socketcand_bus.h"
#include "device/canopen/canopen_drive.h"
#include "device/canopen/frames.h"
#include "tests/device/can/scripted_gateway.h"

namespace {

std::atomic<uint64_t> allocations{0};

}  // namespace

// Not inlined: the compiler would see malloc's memory go to delete, and warn.
// NOLINTBEGIN(cppcoreguidelines-no-malloc,misc-new-delete-overloads)
[[gnu::noinline]] void* operator new(std::size_t size) {
  allocations.fetch_add(1);
  if (void* memory = std::malloc(size)) {
    return memory;
  }
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc,misc-new-delete-overloads)

namespace mwidth::device::canopen {
namespace {

constexpr uint8_t kNode = 5;

/// The least drive that can be armed: it answers in place, from memory of a fixed size.
class PlainBus final : public can::Bus {
 public:
  void Connect() override {}
  bool Send(const can::Frame& frame) noexcept override {
    if (frame.identifier == kSync) {
      can::Frame answer{.identifier = kTpdo1 + kNode, .size = 8};
      Put(answer, 0, 2, statusword_);
      Say(answer);
    } else if (frame.identifier == kNmt && frame.bytes[0] == static_cast<uint8_t>(NmtCommand::kStart)) {
      Say(HeartbeatFrame(kNode, NmtState::kOperational));
    } else if (frame.identifier == kNmt && frame.bytes[0] != 0x80) {
      Say(HeartbeatFrame(kNode, NmtState::kBootUp));
    } else if (frame.identifier == kSdoRequest + kNode) {
      Answer(frame);
    } else if (frame.identifier == kRpdo1 + kNode) {
      constexpr std::array<uint16_t, 16> kStatuswords{0x250, 0, 0, 0, 0, 0, 0x231, 0x233,
                                                      0,     0, 0, 0, 0, 0, 0,     0x237};
      statusword_ = kStatuswords[frame.bytes[0] & 0x0F];
    }
    return true;
  }
  can::Reception Receive(can::Frame& frame, int64_t deadline_ns) noexcept override {
    now_ns = std::max(now_ns, deadline_ns);
    if (size_ == 0) {
      return can::Reception::kNothing;
    }
    frame = queue_[--size_];
    return can::Reception::kFrame;
  }
  const can::BusCounters& counters() const noexcept override { return counters_; }

  static inline int64_t now_ns = 1'000'000'000;

 private:
  void Say(const can::Frame& frame) noexcept { queue_[size_++ % queue_.size()] = frame; }
  void Answer(const can::Frame& request) noexcept {
    can::Frame answer = request;
    answer.identifier = kSdoReply + kNode;
    const uint32_t index = Get(request, 1, 2);
    if (request.bytes[0] != 0x40) {
      answer.bytes[0] = 0x60;
      stored_ = index == 0x6072 || index == 0x605A || index == 0x1016 ? Get(request, 4, 4) : stored_;
      consumer_ = index == 0x1016 ? Get(request, 4, 4) : consumer_;
    } else {
      answer.bytes[0] = 0x42;
      Put(answer, 4, 4,
          index == 0x1000   ? 402
          : index == 0x6061 ? 10
          : index == 0x6076 ? 1000
          : index == 0x1016 ? consumer_
          : index == 0x6007 ? 2
          : index == 0x60B2 ? 0
                            : stored_);
    }
    Say(answer);
  }

  can::BusCounters counters_;
  std::array<can::Frame, 8> queue_;
  std::size_t size_ = 0;
  uint16_t statusword_ = 0x250;
  uint32_t stored_ = 0;
  uint32_t consumer_ = 0;
};

int64_t PlainNow() noexcept { return PlainBus::now_ns; }

TEST(CanopenDriveAllocation, ATickAllocatesNothing) {
  CanopenDriveConfig config;
  config.bus = can::SocketCan{.interface = "plain"};
  config.node = kNode;
  config.reply_deadline_s = 4e-4;
  config.position_scale = 1e-4;
  config.rated_torque = 1;
  config.drive_heartbeat_s = 1000;  // This drive sends none.
  const uint64_t before_set_up = allocations.load();
  CanopenDrive drive(config, std::make_unique<PlainBus>(), PlainNow);
  const uint64_t before = allocations.load();
  ASSERT_GT(before, before_set_up) << "the counter sees nothing";
  Enabling enabling = Enabling::kPending;
  uint64_t answered = 0;
  uint64_t written = 0;
  for (uint64_t tick = 0; tick < 10'000; ++tick) {
    PlainBus::now_ns += 1'000'000;
    answered += drive.Read(tick).ok ? 1 : 0;
    if (enabling == Enabling::kPending) {
      enabling = drive.Enable();
    }
    written += drive.Write(static_cast<int32_t>(tick % 100)) ? 1 : 0;
    if (tick % 1000 == 999) {
      drive.Disable();
      enabling = Enabling::kPending;
    }
  }
  drive.Disable();
  EXPECT_EQ(allocations.load(), before);
  EXPECT_EQ(answered, 10'000);
  EXPECT_GT(written, 9'800);
}

TEST(SocketcandBusAllocation, NeitherSendingNorReceivingAllocates) {
  can::testing::ScriptedGateway gateway;
  can::SocketcandBus bus({.host = "127.0.0.1", .port = gateway.port(), .interface = "can0"});
  {
    const std::jthread gateway_thread([&gateway] { gateway.AcceptIntoRawMode(); });
    bus.Connect();
  }
  gateway.Say("< frame 185 1.5 3712000000000000 >rubbish< error 004 1.5 >< frame 705 1.5 05 >< fra");
  const uint64_t before = allocations.load();
  can::Frame frame;
  constexpr int64_t kLong = 2'000'000'000;
  ASSERT_EQ(bus.Receive(frame, NowNs() + kLong), can::Reception::kFrame);
  ASSERT_EQ(bus.Receive(frame, NowNs() + kLong), can::Reception::kFrame);
  EXPECT_EQ(bus.Receive(frame, NowNs() + 1'000'000), can::Reception::kNothing);
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(bus.Send({.identifier = 0x80}));
  }
  gateway.HangUp();
  EXPECT_EQ(bus.Receive(frame, NowNs() + kLong), can::Reception::kLost);
  EXPECT_FALSE(bus.Send({.identifier = 0x80}));
  EXPECT_EQ(allocations.load(), before);
}

}  // namespace
}  // namespace mwidth::device::canopen
