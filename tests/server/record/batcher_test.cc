#include "server/record/batcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::ElementsAre;
using testing::SizeIs;

Cut Picked(uint32_t decimation, std::size_t max_batch) {
  return {.decimation = decimation, .max_batch = max_batch};
}

/// All batches out of `samples`, `piece` of which come together at a time; what is held back comes last.
std::vector<Batch> BatchesOf(Batcher batcher, const std::vector<Sample>& samples, std::size_t piece) {
  std::vector<Batch> batches;
  const auto keep = [&](const Batch& batch) { batches.push_back(batch); };
  for (std::size_t begin = 0; begin < samples.size(); begin += piece) {
    batcher.Take(std::span(samples).subspan(begin, std::min(piece, samples.size() - begin)), keep);
  }
  batcher.Flush(keep);
  return batches;
}

std::vector<uint64_t> Ticks(const Batch& batch) {
  std::vector<uint64_t> ticks;
  for (const Sample& sample : batch.samples) {
    ticks.push_back(sample.tick);
  }
  return ticks;
}

TEST(BatcherTest, FillsBatchesUpToTheLimit) {
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(1, 4)), *BlockOf(7, 10), 10);
  ASSERT_THAT(batches, SizeIs(3));
  EXPECT_THAT(Ticks(batches[0]), ElementsAre(7, 8, 9, 10));
  EXPECT_THAT(Ticks(batches[1]), ElementsAre(11, 12, 13, 14));
  EXPECT_THAT(Ticks(batches[2]), ElementsAre(15, 16));
  EXPECT_EQ(batches[1].first_tick, 11);
  EXPECT_EQ(batches[1].decimation, 1);
  EXPECT_EQ(batches[1].missed_ticks_before + batches[1].dropped_ticks_before, 0);
}

TEST(BatcherTest, HoldsNothingBackWhereNoBatchIsTooSmall) {
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(1, 100)), *BlockOf(0, 10), 3);
  ASSERT_THAT(batches, SizeIs(4));
  EXPECT_THAT(batches[2].samples, SizeIs(3));
  EXPECT_THAT(batches[3].samples, SizeIs(1));
}

TEST(BatcherTest, HoldsSmallBatchesBackAndEndsThemAtFixedTicks) {
  const Cut cut{.min_batch = 4, .max_batch = 4};
  const std::vector<Batch> batches = BatchesOf(Batcher(cut), *BlockOf(2, 13), 3);
  ASSERT_THAT(batches, SizeIs(4));
  EXPECT_THAT(Ticks(batches[0]), ElementsAre(2, 3));
  EXPECT_THAT(Ticks(batches[1]), ElementsAre(4, 5, 6, 7));
  EXPECT_THAT(Ticks(batches[2]), ElementsAre(8, 9, 10, 11));
  EXPECT_THAT(Ticks(batches[3]), ElementsAre(12, 13, 14));
}

TEST(BatcherTest, APhaseMovesTheEnds) {
  const Cut cut{.decimation = 10, .min_batch = 4, .max_batch = 4};
  const std::vector<Batch> batches = BatchesOf(Batcher(cut, 1), *BlockOf(0, 121), 7);
  ASSERT_THAT(batches, SizeIs(4));
  EXPECT_THAT(Ticks(batches[0]), ElementsAre(0, 10, 20));
  EXPECT_THAT(Ticks(batches[1]), ElementsAre(30, 40, 50, 60));
}

TEST(BatcherTest, WhatComesTogetherStaysTogetherUpToTheLimit) {
  const Cut cut{.min_batch = 4, .max_batch = 10};
  const std::vector<Batch> batches = BatchesOf(Batcher(cut), *BlockOf(0, 24), 22);
  ASSERT_THAT(batches, SizeIs(4));
  EXPECT_THAT(batches[0].samples, SizeIs(8));
  EXPECT_THAT(batches[1].samples, SizeIs(8));
  EXPECT_THAT(batches[2].samples, SizeIs(4));
  EXPECT_THAT(batches[3].samples, SizeIs(4));
}

TEST(BatcherTest, AGapFlushesWhatIsHeldBack) {
  const Cut cut{.min_batch = 100, .max_batch = 100};
  std::vector<Sample> samples = *BlockOf(0, 3);
  samples.push_back(SampleAt(5));
  samples.push_back(SampleAt(6));
  std::vector<Batch> batches;
  Batcher batcher(cut);
  const auto keep = [&](const Batch& batch) { batches.push_back(batch); };
  batcher.Take(samples, keep);
  ASSERT_THAT(batches, SizeIs(1));
  EXPECT_THAT(Ticks(batches[0]), ElementsAre(0, 1, 2));
  batcher.Flush(keep);
  ASSERT_THAT(batches, SizeIs(2));
  EXPECT_EQ(batches[1].dropped_ticks_before, 2);
  batcher.Flush(keep);
  EXPECT_THAT(batches, SizeIs(2));
}

