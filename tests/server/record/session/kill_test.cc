// The server may die at any moment: what it recorded stays.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <future>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "server/record/session/session_reader.h"
#include "server/record/session/session_recorder.h"
#include "server/record/session/session_store.h"
#include "tests/server/record/session/recording.h"
#include "tests/server/record/session/witness.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int kKills = 100;
// Ten a millisecond.
constexpr uint64_t kTicksIn100Ms = 1000;
constexpr uint64_t kTickNs = 100'000;
constexpr int64_t kPeriodNs = std::chrono::nanoseconds(SessionRecorder::kCommitPeriod).count();

// The clock of the recorder.
int64_t Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Killed {
  // The newest tick that it had.
  uint64_t newest = 0;
  // So many ticks passed while the host held up its commits at worst.
  uint64_t held_up = 0;
};

// Runs the recorder in `folder`, and kills it `after` it has begun to record.
Killed RecordAndKill(const std::filesystem::path& folder, int seed, std::chrono::microseconds after) {
  std::array<int, 2> out{};
  if (pipe(out.data()) != 0) {
    throw std::runtime_error("no pipe");
  }
  const std::string program = KILLED_RECORDER;
  const std::string seed_text = std::to_string(seed);
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    execl(program.c_str(), program.c_str(), folder.c_str(), seed_text.c_str(), nullptr);
    _exit(127);
  }
  close(out[1]);
  std::array<char, 9> line{};
  const bool begun = read(out[0], line.data(), line.size()) == static_cast<ssize_t>(line.size());
  std::this_thread::sleep_for(after);
  kill(child, SIGKILL);
  const int64_t killed_ns = Now();
  int status = 0;
  waitpid(child, &status, 0);
  close(out[0]);
  if (!begun || !WIFSIGNALED(status)) {
    throw std::runtime_error("the recorder did not live until it was killed");
  }
  Witness witness;
  std::ifstream(folder / "witness", std::ios::binary).read(reinterpret_cast<char*>(&witness), sizeof witness);
  // The step that it was killed in, or before, may have been late, too.
  const int64_t held_up_ns =
      std::max({int64_t{0}, witness.held_up_ns.load(), killed_ns - witness.step_ns - kPeriodNs});
  return {.newest = witness.newest_tick, .held_up = static_cast<uint64_t>(held_up_ns) / kTickNs};
}

struct Found {
  uint64_t samples = 0;
  uint64_t lost_at_the_end = 0;
  uint64_t held_up = 0;
  std::string wrong;
};

// What is left of a session of which `newest` was the newest tick.
Found Look(const std::filesystem::path& folder, uint64_t newest) {
  Found found;
  SessionStore store(folder, 0);
  const std::vector<StoredSession> sessions = store.List();
  if (sessions.size() != 1 || !sessions[0].info || sessions[0].recording) {
    found.wrong = "no session opens; ";
    return found;
  }
  const auto check = [&](SessionState state) {
    SessionReader reader(sessions[0].file);
    found.wrong += reader.info().state == state ? "" : "its state; ";
    for (const DamagedBlock& block : reader.Verify()) {
      found.wrong += block.reason + "; ";
    }
    const std::vector<Marker> markers = reader.Markers();
    for (std::size_t i = 0; i < markers.size(); ++i) {
      found.wrong += markers[i].number == i + 1 ? "" : "a marker's number; ";
    }
    std::vector<Sample> block;
    found.samples = 0;
    while (reader.Next(block)) {
      found.samples += block.size();
    }
    found.wrong += found.samples == reader.info().sample_count ? "" : "the count of samples; ";
    found.lost_at_the_end = newest > reader.info().last_tick ? newest - reader.info().last_tick : 0;
  };
  check(SessionState::kOpen);
  found.wrong += store.RecoverAll().size() == 1 ? "" : "it is not recovered; ";
  check(SessionState::kRecovered);
  return found;
}

TEST(KillTest, LosesAtMostTheLast100MillisecondsAndNothingElse) {
  std::mt19937_64 random(20261122);
  uint64_t worst = 0;
  uint64_t held_up = 0;
  uint64_t samples = 0;
  int with_blocks = 0;
  for (int i = 0; i < kKills; i += 2) {
    std::array<std::future<Found>, 2> pair;
    for (std::size_t k = 0; k < pair.size(); ++k) {
      const std::chrono::microseconds after(random() % 1'000'000);
      pair[k] = std::async(std::launch::async, [i, k, after] {
        const TemporaryFolder folder;
        const Killed killed = RecordAndKill(folder.path(), i + static_cast<int>(k), after);
        Found found = Look(folder.path(), killed.newest);
        found.held_up = killed.held_up;
        return found;
      });
    }
    for (std::future<Found>& future : pair) {
      const Found found = future.get();
      EXPECT_EQ(found.wrong, "") << "kill " << i;
      EXPECT_LE(found.lost_at_the_end, kTicksIn100Ms + found.held_up)
          << "kill " << i << ", held up by the host for " << found.held_up << " ticks";
      held_up = std::max(held_up, found.held_up);
      worst = std::max(worst, found.lost_at_the_end);
      samples += found.samples;
      with_blocks += found.samples > SessionFile::kBlockSamples ? 1 : 0;
    }
  }
  EXPECT_GT(with_blocks, kKills / 4) << "blocks and tail were both met";
  EXPECT_GT(samples, 100'000);
  RecordProperty("worst_loss_ticks", static_cast<int>(worst));
  std::printf("%d kills: at most %.1f ms lost, %llu samples kept; the host held up a commit for %.1f ms\n",
              kKills, static_cast<double>(worst) / 10, static_cast<unsigned long long>(samples),
              static_cast<double>(held_up) / 10);
}

}  // namespace
}  // namespace mwidth::record
