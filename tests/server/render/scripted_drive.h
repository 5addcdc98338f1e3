// A drive that does what a test says, and remembers what was asked of it.
#pragma once

#include <cstdint>

#include "device/drive.h"

namespace mwidth::render {

class ScriptedDrive final : public device::Drive {
 public:
  device::DriveInfo Info() const noexcept override { return info; }
  device::Enabling Enable() noexcept override {
    ++enables;
    arming = accepts_enable && ticks_to_enable > 0;
    if (arming) {
      --ticks_to_enable;
      return device::Enabling::kPending;
    }
    enabled = accepts_enable;
    acting_counts = 0;
    return enabled ? device::Enabling::kEnabled : refusal;
  }
  void Disable() noexcept override {
    ++disables;
    enabled = false;
    arming = false;
    acting_counts = 0;
  }
  device::Reading Read(uint64_t) noexcept override {
    return {.ok = answers_reads,
            .position_counts = answers_reads ? position_counts : INT64_MIN,
            .trouble = trouble,
            .trouble_code = trouble_code,
            .acceleration_counts = acceleration_counts};
  }
  bool Write(int32_t force_counts) noexcept override {
    ++writes;
    last_written_counts = force_counts;
    writes_while_disabled += enabled ? 0 : 1;
    if (takes_writes && enabled) {
      acting_counts = force_counts;
    }
    return takes_writes;
  }

  // What the drive does.
  device::DriveInfo info = {.position_quantum = 1e-6, .force_quantum = 1e-3, .simulated = true};
  int64_t position_counts = 0;
  int32_t acceleration_counts = 0;
  bool answers_reads = true;
  bool takes_writes = true;
  bool accepts_enable = true;
  device::Enabling refusal = device::Enabling::kRefused;
  int ticks_to_enable = 0;
  device::DriveTrouble trouble = device::DriveTrouble::kNone;
  uint16_t trouble_code = 0;

  // What was asked of it, and the force that the motor now makes.
  bool enabled = false;
  bool arming = false;
  int32_t acting_counts = 0;
  int32_t last_written_counts = 0;
  int enables = 0;
  int disables = 0;
  int writes = 0;
  int writes_while_disabled = 0;
};

}  // namespace mwidth::render