TEST(BatcherTest, ExtremesAreOfTheTicksSinceTheSampleBeforeButNotAcrossAGap) {
  std::vector<Sample> samples;
  for (const auto& [tick, position] :
       {std::pair{8, 1.0}, {9, -2.0}, {10, 0.5}, {11, 3.0}, {12, 0.0}, {20, 0.25}}) {
    samples.push_back(SampleAt(static_cast<uint64_t>(tick)));
    samples.back().position = position;
  }
  const Cut cut{.decimation = 10, .reduction = Reduction::kMinMax};
  const std::vector<Batch> batches = BatchesOf(Batcher(cut), samples, 100);
  ASSERT_THAT(batches, SizeIs(2));
  ASSERT_THAT(batches[0].extremes, SizeIs(1));
  EXPECT_EQ(batches[0].extremes[0].position_min, -2);
  EXPECT_EQ(batches[0].extremes[0].position_max, 1);
  EXPECT_EQ(batches[0].samples[0].position, 0.5);
  EXPECT_EQ(batches[1].extremes[0].position_min, 0.25);
  EXPECT_EQ(batches[1].extremes[0].position_max, 0.25);
}

TEST(BatcherTest, AnAbsentTickBeginsANewBatchAndIsCounted) {
  const std::vector<Sample> samples = {SampleAt(0), SampleAt(1), SampleAt(5), SampleAt(6)};
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(1, 100)), samples, 100);
  ASSERT_THAT(batches, SizeIs(2));
  EXPECT_THAT(Ticks(batches[0]), ElementsAre(0, 1));
  EXPECT_THAT(Ticks(batches[1]), ElementsAre(5, 6));
  EXPECT_EQ(batches[1].first_tick, 5);
  EXPECT_EQ(batches[1].missed_ticks_before, 0);
  EXPECT_EQ(batches[1].dropped_ticks_before, 3);
}

TEST(BatcherTest, TellsTicksThatNeverRanFromTicksThatWereLost) {
  // 2, 3 and one of 4..7 never ran.
  const std::vector<Sample> samples = {SampleAt(1, 10), SampleAt(4, 12), SampleAt(8, 13)};
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(1, 100)), samples, 100);
  ASSERT_THAT(batches, SizeIs(3));
  EXPECT_EQ(batches[1].missed_ticks_before, 2);
  EXPECT_EQ(batches[1].dropped_ticks_before, 0);
  EXPECT_EQ(batches[2].missed_ticks_before, 1);
  EXPECT_EQ(batches[2].dropped_ticks_before, 2);
}

TEST(BatcherTest, NothingIsAbsentBeforeTheFirstSample) {
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(1, 100)), {SampleAt(1000, 44)}, 1);
  ASSERT_THAT(batches, SizeIs(1));
  EXPECT_EQ(batches[0].missed_ticks_before, 0);
  EXPECT_EQ(batches[0].dropped_ticks_before, 0);
}

TEST(BatcherTest, DecimationSelectsMultiplesWhereverTheStreamBegins) {
  for (const uint64_t first_tick : {91u, 95u, 100u}) {
    const std::vector<Batch> batches =
        BatchesOf(Batcher(Picked(10, 100)), *BlockOf(first_tick, 131 - first_tick), 1000);
    ASSERT_THAT(batches, SizeIs(1));
    EXPECT_THAT(Ticks(batches[0]), ElementsAre(100, 110, 120, 130));
    EXPECT_EQ(batches[0].decimation, 10);
  }
}

TEST(BatcherTest, TellsTicksThatAreAbsentBetweenSelectedOnes) {
  // 3 and 4 are lost, 5 never ran; 0 and 10 are there.
  std::vector<Sample> samples = *BlockOf(0, 3);
  const auto rest = BlockOf(6, 5, 1);
  samples.insert(samples.end(), rest->begin(), rest->end());
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(10, 100)), samples, 100);
  ASSERT_THAT(batches, SizeIs(2));
  EXPECT_THAT(Ticks(batches[1]), ElementsAre(10));
  EXPECT_EQ(batches[1].missed_ticks_before, 1);
  EXPECT_EQ(batches[1].dropped_ticks_before, 2);
}

