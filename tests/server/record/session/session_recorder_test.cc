#include "server/record/session/session_recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "server/record/session/session_reader.h"
#include "tests/server/record/session/failing_disk.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::IsEmpty;
using testing::SizeIs;

int64_t Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

class SessionRecorderTest : public testing::Test {
 protected:
  SessionInfo Start(uint64_t first_tick = 1) {
    const SessionInfo info = InfoOf(arm_.axis());
    SessionLabels labels = info.labels;
    labels.run = 0;
    return recorder_.Start(labels, info.axis, info.provenance, first_tick);
  }
  std::vector<Sample> Feed(int count) {
    std::vector<Sample> samples = arm_.Take(count);
    recorder_.Consume(std::make_shared<const SampleBlock>(samples));
    return samples;
  }
  template <typename Call>
  SessionRefusal RefusalOf(const Call& call) {
    try {
      call();
    } catch (const SessionRefused& refused) {
      return refused.reason();
    }
    ADD_FAILURE() << "was not refused";
    return {};
  }

  TemporaryFolder folder_;
  SwingingArm arm_;
  SessionStore store_{folder_.path(), 0};
  std::atomic<int> reports_ = 0;
  // The clock has no memory, as seen by the session's own threads.
  std::atomic<bool> throws_ = false;
  const std::thread::id caller_ = std::this_thread::get_id();
  SessionRecorder recorder_{
      store_,
      {.queue_samples = 20000},
      [this](EventKind, const std::string&, const std::map<std::string, std::string>&) { ++reports_; },
      {.wall_ns = [] { return Now() + 1'700'000'000'000'000'000; },
       .monotonic_ns =
           [this] {
             if (throws_ && std::this_thread::get_id() != caller_) {
               throw std::bad_alloc();
             }
             return Now();
           }}};
};

TEST_F(SessionRecorderTest, RecordsFromStartToEnd) {
  Feed(10);
  EXPECT_FALSE(recorder_.Active());
  const SessionInfo started = Start(11);
  EXPECT_EQ(recorder_.Active()->id, started.id);
  const std::vector<Sample> samples = Feed(5000);
  recorder_.AddEvent({.number = 3, .message = "", .metadata = {}});
  const RecordedMarker go = recorder_.AddMarker({.label = "go", .kind = "", .metadata = {}});
  EXPECT_EQ(go.marker.number, 1);
  EXPECT_EQ(go.session_id, started.id);
  const SessionInfo ended = recorder_.End(started.id);
  EXPECT_EQ(ended.state, SessionState::kEnded);
  EXPECT_EQ(ended.sample_count, 5000);
  EXPECT_FALSE(recorder_.Active());
  SessionReader reader(*store_.PathOf(started.id));
  std::vector<Sample> all;
  std::vector<Sample> block;
  while (reader.Next(block)) {
    all.insert(all.end(), block.begin(), block.end());
  }
  EXPECT_TRUE(SameSamples(all, samples));
  EXPECT_THAT(reader.Events(), SizeIs(1));
  EXPECT_THAT(reader.Markers(), SizeIs(1));
  EXPECT_THAT(reader.Verify(), IsEmpty());
  EXPECT_EQ(reports_, 0);
  EXPECT_FALSE(store_.List()[0].recording);
}

TEST_F(SessionRecorderTest, RecordsOneSessionAtATime) {
  const SessionInfo first = Start();
  EXPECT_EQ(RefusalOf([this] { Start(); }), SessionRefusal::kSessionOpen);
  EXPECT_EQ(RefusalOf([this] { recorder_.End("another"); }), SessionRefusal::kNoSession);
  recorder_.End(first.id);
  EXPECT_EQ(RefusalOf([&] { recorder_.End(first.id); }), SessionRefusal::kNoSession);
  EXPECT_EQ(Start().labels.run, first.labels.run + 1);
}

TEST_F(SessionRecorderTest, TakesNoMarkerWithoutASession) {
  EXPECT_EQ(RefusalOf([this] { recorder_.AddMarker({}); }), SessionRefusal::kNoSession);
  recorder_.AddEvent({});
}

