#include "server/record/session/session_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/record/session/session_reader.h"
#include "tests/server/record/session/failing_disk.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::shared_ptr<const SampleBlock> Share(std::vector<Sample> samples) {
  return std::make_shared<const SampleBlock>(std::move(samples));
}

class SessionWriterTest : public testing::Test {
 protected:
  SessionWriter Begin(uint64_t first_tick = 1, std::size_t queue_samples = 20000,
                      const std::optional<Sample>& seen = {}) {
    SessionInfo info = InfoOf(arm_.axis());
    wall_ns_ = info.start_wall_ns;
    monotonic_ns_ = info.start_monotonic_ns;
    NewSession session = store_.Create(info);
    path_ = session.path;
    return SessionWriter(
        std::move(session), first_tick, seen, queue_samples,
        [this](EventKind kind, const std::string& message, const std::map<std::string, std::string>&) {
          reported_.push_back(kind);
          messages_.push_back(message);
        },
        {.wall_ns = [this] { return wall_ns_; }, .monotonic_ns = [this] { return monotonic_ns_; }});
  }
  void Pass(int64_t ns) {
    wall_ns_ += ns;
    monotonic_ns_ += ns;
  }
  std::vector<Sample> Stored() const {
    SessionReader reader(path_);
    std::vector<Sample> all;
    std::vector<Sample> block;
    while (reader.Next(block)) {
      all.insert(all.end(), block.begin(), block.end());
    }
    EXPECT_THAT(reader.Verify(), IsEmpty());
    return all;
  }
  std::vector<Gap> LostGaps() const {
    std::vector<Gap> gaps = SessionReader(path_).Gaps();
    std::erase_if(gaps, [](const Gap& gap) { return gap.lost_ticks == 0; });
    return gaps;
  }

  TemporaryFolder folder_;
  SwingingArm arm_;
  SessionStore store_{folder_.path(), 0};
  std::filesystem::path path_;
  int64_t wall_ns_ = 0;
  int64_t monotonic_ns_ = 0;
  std::vector<EventKind> reported_;
  std::vector<std::string> messages_;
};