TEST(BatcherTest, AddsUpGapsUntilABatchCanTellThem) {
  const std::vector<Sample> samples = {SampleAt(0), SampleAt(2), SampleAt(5), SampleAt(10)};
  const std::vector<Batch> batches = BatchesOf(Batcher(Picked(10, 100)), samples, 1);
  ASSERT_THAT(batches, SizeIs(2));
  EXPECT_EQ(batches[1].dropped_ticks_before, 1 + 2 + 4);
}

TEST(BatcherTest, RefusesDecimationOrBatchOfZero) {
  EXPECT_THROW(Batcher(Picked(0, 1)), std::invalid_argument);
  EXPECT_THROW(Batcher(Picked(1, 0)), std::invalid_argument);
  EXPECT_THROW(Batcher({.min_batch = 11, .max_batch = 10}), std::invalid_argument);
}

/// A loop that misses ticks and a record that drops them, at random; with the truth about both.
struct LoopRun {
  explicit LoopRun(std::mt19937& random) {
    std::uniform_int_distribution<int> percent(0, 99);
    const int absent_percent = percent(random) / 4;
    uint64_t missed_ticks = 0;
    for (uint64_t tick = random() % 1000; samples.size() < 500; ++tick) {
      const bool absent = percent(random) < absent_percent;
      const bool never_ran = absent && percent(random) < 50;
      missed_ticks += never_ran ? 1 : 0;
      if (!absent) {
        missed = missed_ticks;
        samples.push_back(SampleAt(tick, missed_ticks));
      }
    }
    missed -= samples.front().missed_ticks;
    dropped = samples.back().tick - samples.front().tick + 1 - samples.size() - missed;
  }

  std::vector<Sample> samples;
  // Between the first sample and the last.
  uint64_t missed = 0;
  uint64_t dropped = 0;
};

TEST(BatcherTest, AccountsForEveryTickOfRandomRunsAtFullRate) {
  std::mt19937 random(1);
  for (int run_number = 0; run_number < 200; ++run_number) {
    const LoopRun run(random);
    const std::size_t max_batch = 1 + random() % 40;
    const std::vector<Batch> batches =
        BatchesOf(Batcher({.min_batch = 1 + random() % max_batch, .max_batch = max_batch}), run.samples,
                  1 + random() % 50);
    uint64_t missed = 0;
    uint64_t dropped = 0;
    std::size_t count = 0;
    uint64_t next_tick = run.samples.front().tick;
    for (const Batch& batch : batches) {
      ASSERT_LE(batch.samples.size(), max_batch);
      ASSERT_EQ(batch.first_tick, next_tick + batch.missed_ticks_before + batch.dropped_ticks_before);
      for (std::size_t i = 0; i < batch.samples.size(); ++i, ++count) {
        ASSERT_EQ(batch.samples[i].tick, batch.first_tick + i);
        ASSERT_EQ(batch.samples[i].tick, run.samples[count].tick);
      }
      next_tick = batch.first_tick + batch.samples.size();
      missed += batch.missed_ticks_before;
      dropped += batch.dropped_ticks_before;
    }
    EXPECT_EQ(count, run.samples.size());
    EXPECT_EQ(missed, run.missed);
    EXPECT_EQ(dropped, run.dropped);
  }
}

TEST(BatcherTest, AccountsForEveryTickOfRandomRunsAtAnyDecimation) {
  std::mt19937 random(2);
  for (int run_number = 0; run_number < 200; ++run_number) {
    const LoopRun run(random);
    const auto decimation = static_cast<uint32_t>(1 + random() % 12);
    const Batcher batcher(Picked(decimation, 1 + random() % 40));
    // A last sample that is selected, so that a batch tells the gaps before it.
    std::vector<Sample> samples = run.samples;
    while (samples.back().tick % decimation != 0) {
      samples.push_back(SampleAt(samples.back().tick + 1, samples.back().missed_ticks));
    }
    std::vector<uint64_t> selected;
    for (const Sample& sample : samples) {
      if (sample.tick % decimation == 0) {
        selected.push_back(sample.tick);
      }
    }
    uint64_t missed = 0;
    uint64_t dropped = 0;
    std::vector<uint64_t> ticks;
    for (const Batch& batch : BatchesOf(batcher, samples, 1 + random() % 50)) {
      for (std::size_t i = 0; i < batch.samples.size(); ++i) {
        ASSERT_EQ(batch.samples[i].tick, batch.first_tick + i * decimation);
        ticks.push_back(batch.samples[i].tick);
      }
      missed += batch.missed_ticks_before;
      dropped += batch.dropped_ticks_before;
    }
    EXPECT_EQ(ticks, selected);
    EXPECT_EQ(missed, run.missed);
    EXPECT_EQ(dropped, run.dropped);
  }
}

}  // namespace
}  // namespace mwidth::record
