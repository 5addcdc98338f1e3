#include "server/model/sweep_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "server/model/m_width.h"

namespace mwidth::model {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

constexpr LoopParameters kPaper{.device_mass = 0.07,
                                .device_damping = 0.005,
                                .hand_mass = 0,
                                .hand_damping = 5,
                                .hand_stiffness = 700,
                                .period_s = 1e-3,
                                .cutoff_hz = 10,
                                .delay_s = 0.4e-3};

Sweep Hands(uint32_t columns, uint32_t rows) {
  return {.loop = kPaper,
          .x = {.parameter = SweepParameter::kHandDamping, .min = 1, .max = 20, .count = columns},
          .y = SweepRange{.parameter = SweepParameter::kHandStiffness,
                          .min = 10,
                          .max = 5000,
                          .count = rows,
                          .logarithmic = true}};
}

TEST(RunSweep, HandsOverEveryRowInOrderWithTheEdgesOfComputeMWidth) {
  // More columns than one piece, and no multiple of one.
  const Sweep sweep = Hands(300, 7);
  uint32_t next = 0;
  const bool complete = RunSweep(sweep, {}, [&](const SweepRow& row) {
    EXPECT_EQ(row.row, next++);
    EXPECT_EQ(row.row_count, 7u);
    EXPECT_EQ(row.y, ValueAt(*sweep.y, row.row));
    EXPECT_EQ(row.x.size(), 300u);
    EXPECT_EQ(row.lower.size(), 300u);
    EXPECT_EQ(row.upper.size(), 300u);
    LoopParameters loop = kPaper;
    loop.hand_stiffness = row.y;
    for (uint32_t i = 0; i < row.x.size(); ++i) {
      EXPECT_EQ(row.x[i], ValueAt(sweep.x, i));
      loop.hand_damping = row.x[i];
      const MWidth m_width = ComputeMWidth(loop);
      EXPECT_EQ(row.lower[i], m_width.lower.mass);
      EXPECT_EQ(row.upper[i], m_width.upper.mass);
    }
    return true;
  });
  EXPECT_TRUE(complete);
  EXPECT_EQ(next, 7u);
}

TEST(RunSweep, GivesTheSameOnOneThread) {
  const auto edges = [](unsigned threads) {
    std::vector<double> all;
    RunSweep(Hands(50, 9), {.threads = threads, .prepare_thread = {}, .stop = {}}, [&](const SweepRow& row) {
      all.insert(all.end(), row.lower.begin(), row.lower.end());
      all.insert(all.end(), row.upper.begin(), row.upper.end());
      return true;
    });
    return all;
  };
  EXPECT_EQ(edges(1), edges(0));
}

TEST(RunSweep, HasOneRowWithoutY) {
  Sweep sweep = Hands(3, 2);
  sweep.y.reset();
  std::vector<double> upper;
  uint32_t rows = 0;
  EXPECT_TRUE(RunSweep(sweep, {}, [&](const SweepRow& row) {
    ++rows;
    EXPECT_EQ(row.row_count, 1u);
    EXPECT_EQ(row.y, 0);
    upper.assign(row.upper.begin(), row.upper.end());
    return true;
  }));
  EXPECT_EQ(rows, 1u);
  EXPECT_EQ(upper.size(), 3u);
}

TEST(RunSweep, HasNoEdgesWhereThereIsNoMWidth) {
  // Without damping nothing is stable; at 10 ms half the sample rate is below this cut-off.
  Sweep sweep = Hands(2, 2);
  sweep.loop.device_damping = 0;
  sweep.x.min = 0;
  RunSweep(sweep, {}, [](const SweepRow& row) {
    EXPECT_TRUE(std::isnan(row.lower[0]) && std::isnan(row.upper[0]));
    EXPECT_TRUE(row.lower[1] < 0 && row.upper[1] > 0);
    return true;
  });
  sweep = {.loop = kPaper,
           .x = {.parameter = SweepParameter::kPeriodS, .min = 1e-3, .max = 1e-2, .count = 2},
           .y = {}};
  sweep.loop.cutoff_hz = 100;
  RunSweep(sweep, {}, [](const SweepRow& row) {
    EXPECT_TRUE(row.lower[0] < 0 && row.upper[0] > 0);
    EXPECT_TRUE(std::isnan(row.lower[1]) && std::isnan(row.upper[1]));
    return true;
  });
}

TEST(RunSweep, EndsWhenARowIsRefused) {
  std::vector<uint32_t> rows;
  EXPECT_FALSE(RunSweep(Hands(10, 100), {}, [&](const SweepRow& row) {
    rows.push_back(row.row);
    return row.row < 2;
  }));
  EXPECT_THAT(rows, ElementsAre(0, 1, 2));
}

TEST(RunSweep, EndsWhenStoppedFromOutside) {
  std::stop_source stop;
  std::vector<uint32_t> rows;
  EXPECT_FALSE(RunSweep(Hands(10, 100), {.threads = 0, .prepare_thread = {}, .stop = stop.get_token()},
                        [&](const SweepRow& row) {
                          rows.push_back(row.row);
                          return !stop.request_stop();  // the first time
                        }));
  EXPECT_THAT(rows, ElementsAre(0));
  EXPECT_FALSE(RunSweep(Hands(10, 100), {.threads = 0, .prepare_thread = {}, .stop = stop.get_token()},
                        [](const SweepRow&) { return true; }));
}

TEST(RunSweep, WakesUpWhenStoppedWhileNoRowIsComplete) {
  std::stop_source stop;
  // The only thread stops the sweep before its first point: no row will ever be complete.
  EXPECT_FALSE(
      RunSweep(Hands(10, 100),
               {.threads = 1, .prepare_thread = [&] { stop.request_stop(); }, .stop = stop.get_token()},
               [](const SweepRow&) {
                 ADD_FAILURE() << "a row after the stop";
                 return true;
               }));
}

TEST(RunSweep, LeavesNoThreadBehindWhereTakingThrows) {
  std::atomic<int> running = 0;
  EXPECT_THROW(RunSweep(Hands(1000, 1000), {.threads = 2, .prepare_thread = [&] { ++running; }, .stop = {}},
                        [](const SweepRow&) -> bool { throw std::runtime_error("no room"); }),
               std::runtime_error);
  EXPECT_GE(running.load(), 1);  // a thread that outlived the call would write to freed memory: see asan
}

TEST(RunSweep, PreparesEveryThreadAndTakesRowsOnTheCallersOwn) {
  std::mutex mutex;
  std::set<std::thread::id> prepared;
  std::set<std::thread::id> taking;
  RunSweep(Hands(1000, 20),
           {.threads = 0,
            .prepare_thread =
                [&] {
                  const std::lock_guard lock(mutex);
                  prepared.insert(std::this_thread::get_id());
                },
            .stop = {}},
           [&](const SweepRow&) {
             taking.insert(std::this_thread::get_id());
             return true;
           });
  EXPECT_EQ(prepared.size(), std::max(1u, std::thread::hardware_concurrency()));
  EXPECT_THAT(taking, ElementsAre(std::this_thread::get_id()));
  EXPECT_THAT(prepared, Each(testing::Ne(std::this_thread::get_id())));
}

}  // namespace
}  // namespace mwidth::model
