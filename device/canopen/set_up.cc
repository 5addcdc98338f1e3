#include "device/canopen/set_up.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <sstream>
#include <string>
#include <utility>

#include "device/canopen/cia402.h"
#include "device/canopen/frames.h"
#include "device/canopen/objects.h"

namespace mwidth::device::canopen {
namespace {

constexpr double kBootPatienceS = 3;
constexpr double kStartPatienceS = 0.5;
// 6076h is a whole number of thousandths, and nameplates round.
constexpr double kRatedTorqueTolerance = 1e-3;
// A PDO that nobody may ask for by a remote frame.
constexpr uint32_t kNoRemoteFrame = 0x4000'0000;

uint32_t Milliseconds(double time_s) { return static_cast<uint32_t>(std::lround(time_s * 1e3)); }

uint32_t Bits(int16_t value) { return static_cast<uint16_t>(value); }

class SettingUp {
 public:
  SettingUp(can::Bus& bus, const CanopenDriveConfig& config, Now now)
      : bus_(bus), config_(config), now_(now), sdo_(bus, config.node, now) {}

  void Run() {
    Reset();
    CheckType();
    MapPdos();
    SetTorque();
    SetTimes();
    Start();
  }

 private:
  [[noreturn]] static void Fail(const std::string& what) { throw std::runtime_error(what); }

  void Reset() {
    bus_.Send(NmtFrame(NmtCommand::kEnterPreOperational, config_.node));
    // Whatever it did before, and whoever made it: from here on there is no force.
    sdo_.Download(kControlword, kDisableVoltage);
    bus_.Send(NmtFrame(NmtCommand::kResetCommunication, config_.node));
    if (!SeesState(NmtState::kBootUp, kBootPatienceS)) {
      Fail("it does not boot up when its communication is reset; switch it off and on");
    }
  }

  bool SeesState(NmtState state, double patience_s) {
    const can::Frame wanted = HeartbeatFrame(config_.node, state);
    const int64_t deadline_ns = now_() + static_cast<int64_t>(patience_s * 1e9);
    for (int64_t left_ns = deadline_ns - now_(); left_ns > 0; left_ns = deadline_ns - now_()) {
      const auto frame = WaitFor(bus_, wanted.identifier, static_cast<double>(left_ns) * 1e-9, now_);
      if (!frame || *frame == wanted) {
        return frame.has_value();
      }
    }
    return false;
  }

  void CheckType() {
    constexpr uint32_t kProfileBits = 0xFFFF;
    const uint32_t profile = sdo_.Upload(kDeviceType) & kProfileBits;
    if (profile != kDriveProfile) {
      Fail("it is no drive: its device type (1000h) says profile " + std::to_string(profile) + ", not " +
           std::to_string(kDriveProfile) + "; check the node number");
    }
    sdo_.Download(kModeOfOperation, kCyclicSynchronousTorque);
    if (sdo_.Upload(kModeDisplay) != kCyclicSynchronousTorque) {
      Fail("it does not go into cyclic synchronous torque mode (6060h = 10); check that it knows it");
    }
  }

  void MapPdos() {
    const uint8_t rpdo_type = config_.exchange == TickExchange::kOnSync ? kOnEverySync : kEventDriven;
    Map(kRpdo1Identifier, kRpdo1, kRpdo1Type, rpdo_type, kRpdo1Count,
        std::array{kControlword, kTargetTorque});
    Map(kTpdo1Identifier, kTpdo1, kTpdo1Type, kOnEverySync, kTpdo1Count,
        std::array{kStatusword, kPosition, kTorque});
    // By the profile's defaults these bear the controlword too, for whoever sends them.
    const std::array others{std::pair{kRpdo2Identifier, kRpdo2}, std::pair{kRpdo3Identifier, kRpdo3},
                            std::pair{kRpdo4Identifier, kRpdo4}};
    for (const auto& [identifier, base] : others) {
      PutIfTaken(identifier, kPdoInvalid | (base + config_.node));
    }
  }

