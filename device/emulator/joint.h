// The joint of an emulated drive: device, hand and motor in real time, and the watchdog of the drive.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>

#include "device/hand_motion.h"
#include "device/simulated_drive.h"
#include "server/model/loop_parameters.h"

namespace mwidth::device::emulator {

/// What a drive can be made to do wrong with its encoder.
enum class EncoderFault : uint8_t { kNone, kFrozen };

struct JointConfig {
  /// Device and hand; the rest does not count.
  model::LoopParameters plant;
  double position_quantum = 0;
  double force_quantum = 0;
  /// Time without any request after which the motor is disabled by itself, s; 0: never.
  double watchdog_s = 0;
};

/// What watchdogs did.
struct Trips {
  int count = 0;
  /// How long after the last sign of life the last one took the force away, s.
  double after_s = 0;
};

/// Advances by the time of CLOCK_MONOTONIC whenever it is asked, in steps of kStepS, exactly: between two
/// requests the force does not change, so nothing is lost by computing late. Any thread.
class Joint {
 public:
  static constexpr double kStepS = 1e-4;

  /// Throws std::runtime_error where `config` is out of range.
  Joint(const JointConfig& config, std::unique_ptr<HandMotion> hand);

  /// The encoder at `now_ns`.
  int64_t PositionCounts(int64_t now_ns);
  /// The motor's force, positive towards rising positions. Without effect while disabled.
  void SetForce(int64_t now_ns, int32_t counts);
  void SetEnabled(int64_t now_ns, bool enabled);
  bool enabled() const;
  /// The force that acts; 0 while disabled.
  int32_t force_counts() const;
  double watchdog_s() const { return config_.watchdog_s; }
  /// Every request restarts the watchdog.
  void Feed(int64_t now_ns);
  /// Lets time pass, and the watchdog act: on its time-out, however late this is called. To be called every
  /// few milliseconds.
  void Turn(int64_t now_ns);
  /// What a watchdog does: takes the force away at `now_ns`, `after_s` after the last sign of life.
  void Trip(int64_t now_ns, double after_s);
  Trips trips() const;

  /// From now on.
  void SetEncoderFault(EncoderFault fault);
  /// Adds to every position from now on.
  void JumpEncoder(int64_t counts);

 private:
  // All hold mutex_.
  void AdvanceTo(int64_t now_ns);
  void Switch(bool enabled);
  void TripAt(int64_t now_ns, double after_s);

  const JointConfig config_;
  mutable std::mutex mutex_;
  SimulatedDrive simulation_;
  int64_t start_ns_ = 0;
  uint64_t step_ = 0;
  int64_t fed_ns_ = 0;
  Trips trips_;
  bool enabled_ = false;
  int32_t force_counts_ = 0;
  int64_t position_counts_ = 0;
  int64_t shown_counts_ = 0;
  int64_t jump_counts_ = 0;
  EncoderFault encoder_fault_ = EncoderFault::kNone;
};

}  // namespace mwidth::device::emulator
