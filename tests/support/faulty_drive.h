// A drive that fails on demand, around one that works: what cables, encoders and power stages do to the loop.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "device/drive.h"

namespace mwidth::device {

/// Passes everything on to another drive, except for the faults set. Set them from the loop's thread or
/// before it.
class FaultyDrive final : public Drive {
 public:
  explicit FaultyDrive(std::unique_ptr<Drive> drive) : drive_(std::move(drive)) {}

  /// The next `reads` reads get no answer; the device moves on meanwhile.
  void SilenceReads(uint64_t reads) { silent_reads_ = reads; }
  /// From the next read on the encoder is off by `counts` more.
  void Jump(int64_t counts) { offset_counts_ += counts; }
  /// While set, reads repeat the last position as if it were fresh.
  void Freeze(bool frozen) { frozen_ = frozen; }
  void RefuseEnable(bool refused) { enable_refused_ = refused; }
  /// The next `writes` writes are not taken; the force before them goes on.
  void RefuseWrites(uint64_t writes) { refused_writes_ = writes; }

  DriveInfo Info() const noexcept override { return drive_->Info(); }
  Enabling Enable() noexcept override { return enable_refused_ ? Enabling::kRefused : drive_->Enable(); }
  void Disable() noexcept override { drive_->Disable(); }

  Reading Read(uint64_t tick) noexcept override {
    Reading reading = drive_->Read(tick);
    reading.position_counts += offset_counts_;
    if (silent_reads_ > 0) {
      --silent_reads_;
      return {};
    }
    if (!frozen_) {
      last_ = reading;
    }
    return last_;
  }

  bool Write(int32_t force_counts) noexcept override {
    if (refused_writes_ > 0) {
      --refused_writes_;
      return false;
    }
    return drive_->Write(force_counts);
  }

 private:
  std::unique_ptr<Drive> drive_;
  Reading last_;
  uint64_t silent_reads_ = 0;
  uint64_t refused_writes_ = 0;
  int64_t offset_counts_ = 0;
  bool frozen_ = false;
  bool enable_refused_ = false;
};

}  // namespace mwidth::device
