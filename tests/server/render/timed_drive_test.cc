#include "server/render/timed_drive.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/server/render/scripted_drive.h"

namespace mwidth::render {
namespace {

class HandClock final : public exchange::Clock {
 public:
  int64_t NowNs() const noexcept override { return now_ns; }
  void SleepUntilNs(int64_t deadline_ns) noexcept override { now_ns = deadline_ns; }
  int64_t now_ns = 1'000'000;
};

// Each call takes the time that the test says.
class SlowDrive final : public device::Drive {
 public:
  explicit SlowDrive(HandClock& clock) : clock_(clock) {}
  device::DriveInfo Info() const noexcept override { return drive.Info(); }
  device::Enabling Enable() noexcept override {
    clock_.now_ns += 1000;
    return drive.Enable();
  }
  void Disable() noexcept override {
    clock_.now_ns += 500;
    drive.Disable();
  }
  device::Reading Read(uint64_t tick) noexcept override {
    clock_.now_ns += 70;
    return drive.Read(tick);
  }
  bool Write(int32_t force_counts) noexcept override {
    clock_.now_ns += 30;
    return drive.Write(force_counts);
  }
  ScriptedDrive drive;

 private:
  HandClock& clock_;
};

class TimedDriveTest : public testing::Test {
 protected:
  DriveTimes ReadAndWriteAfter(int64_t compute_ns) {
    timed.Read(1);
    clock.now_ns += compute_ns;
    timed.Write(3);
    clock.now_ns += 10'000;
    return timed.TakeTimes();
  }

  HandClock clock;
  SlowDrive slow{clock};
  TimedDrive timed{slow, clock};
};

TEST_F(TimedDriveTest, MeasuresTheCallsAndTheDelayAcrossThem) {
  timed.Enable();
  timed.TakeTimes();
  const DriveTimes times = ReadAndWriteAfter(400);
  EXPECT_EQ(times.io_ns, 70 + 30);
  EXPECT_EQ(times.loop_delay_ns, 70 + 400 + 30);
  EXPECT_EQ(slow.drive.last_written_counts, 3);
}

TEST_F(TimedDriveTest, CountsEnablingAndDisablingAsCalls) {
  EXPECT_EQ(timed.Enable(), device::Enabling::kEnabled);
  timed.Disable();
  EXPECT_EQ(timed.TakeTimes().io_ns, 1500);
  EXPECT_EQ(slow.drive.enables, 1);
  EXPECT_EQ(slow.drive.disables, 1);
}

TEST_F(TimedDriveTest, KnowsNoDelayWhereTheDriveWasSilentOrTookNoForce) {
  slow.drive.answers_reads = false;
  EXPECT_FALSE(ReadAndWriteAfter(400).loop_delay_ns);
  slow.drive.answers_reads = true;
  slow.drive.takes_writes = false;
  EXPECT_FALSE(ReadAndWriteAfter(400).loop_delay_ns);
  slow.drive.takes_writes = true;
  EXPECT_TRUE(ReadAndWriteAfter(400).loop_delay_ns);
}

TEST_F(TimedDriveTest, DoesNotCarryASampleIntoTheNextTick) {
  timed.Read(1);
  timed.TakeTimes();
  timed.Write(0);
  EXPECT_FALSE(timed.TakeTimes().loop_delay_ns);
}

TEST_F(TimedDriveTest, PassesTheDriveOnAsItIs) {
  EXPECT_EQ(timed.Info().position_quantum, slow.drive.info.position_quantum);
  slow.drive.position_counts = 17;
  EXPECT_EQ(timed.Read(1).position_counts, 17);
  slow.drive.accepts_enable = false;
  EXPECT_EQ(timed.Enable(), device::Enabling::kRefused);
  slow.drive.takes_writes = false;
  EXPECT_FALSE(timed.Write(1));
}

}  // namespace
}  // namespace mwidth::render