  // A PDO does not exist while it changes (CiA 301, 7.5.2.36).
  void Map(const Object& identifier, uint16_t base, const Object& type, uint8_t type_value,
           const Object& count, std::span<const Object> mapped) {
    const uint32_t of_node = kNoRemoteFrame | (base + config_.node);
    sdo_.Download(identifier, kPdoInvalid | of_node);
    sdo_.Download(type, type_value);
    sdo_.Download(count, 0);
    for (std::size_t i = 0; i < mapped.size(); ++i) {
      const Object& object = mapped[i];
      sdo_.Download({.index = count.index, .subindex = static_cast<uint8_t>(i + 1), .size = 4},
                    static_cast<uint32_t>(object.index) << 16 | static_cast<uint32_t>(object.subindex) << 8 |
                        object.size * 8U);
    }
    sdo_.Download(count, static_cast<uint32_t>(mapped.size()));
    sdo_.Download(identifier, of_node);
  }

  void Put(const Object& object, uint32_t value) {
    sdo_.Download(object, value);
    if (const uint32_t seen = sdo_.Upload(object); seen != value) {
      Fail("its object " + NameOf(object) + " is " + std::to_string(seen) + " after it was set to " +
           std::to_string(value) + "; check what the drive allows");
    }
  }

  void SetTorque() {
    const uint32_t rated = sdo_.Upload(kRatedTorque);
    if (!IsRatedTorque(rated, config_.rated_torque)) {
      std::ostringstream text;
      text << "its rated torque (6076h) is " << rated * 1e-3 << ", and torque.rated says "
           << config_.rated_torque
           << ": every force would be wrong by that; correct the configuration or the drive";
      Fail(text.str());
    }
    Put(kMaxTorque, config_.max_torque_per_mille);
    ClearTorqueOffset();
    Put(kQuickStopOption, Bits(config_.quick_stop_option));
  }

  // Left over from whoever had the drive before, it would be a force that nobody commands.
  void ClearTorqueOffset() {
    uint32_t offset = 0;
    try {
      offset = sdo_.Upload(kTorqueOffset);
    } catch (const SdoAborted&) {
      return;  // It has none.
    }
    if (offset != 0) {
      Put(kTorqueOffset, 0);
    }
  }

  void SetTimes() {
    sdo_.Download(kInterpolationPeriod, config_.interpolation_period);
    sdo_.Download(kInterpolationExponent, static_cast<uint8_t>(config_.interpolation_exponent));
    // Arming reads both back and decides: a drive may have them set by its own tool, or not at all.
    PutIfTaken(kConnectionLossOption, static_cast<uint32_t>(config_.connection_loss));
    PutIfTaken(kConsumerHeartbeat,
               static_cast<uint32_t>(config_.own_node) << 16 | Milliseconds(config_.watchdog_s));
    sdo_.Download(kProducerHeartbeat, Milliseconds(config_.drive_heartbeat_s));
  }

  void PutIfTaken(const Object& object, uint32_t value) {
    try {
      sdo_.Download(object, value);
    } catch (const SdoAborted&) {  // NOLINT(bugprone-empty-catch): arming tells
    }
  }

  void Start() {
    bus_.Send(NmtFrame(NmtCommand::kStart, config_.node));
    const double patience_s = std::max(kStartPatienceS, kMostHeartbeatsMissing * config_.drive_heartbeat_s);
    if (!SeesState(NmtState::kOperational, patience_s)) {
      Fail("it sends no heartbeat that says operational; check that it knows 1017h");
    }
  }

  can::Bus& bus_;
  const CanopenDriveConfig& config_;
  const Now now_;
  SdoClient sdo_;
};

}  // namespace

bool IsRatedTorque(uint32_t thousandths, double configured) {
  // Written so that a number that is none does not agree.
  return std::abs(thousandths * 1e-3 - configured) <= kRatedTorqueTolerance * configured + 0.5e-3;
}

void SetUp(can::Bus& bus, const CanopenDriveConfig& config, Now now) {
  try {
    SettingUp(bus, config, now).Run();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("CiA 402 drive, node " + std::to_string(config.node) + " on " +
                             can::NameOf(config.bus) + ": " + error.what());
  }
}

}  // namespace mwidth::device::canopen
