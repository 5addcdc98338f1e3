// A joint whose hand stays where it is.
#pragma once

#include <memory>

#include "device/emulator/joint.h"

namespace mwidth::device::emulator {

class StillHand final : public HandMotion {
 public:
  double PositionAt(double /*time_s*/) const noexcept override { return 0; }
};

/// A count of position is 0.1 mrad, one of force 10 mN m. Static stiffness: 25 N m/rad.
inline JointConfig StillJoint(double watchdog_s = 0) {
  return {.plant = {.device_mass = 0.2, .hand_damping = 1, .hand_stiffness = 25, .cutoff_hz = 10},
          .position_quantum = 1e-4,
          .force_quantum = 0.01,
          .watchdog_s = watchdog_s};
}

}  // namespace mwidth::device::emulator