TEST_F(SessionRecorderTest, EndsItsSessionWhenItGoes) {
  std::filesystem::path path;
  {
    SessionRecorder other(store_, {},
                          [](EventKind, const std::string&, const std::map<std::string, std::string>&) {},
                          {.wall_ns = Now, .monotonic_ns = Now});
    const SessionInfo info = InfoOf(arm_.axis());
    path = *store_.PathOf(other.Start(info.labels, info.axis, info.provenance, 1).id);
    other.Consume(std::make_shared<const SampleBlock>(arm_.Take(100)));
  }
  EXPECT_EQ(SessionReader(path).info().state, SessionState::kEnded);
  EXPECT_EQ(SessionReader(path).info().sample_count, 100);
}

TEST_F(SessionRecorderTest, CommitsByItself) {
  const SessionInfo info = Start();
  Feed(100);
  SessionReader reader(*store_.PathOf(info.id));
  std::vector<Sample> block;
  while (!reader.Next(block)) {  // The test's own time limit ends this where nothing is ever committed.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_THAT(block, SizeIs(100));
}

TEST_F(SessionRecorderTest, IsStillRecordedAndLosesNothingWhereItCannotBeEnded) {
  const SessionInfo info = Start();
  std::vector<Sample> samples = Feed(500);
  const auto feed = [&] {
    const std::vector<Sample> some = Feed(500);
    samples.insert(samples.end(), some.begin(), some.end());
  };
  {
    const NoFileGrows failing;
    EXPECT_EQ(RefusalOf([&] { recorder_.End(info.id); }), SessionRefusal::kStorageFailed);
    ASSERT_TRUE(recorder_.Active());
    EXPECT_EQ(recorder_.Active()->id, info.id);
    feed();
    EXPECT_EQ(RefusalOf([&] { recorder_.End(info.id); }), SessionRefusal::kStorageFailed);
    EXPECT_EQ(RefusalOf([this] { Start(); }), SessionRefusal::kSessionOpen);
  }
  feed();
  EXPECT_EQ(recorder_.AddMarker({}).marker.number, 1);
  const SessionInfo ended = recorder_.End(info.id);
  EXPECT_EQ(ended.state, SessionState::kEnded);
  EXPECT_EQ(ended.sample_count, samples.size());
  EXPECT_FALSE(recorder_.Active());
  EXPECT_THAT(SessionReader(*store_.PathOf(info.id)).Verify(), IsEmpty());
}

TEST_F(SessionRecorderTest, GivesASessionUpWhereItsThreadHasNoMemoryAndRunsOn) {
  const SessionInfo info = Start();
  Feed(100);
  throws_ = true;
  while (reports_ == 0) {  // The test's own time limit ends this where nothing is told.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  throws_ = false;
  Feed(100);
  EXPECT_EQ(RefusalOf([this] { recorder_.AddMarker({}); }), SessionRefusal::kStorageFailed);
  EXPECT_EQ(RefusalOf([&] { recorder_.End(info.id); }), SessionRefusal::kStorageFailed);
  EXPECT_FALSE(recorder_.Active());
  EXPECT_EQ(Start().labels.run, info.labels.run + 1);
  EXPECT_TRUE(SessionStore::Recover(*store_.PathOf(info.id)));
}

TEST_F(SessionRecorderTest, TakesCallsFromManyThreads) {
  const SessionInfo info = Start();
  std::vector<std::jthread> callers;
  for (int i = 0; i < 3; ++i) {
    callers.emplace_back([this] {
      for (int n = 0; n < 200; ++n) {
        recorder_.AddEvent({});
        recorder_.AddMarker({});
        recorder_.Active();
        std::this_thread::yield();
      }
    });
  }
  uint64_t samples = 0;
  for (int n = 0; n < 200; ++n) {
    samples += Feed(20).size();
  }
  callers.clear();
  const SessionInfo ended = recorder_.End(info.id);
  EXPECT_EQ(ended.sample_count, samples);
  SessionReader reader(*store_.PathOf(info.id));
  EXPECT_THAT(reader.Events(), SizeIs(600));
  EXPECT_THAT(reader.Markers(), SizeIs(600));
  EXPECT_THAT(reader.Verify(), IsEmpty());
}

}  // namespace
}  // namespace mwidth::record
