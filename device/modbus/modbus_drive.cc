#include "device/modbus/modbus_drive.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <stdexcept>

namespace mwidth::device::modbus {
namespace {

// What a drive may take for each answer before it is armed: there is no force yet that could be late.
constexpr double kArmingPatienceS = 0.005;

// Long enough for every watchdog that a drive is armed with to fire.
constexpr int64_t kSilenceNs = static_cast<int64_t>(1.5 * kMaxWatchdogS * 1e9);

int64_t DeadlineNs(double in_s) noexcept { return NowNs() + static_cast<int64_t>(in_s * 1e9); }

// Whole numbers are counts already.
double Quantum(const RegisterValue& value, double of_a_float) noexcept {
  return value.type == RegisterType::kFloat32 ? of_a_float : std::abs(value.scale);
}

// Whole numbers come from a counter that wraps.
int BitsOf(const RegisterValue& position) noexcept {
  constexpr int kAll = 64;
  return position.type == RegisterType::kFloat32 ? kAll : position.CounterBits();
}

DriveInfo InfoOf(const ModbusDriveConfig& config) noexcept {
  return {.position_quantum = Quantum(config.map.position, config.position_quantum),
          .force_quantum = Quantum(config.map.force, config.force_quantum),
          .simulated = false,
          .position_bits = BitsOf(config.map.position)};
}

Enabling EnablingOf(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::kAnswered:
      return Enabling::kEnabled;
    case Outcome::kException:
    case Outcome::kMalformed:
      return Enabling::kRefused;
    case Outcome::kSilent:
    case Outcome::kDisconnected:
      break;
  }
  return Enabling::kSilent;
}

}  // namespace

ModbusDrive::ModbusDrive(const ModbusDriveConfig& config) : ModbusDrive(config, NowNs) {}

ModbusDrive::ModbusDrive(const ModbusDriveConfig& config, Now now)
    : lock_(LockNameOf(config.link)), config_(config), info_(InfoOf(config)), now_(now), link_(config.link) {
  Connect();
}

ModbusDrive::~ModbusDrive() {
  reconnection_.Stop();
  Disable();
}

DriveInfo ModbusDrive::Info() const noexcept { return info_; }

Outcome ModbusDrive::Ask(const Request& request, std::span<uint16_t> words) noexcept {
  if (!reconnection_.HasLink()) {
    return Outcome::kDisconnected;
  }
  const double patience_s =
      arming_ ? std::max(config_.reply_deadline_s, kArmingPatienceS) : config_.reply_deadline_s;
  const Outcome outcome = link_.Exchange(request, words, DeadlineNs(patience_s));
  if (outcome == Outcome::kDisconnected) {
    enabled_ = false;
    reconnection_.Lose();
  }
  return outcome;
}

Outcome ModbusDrive::Put(uint16_t address, std::span<const uint16_t> words) noexcept {
  return Ask(WriteRegisters(address, words), {});
}

// F_a acts against the positive direction (eq. 1), the drive's force towards it.
ModbusDrive::Words ModbusDrive::ForceWords(int32_t force_counts) const noexcept {
  const RegisterValue& force = config_.map.force;
  return Encode(force,
                (-static_cast<double>(force_counts) * info_.force_quantum - force.offset) / force.scale);
}

Outcome ModbusDrive::PutForce(int32_t force_counts) noexcept {
  const Words words = ForceWords(force_counts);
  return Put(config_.map.force.address, std::span(words).first(config_.map.force.Registers()));
}

Outcome ModbusDrive::PutEnabled(bool enabled) noexcept {
  const auto& enable = config_.map.enable;
  if (!enable) {
    return Outcome::kAnswered;
  }
  const std::array<uint16_t, 1> word{enabled ? enable->enabled : enable->disabled};
  return Put(enable->address, word);
}

Enabling ModbusDrive::CheckWatchdog() noexcept {
  if (config_.without_watchdog) {
    return Enabling::kEnabled;
  }
  const auto& watchdog = config_.map.watchdog;
  if (!watchdog) {
    return Enabling::kNoWatchdog;
  }
  Words words{};
  const RegisterValue& timeout = watchdog->timeout;
  if (const Outcome outcome = Ask(ReadRegisters(timeout.address, timeout.Registers()), words);
      outcome != Outcome::kAnswered) {
    return EnablingOf(outcome);
  }
  const double timeout_s = Decode(timeout, words) * timeout.scale + timeout.offset;
  if (const Outcome outcome = Ask(ReadRegisters(watchdog->reaction, 1), words);
      outcome != Outcome::kAnswered) {
    return EnablingOf(outcome);
  }
  // Written so that a time-out that is no number is weak.
  const bool reacts = timeout_s > 0 && timeout_s <= kMaxWatchdogS && words[0] != watchdog->no_reaction;
  return reacts ? Enabling::kEnabled : Enabling::kNoWatchdog;
}