TEST_F(SessionWriterTest, CommitsWhatWaitsWithEachStep) {
  SessionWriter writer = Begin();
  std::vector<Sample> all;
  for (int i = 0; i < 5; ++i) {
    const std::vector<Sample> some = arm_.Take(30);
    all.insert(all.end(), some.begin(), some.end());
    writer.Offer(Share(some));
    writer.AddEvent({.number = static_cast<uint64_t>(i), .message = "", .metadata = {}});
    writer.Step();
    EXPECT_TRUE(SameSamples(Stored(), all));
    EXPECT_THAT(SessionReader(path_).Events(), SizeIs(i + 1));
    EXPECT_EQ(writer.info().sample_count, all.size());
    EXPECT_EQ(writer.info().last_tick, all.back().tick);
  }
  writer.Sync();
  Pass(5'000'000'000);
  const SessionInfo info = writer.End();
  EXPECT_EQ(info.state, SessionState::kEnded);
  EXPECT_EQ(info.end_wall_ns, wall_ns_);
  EXPECT_EQ(info.sample_count, all.size());
  EXPECT_THAT(reported_, IsEmpty());
}

TEST_F(SessionWriterTest, BeginsWithItsFirstTick) {
  SessionWriter writer = Begin(21);
  const std::vector<Sample> samples = arm_.Take(40);
  writer.Offer(Share({samples.begin(), samples.begin() + 10}));
  writer.Offer(Share({samples.begin() + 10, samples.end()}));
  writer.End();
  EXPECT_TRUE(SameSamples(Stored(), {samples.begin() + 20, samples.end()}));
  EXPECT_THAT(SessionReader(path_).Gaps(), IsEmpty());
}

TEST_F(SessionWriterTest, NotesTicksThatAreAbsentAtItsBegin) {
  const std::vector<Sample> samples = arm_.Take(60);  // ticks 52 and 53 are missed
  ASSERT_EQ(samples[50].tick, 53);
  SessionWriter writer = Begin(51, 20000, samples[49]);
  writer.Offer(Share({samples.begin() + 52, samples.end()}));
  writer.End();
  EXPECT_THAT(SessionReader(path_).Gaps(),
              ElementsAre(Gap{.after_tick = 50,
                              .before_tick = 55,
                              .missed_ticks = 2,
                              .lost_ticks = 2,
                              .reason = "the record did not keep up as the session began"}));
}

TEST_F(SessionWriterTest, DropsWhatIsTooMuchAndSaysSo) {
  SessionWriter writer = Begin(1, 100);
  const std::vector<Sample> samples = arm_.Take(250);
  writer.Offer(Share({samples.begin(), samples.begin() + 80}));
  writer.Offer(Share({samples.begin() + 80, samples.begin() + 160}));
  writer.Offer(Share({samples.begin() + 160, samples.begin() + 180}));
  writer.Step();
  writer.Offer(Share({samples.begin() + 180, samples.end()}));
  writer.Step();
  std::vector<Sample> kept(samples.begin(), samples.begin() + 80);
  kept.insert(kept.end(), samples.begin() + 160, samples.end());
  EXPECT_TRUE(SameSamples(Stored(), kept));
  ASSERT_THAT(LostGaps(), SizeIs(1));
  EXPECT_EQ(LostGaps()[0].lost_ticks, 80);
  EXPECT_EQ(LostGaps()[0].reason, "the disk did not keep up with the loop");
  EXPECT_THAT(reported_, ElementsAre(EventKind::kSamplesDropped));
}

TEST_F(SessionWriterTest, TellsOnceThatTheDiskFailsAndOnceThatItIsBack) {
  SessionWriter writer = Begin(1, 1000);
  std::vector<Sample> kept = arm_.Take(500);
  writer.Offer(Share(kept));
  writer.Step();
  uint64_t dropped = 0;
  {
    const NoFileGrows failing;
    for (int i = 0; i < 40; ++i) {
      const std::vector<Sample> some = arm_.Take(100);
      // One block was taken before the failure showed, ten wait for the disk.
      if (i < 11) {
        kept.insert(kept.end(), some.begin(), some.end());
      } else {
        dropped += some.size();
      }
      writer.Offer(Share(some));
      writer.Step();
      Pass(100'000'000);
    }
    ASSERT_THAT(reported_, ElementsAre(EventKind::kStorageFailed));
    EXPECT_THAT(messages_[0], HasSubstr("cannot be written"));
    EXPECT_EQ(SessionReader(path_).info().sample_count, 500) << "it stays readable";
  }
  Pass(SessionWriter::kRetryNs);
  writer.Step();
  EXPECT_THAT(reported_, ElementsAre(EventKind::kStorageFailed, EventKind::kStorageRestored));
  EXPECT_THAT(messages_[1], HasSubstr(std::to_string(dropped) + " samples"));
  const std::vector<Sample> after = arm_.Take(100);
  kept.insert(kept.end(), after.begin(), after.end());
  writer.Offer(Share(after));
  writer.Step();
  EXPECT_TRUE(SameSamples(Stored(), kept));
  ASSERT_THAT(LostGaps(), SizeIs(1));
  EXPECT_EQ(LostGaps()[0].before_tick, after.front().tick);
  EXPECT_EQ(writer.End().state, SessionState::kEnded);
  EXPECT_TRUE(SameSamples(Stored(), kept));
}

TEST_F(SessionWriterTest, GoesOnWithEverySampleWhereItCannotBeEndedAndEndsLater) {
  SessionWriter writer = Begin(1, 300);
  std::vector<Sample> all = arm_.Take(100);
  writer.Offer(Share(all));
  writer.Step();
  const auto offer = [&] {
    const std::vector<Sample> some = arm_.Take(100);
    all.insert(all.end(), some.begin(), some.end());
    writer.Offer(Share(some));
  };
  offer();
  const int64_t dropped = 100;
  {
    const NoFileGrows failing;
    for (int i = 0; i < 3; ++i) {
      try {
        writer.End();
        ADD_FAILURE() << "was not refused";
      } catch (const SessionRefused& refused) {
        EXPECT_EQ(refused.reason(), SessionRefusal::kStorageFailed);
        EXPECT_THAT(refused.what(), HasSubstr("end it again"));
      }
      EXPECT_EQ(SessionReader(path_).info().state, SessionState::kOpen);
      offer();
    }
    writer.Offer(Share(arm_.Take(static_cast<int>(dropped))));
    EXPECT_THROW(writer.End(), SessionRefused) << "with samples dropped behind its last";
    EXPECT_THAT(reported_, ElementsAre(EventKind::kStorageFailed)) << "told once";
  }
  Pass(SessionWriter::kRetryNs);
  writer.Step();
  EXPECT_EQ(writer.AddMarker({}).number, 1);
  const std::vector<Sample> after = arm_.Take(100);
  all.insert(all.end(), after.begin(), after.end());
  writer.Offer(Share(after));
  writer.Step();
  EXPECT_EQ(SessionReader(path_).info().state, SessionState::kOpen);
  EXPECT_EQ(writer.End().state, SessionState::kEnded);
  EXPECT_TRUE(SameSamples(Stored(), all));
  ASSERT_THAT(LostGaps(), SizeIs(1));
  EXPECT_EQ(LostGaps()[0].lost_ticks, dropped);
  EXPECT_EQ(LostGaps()[0].before_tick, after.front().tick);
}

TEST_F(SessionWriterTest, LeavesASessionThatNeverCouldBeEndedToRecovery) {
  {
    SessionWriter writer = Begin();
    writer.Offer(Share(arm_.Take(100)));
    writer.Step();
    writer.Offer(Share(arm_.Take(100)));
    const NoFileGrows failing;
    EXPECT_THROW(writer.End(), SessionRefused);
  }
  EXPECT_EQ(SessionReader(path_).info().state, SessionState::kOpen);
  EXPECT_TRUE(SessionStore::Recover(path_));
  EXPECT_EQ(SessionReader(path_).info().sample_count, 100);
}

TEST_F(SessionWriterTest, TellsEventsThatWereDroppedAlsoWithoutAFailure) {
  SessionWriter writer = Begin();
  for (std::size_t i = 0; i < SessionWriter::kQueueEntries + 3; ++i) {
    writer.AddEvent({.message = "", .metadata = {}});
  }
  writer.Step();
  ASSERT_THAT(reported_, ElementsAre(EventKind::kSamplesDropped));
  EXPECT_THAT(messages_[0], HasSubstr("lost 3 events"));
  for (std::size_t i = 0; i < SessionWriter::kQueueEntries + 1; ++i) {
    writer.AddEvent({.message = "", .metadata = {}});
  }
  writer.End();
  ASSERT_THAT(messages_, SizeIs(2));
  EXPECT_THAT(messages_[1], HasSubstr("lost 1 events"));
}

TEST_F(SessionWriterTest, NumbersMarkersAndRefusesThemWhereTooManyWait) {
  SessionWriter writer = Begin();
  for (std::size_t i = 0; i < SessionWriter::kQueueEntries; ++i) {
    ASSERT_EQ(writer.AddMarker({.label = "m", .kind = "", .metadata = {}}).number, i + 1);
  }
  EXPECT_THROW(writer.AddMarker({}), SessionRefused);
  writer.Step();
  EXPECT_EQ(writer.AddMarker({}).number, SessionWriter::kQueueEntries + 1);
  writer.End();
  EXPECT_THAT(SessionReader(path_).Markers(), SizeIs(SessionWriter::kQueueEntries + 1));
}

TEST_F(SessionWriterTest, NotesStepsOfTheWallClock) {
  SessionWriter writer = Begin();
  const int64_t offset_ns = wall_ns_ - monotonic_ns_;
  writer.Step();
  wall_ns_ += 9'000'000;
  writer.Step();
  EXPECT_THAT(reported_, IsEmpty());
  wall_ns_ += 2'000'000;
  Pass(40'000'000);
  writer.Step();
  const int64_t at_ns = monotonic_ns_;
  Pass(40'000'000);
  writer.Step();
  EXPECT_THAT(reported_, ElementsAre(EventKind::kWallClockStepped));
  EXPECT_THAT(messages_[0], HasSubstr("11 ms"));
  writer.End();
  EXPECT_THAT(SessionReader(path_).WallClockSteps(),
              ElementsAre(WallClockStep{.monotonic_ns = at_ns, .offset_ns = offset_ns + 11'000'000}));
}

}  // namespace
}  // namespace mwidth::record
