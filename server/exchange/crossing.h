// What crosses between the loop and the rest of the server: settings in; status, samples and statistics out.
#pragma once

#include <array>
#include <cstdint>

#include "server/exchange/mailbox.h"
#include "server/exchange/ring.h"
#include "server/exchange/tick_statistics.h"

namespace mwidth::exchange {

enum class State : uint8_t { kIdle, kReady, kRendering, kFault };

enum class Fault : uint8_t {
  kNone,
  kEmergencyStop,
  kDriveSilent,
  kNotFinite,
  kPositionLimit,
  kVelocityLimit,
  kOverrun,
  kDriveRefused,
  kNoDriveWatchdog,
  kForeignTraffic,
  kDriveError,
  kForceSaturation,
  kForceSlew,
  kEncoderJump,
  kEncoderFreeze,
  kAccelerometer,
  kRepeatedOverrun,
  kLoopDelay,
  kPositionGaps,
  kGrowingOscillation,
  kEnergyExcess,
};

/// Which estimator of acceleration a loop runs.
struct Filter {
  /// A model::EstimatorKind, as a number: this folder knows no model.
  uint8_t estimator = 0;
  /// Its cut-off; 0 where none was asked for, which leaves the loop its configured filter.
  double cutoff_hz = 0;

  bool operator==(const Filter&) const = default;
};

/// What the gate wants of the loop. Posted whole; the newest wins, so anything that must not be missed is a
/// counter or a number that only grows, never an edge.
struct Settings {
  /// Grows by one with every post; the loop answers with LoopStatus::settings_sequence.
  uint64_t sequence = 0;
  /// The loop renders while this is true, and begins only when render_epoch has grown since it last began: a
  /// fault or a lost lease ends rendering, and only a new StartRendering begins it again.
  bool rendering = false;
  uint64_t render_epoch = 0;
  /// Admitted virtual mass, and the time of the ramp to it.
  double mass = 0;
  double ramp_s = 0.2;
  /// What `mass` is admitted for. A loop that runs another filter renders no mass but on the way to zero,
  /// changes, and only then goes to `mass`.
  Filter filter{};
  /// How the loop with `filter` oscillates at the negative edge of what is certified; 0: not known, and the
  /// hand is not watched.
  double critical_hz = 0;
  /// Dead man: past this time of the axis's clock the loop ramps the mass to zero and goes to READY.
  int64_t lease_deadline_ns = 0;
  /// Grows with every emergency stop.
  uint64_t emergency_stops = 0;
  /// Faults up to this number are cleared; a later one stays latched.
  uint64_t cleared_fault_number = 0;
};

/// The fault that is latched, and its figures.
struct FaultRecord {
  Fault fault = Fault::kNone;
  /// Counts the faults since the start.
  uint64_t number = 0;
  uint64_t tick = 0;
  /// What was seen, and the limit that it was held against.
  double value = 0;
  double limit = 0;
};

/// What the loop last did; posted every tick.
struct LoopStatus {
  uint64_t settings_sequence = 0;
  uint64_t tick = 0;
  int64_t monotonic_ns = 0;
  State state = State::kIdle;
  FaultRecord fault;
  /// The render_epoch that last began, and how often rendering has ended for any reason.
  uint64_t render_epoch = 0;
  uint64_t renderings_ended = 0;
  double position = 0;
  double velocity = 0;
  double force = 0;
  double mass = 0;
  double target_mass = 0;
  /// What estimates the next acceleration.
  Filter filter{};
  uint64_t missed_ticks = 0;
  /// Ticks since the start whose force the force limit, and the slew limit, clamped.
  uint64_t saturated_ticks = 0;
  uint64_t slew_limited_ticks = 0;
};

/// One tick. Force is the paper's F_a (eq. 5): it acts on the device against the positive direction.
struct Sample {
  uint64_t tick = 0;
  int64_t monotonic_ns = 0;
  int64_t position_counts = 0;
  /// What the accelerometer told with the position; 0 without one.
  int32_t acceleration_counts = 0;
  int32_t force_counts = 0;
  State state = State::kIdle;
  /// The force is not M a_hat: the force limit, or the limit on its change, clamped it.
  bool saturated = false;
  bool slew_limited = false;
  /// The drive did not answer: position, velocity and acceleration are the last ones known.
  bool position_stale = false;
  /// The drive was enabled and took the force.
  bool force_taken = false;
  /// Ticks skipped since the start, this one's predecessors included.
  uint64_t missed_ticks = 0;
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
  double force = 0;
  double mass = 0;
  /// What estimated the acceleration.
  Filter filter{};
  /// The newest tick whose position is not stale, this one included; 0: none yet. Ticks count from 1.
  uint64_t answered_tick = 0;
  /// What the filter goes on from, beside `acceleration`: model::LowPassMemory. With it the samples after
  /// this one can be computed again without those before.
  std::array<double, 3> filter_memory{};
};

/// About 4 s of samples at 1 kHz: what the record may lag behind before samples are dropped, and counted.
inline constexpr std::size_t kSampleRingCapacity = 4096;

/// All that one axis's loop shares with the rest of the server.
struct Crossing {
  Mailbox<Settings> settings;
  Mailbox<LoopStatus> status;
  Ring<Sample, kSampleRingCapacity> samples;
  TickStatistics tick_statistics;
};

}  // namespace mwidth::exchange