Enabling ModbusDrive::Arm() noexcept {
  if (const Enabling refusal = CheckWatchdog(); refusal != Enabling::kEnabled) {
    return refusal;
  }
  if (const Outcome outcome = PutForce(0); outcome != Outcome::kAnswered) {
    return EnablingOf(outcome);
  }
  return EnablingOf(PutEnabled(true));
}

Enabling ModbusDrive::Enable() noexcept {
  // A lost connection is the other thread's; a force that may be there is for Read() to take away first.
  if (!reconnection_.HasLink() || MayHoldForce()) {
    return Enabling::kSilent;
  }
  force_away_ = false;
  arming_ = true;
  const Enabling enabling = Arm();
  arming_ = false;
  enabled_ = enabling == Enabling::kEnabled;
  force_counts_ = 0;
  if (!enabled_) {
    Disable();
  }
  return enabling;
}

void ModbusDrive::Disable() noexcept {
  enabled_ = false;
  force_counts_ = 0;
  // Either one takes the force away. Where an exchange on a serial line failed before, the first is not even
  // sent (link.h), and both may stay unanswered: Read() sees to that.
  if (PutForce(0) == Outcome::kAnswered) {
    force_away_ = true;
  }
  if (config_.map.enable && PutEnabled(false) == Outcome::kAnswered) {
    force_away_ = true;
  }
  silent_until_ns_ = now_() + kSilenceNs;
}

Reading ModbusDrive::PositionOf(std::span<const uint16_t> words) const noexcept {
  const RegisterValue& position = config_.map.position;
  const double counts = (Decode(position, words) * position.scale + position.offset) / info_.position_quantum;
  // What a count in 64 bits holds; not so for what is no number.
  constexpr double kLargest = 9e18;
  if (!(std::abs(counts) < kLargest)) {
    return {};
  }
  return {.ok = true, .position_counts = static_cast<int64_t>(std::floor(counts + 0.5))};
}

Reading ModbusDrive::Read(uint64_t /*tick*/) noexcept {
  if (reconnection_.HasLink() && MayHoldForce()) {
    // Any request, even to read, would keep the drive's watchdog from taking the force away.
    if (now_() >= silent_until_ns_) {
      Disable();
    }
    return {};
  }
  const RegisterValue& position = config_.map.position;
  Words words{};
  Outcome outcome = Outcome::kSilent;
  if (config_.exchange == TickExchange::kReadWrite && enabled_) {
    const Words force = ForceWords(force_counts_);
    outcome = Ask(ReadWriteRegisters(position.address, position.Registers(), config_.map.force.address,
                                     std::span(force).first(config_.map.force.Registers())),
                  words);
  } else {
    outcome = Ask(ReadRegisters(position.address, position.Registers()), words);
  }
  answered_ = outcome == Outcome::kAnswered;
  return answered_ ? PositionOf(words) : Reading{};
}

bool ModbusDrive::Write(int32_t force_counts) noexcept {
  if (config_.exchange == TickExchange::kReadWrite) {
    force_counts_ = force_counts;
    return enabled_ && answered_;
  }
  // Not to a drive that was connected anew and that nobody has armed since.
  return enabled_ && PutForce(force_counts) == Outcome::kAnswered;
}

void ModbusDrive::Connect() {
  link_.Connect();
  TakeForceAway();
}

void ModbusDrive::TakeForceAway() {
  const Words zero = ForceWords(0);
  const auto put = [this](uint16_t address, std::span<const uint16_t> words) {
    // Nobody waits for this one: a slow drive has its time.
    constexpr double kPatienceS = 0.5;
    if (link_.Exchange(WriteRegisters(address, words), {}, DeadlineNs(kPatienceS)) != Outcome::kAnswered) {
      throw std::runtime_error(
          "Modbus drive at " + NameOf(config_.link) +
          ": it does not take a force of zero; check its unit number, the registers of its "
          "map, and that it lets this connection write");
    }
  };
  if (const auto& enable = config_.map.enable) {
    put(enable->address, std::array<uint16_t, 1>{enable->disabled});
  }
  put(config_.map.force.address, std::span(zero).first(config_.map.force.Registers()));
  force_away_ = true;
}

}  // namespace mwidth::device::modbus
