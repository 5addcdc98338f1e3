// The seam between the loop and a motor with an encoder, and perhaps an accelerometer.
#pragma once

#include <cstdint>

namespace mwidth::device {

/// Fixed properties of a drive, known before the loop starts. Linear: m, N; rotary: rad, N m.
struct DriveInfo {
  /// Position of one encoder count; above 0.
  double position_quantum = 0;
  /// Force of one force count; above 0.
  double force_quantum = 0;
  /// True where no motor can move: a simulation.
  bool simulated = false;
  /// Width of the counter that position_counts comes from, 8 to 64: a counter of fewer than 64 bits wraps.
  int position_bits = 64;
  /// Acceleration of one count of the accelerometer, above 0, and its first-order bandwidth (accelerometer.h
  /// of the model); 0 where there is none.
  double acceleration_quantum = 0;
  double accelerometer_bandwidth_hz = 0;

  bool senses_acceleration() const noexcept { return acceleration_quantum > 0; }
};

/// Longest time after which a drive must take the force away by itself when nobody speaks to it, s.
inline constexpr double kMaxWatchdogS = 0.1;

/// What a drive answers to being enabled.
enum class Enabling : uint8_t {
  kEnabled,
  /// It is on its way, without a force: ask again in the next tick, or disable it.
  kPending,
  /// It does not want to, or answers something that nobody understands.
  kRefused,
  /// It does not answer.
  kSilent,
  /// It would hold its last force for ever, or too long, if nobody spoke to it any more.
  kNoWatchdog,
  /// Somebody else commands it.
  kForeignTraffic,
};

/// What is wrong with a drive that is enabled.
enum class DriveTrouble : uint8_t {
  kNone,
  /// It reports an error, or has stopped following by itself.
  kError,
  /// Somebody else commands it.
  kForeignTraffic,
};

/// What a drive answers to a read.
struct Reading {
  /// False when the drive did not answer with a fresh position; then position_counts means nothing.
  bool ok = false;
  /// As the counter has it: the loop makes the counts continuous where the counter wraps (position_bits; the
  /// bits above them do not count).
  int64_t position_counts = 0;
  /// Also where the position is not ok; kNone while the drive is not enabled.
  DriveTrouble trouble = DriveTrouble::kNone;
  /// The drive's own number of its error, or the identifier of the foreign frame; 0 where there is none.
  uint16_t trouble_code = 0;
  /// What the accelerometer told with that position; 0 without one.
  int32_t acceleration_counts = 0;
};

/// One motor with an encoder. All functions are called by the loop's thread and are Rt, except the
/// constructors of the implementations, which throw std::runtime_error with what to do when the drive cannot
/// be reached. An implementation with a motor holds a DriveLock from before it touches the link to the end.
class Drive {
 public:
  Drive() = default;
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;
  virtual ~Drive() = default;

  virtual DriveInfo Info() const noexcept = 0;
  /// Lets the motor follow force commands, at zero force. Rt.
  virtual Enabling Enable() noexcept = 0;
  /// Takes the force away. Always succeeds as far as the caller can do anything about it. Rt.
  virtual void Disable() noexcept = 0;
  /// Samples the position at the start of `tick`. Ticks rise by one, or by more where the loop missed
  /// deadlines; the force last written has acted since. Rt.
  virtual Reading Read(uint64_t tick) noexcept = 0;
  /// Commands a force until the next write: counts of the paper's F_a, which acts against the positive
  /// direction. False when the drive did not take it. Rt.
  virtual bool Write(int32_t force_counts) noexcept = 0;
};

}  // namespace mwidth::device
