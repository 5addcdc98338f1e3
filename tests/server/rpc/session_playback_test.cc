#include "server/rpc/session_playback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "server/record/session/session_file.h"
#include "tests/server/record/session/recording.h"
#include "tests/support/temporary_folder.h"

namespace mwidth::rpc {
namespace {

using testing::ElementsAre;

class SessionPlaybackTest : public testing::Test {
 protected:
  static constexpr uint64_t kFirstTick = 100;

  SessionPlaybackTest() {
    for (uint64_t tick = kFirstTick; tick < kFirstTick + 10; ++tick) {
      exchange::Sample sample;
      sample.tick = tick;
      sample.monotonic_ns = At(tick);
      samples_.push_back(sample);
    }
  }

  static int64_t At(uint64_t tick) { return static_cast<int64_t>(tick) * 1'000'000; }

  void Write(const std::vector<exchange::Sample>& samples) {
    record::SessionFile file(path_, record::InfoOf(record::SwingingArm().axis()));
    file.Append(samples, "lost");
    file.Add(record::Event{
        .number = 1, .kind = record::EventKind::kMassSet, .tick = 104, .monotonic_ns = At(104) - 1});
    file.Add(record::Marker{.number = 1, .label = "before", .monotonic_ns = At(50)});
    file.Add(record::Marker{.number = 2, .label = "behind", .monotonic_ns = At(900)});
    file.End(record::SessionState::kEnded, 1);
  }

  /// "100-103", "event" and the labels of markers, in the order in which they came.
  std::vector<std::string> Played(const PlaybackRequest& request, std::size_t most = 100) {
    record::SessionReader reader(path_);
    std::vector<std::string> played;
    Play(reader, request, [&](const v1::ReadSessionResponse& record) {
      if (record.has_batch()) {
        const v1::SampleBatch& batch = record.batch();
        played.push_back(
            std::to_string(batch.first_tick()) + "-" +
            std::to_string(batch.first_tick() + static_cast<uint64_t>(batch.position_size()) - 1));
      } else {
        played.push_back(record.has_event() ? "event" : record.marker().label());
      }
      return played.size() < most;
    });
    return played;
  }

  const TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "session.sqlite";
  std::vector<exchange::Sample> samples_;
};

TEST_F(SessionPlaybackTest, PutsEventsAndMarkersWhereTheyBelong) {
  Write(samples_);
  EXPECT_THAT(Played({.max_batch = 100}), ElementsAre("before", "100-103", "event", "104-109", "behind"));
}

TEST_F(SessionPlaybackTest, KeepsBatchesWithinTheirLimit) {
  Write(samples_);
  EXPECT_THAT(Played({.max_batch = 3}),
              ElementsAre("before", "100-102", "103-103", "event", "104-106", "107-109", "behind"));
}

TEST_F(SessionPlaybackTest, PlaysThePartThatIsAskedForAndWhatBelongsToIt) {
  Write(samples_);
  EXPECT_THAT(Played({.first_tick = 102, .last_tick = 105, .max_batch = 100}),
              ElementsAre("102-103", "event", "104-105"));
  EXPECT_THAT(Played({.first_tick = 106, .max_batch = 100}), ElementsAre("106-109", "behind"));
}

TEST_F(SessionPlaybackTest, EndsABatchAtAGap) {
  samples_.erase(samples_.begin() + 6, samples_.begin() + 8);
  Write(samples_);
  EXPECT_THAT(Played({.max_batch = 100}),
              ElementsAre("before", "100-103", "event", "104-105", "108-109", "behind"));
}

TEST_F(SessionPlaybackTest, StopsWhenNobodyTakesAnyMore) {
  Write(samples_);
  EXPECT_THAT(Played({.max_batch = 3}, 2), ElementsAre("before", "100-102"));
}

}  // namespace
}  // namespace mwidth::rpc
