// A drive without a motor: the exact model of device and hand, behind the same seam as real ones.
#pragma once

#include <cstdint>
#include <memory>
#include <variant>

#include "device/drive.h"
#include "device/hand_motion.h"
#include "server/model/accelerometer_simulation.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/loop_parameters.h"

namespace mwidth::device {

struct SimulatedDriveConfig {
  model::LoopParameters loop;
  /// Position of one encoder count and force of one force count; finite, above 0.
  double position_quantum = 0;
  double force_quantum = 0;
  /// Acceleration of one count of an accelerometer of the bandwidth loop.accelerometer_bandwidth_hz; 0: none.
  double acceleration_quantum = 0;
};

/// Steps HybridSimulation, or AccelerometerSimulation with its sensor, once per period of loop.period_s, so
/// the loop that reads it must tick at that period. The first read is time 0 of the hand. Only the quanta
/// part it from the model: no saturation, friction or noise.
class SimulatedDrive final : public Drive {
 public:
  /// Most periods that one read makes up for; after a longer gap the read fails, and the device rests at the
  /// hand from there on. Bounds the time that a read takes.
  static constexpr uint64_t kMaxGapTicks = 10'000;

  /// Throws std::runtime_error where `config` is out of range, naming the value.
  SimulatedDrive(const SimulatedDriveConfig& config, std::unique_ptr<HandMotion> hand);

  DriveInfo Info() const noexcept override;
  /// Rt.
  Enabling Enable() noexcept override;
  /// Rt.
  void Disable() noexcept override;
  /// Steps to `tick`, the force last written held. Fails after a gap that is too long, where ticks do not
  /// rise, and where position or acceleration has no count (a loop that diverged). Rt.
  Reading Read(uint64_t tick) noexcept override;
  /// While disabled takes only a force of 0. Rt.
  bool Write(int32_t force_counts) noexcept override;

 private:
  double HandAt(uint64_t tick) const noexcept;
  void Rest(uint64_t tick) noexcept;
  void Command(double force) noexcept;

  SimulatedDriveConfig config_;
  std::unique_ptr<HandMotion> hand_;
  std::variant<model::HybridSimulation, model::AccelerometerSimulation> simulation_;
  bool enabled_ = false;
  bool started_ = false;
  uint64_t first_tick_ = 0;
  uint64_t tick_ = 0;
};

}  // namespace mwidth::device
