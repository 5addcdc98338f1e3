#include "server/record/drain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// Keeps the blocks that it is given.
class Keeper final : public SampleSink {
 public:
  void Consume(std::shared_ptr<const SampleBlock> block) override { blocks.push_back(std::move(block)); }

  std::vector<uint64_t> Ticks() const {
    std::vector<uint64_t> ticks;
    for (const auto& block : blocks) {
      for (const exchange::Sample& sample : *block) {
        ticks.push_back(sample.tick);
      }
    }
    return ticks;
  }

  bool eager() const override { return impatient; }

  std::vector<std::shared_ptr<const SampleBlock>> blocks;
  bool impatient = false;
};

std::vector<uint64_t> Consecutive(uint64_t count) {
  std::vector<uint64_t> ticks(count);
  for (uint64_t tick = 0; tick < count; ++tick) {
    ticks[tick] = tick;
  }
  return ticks;
}

class DrainTest : public testing::Test {
 protected:
  void Push(uint64_t first_tick, uint64_t count) {
    for (uint64_t tick = first_tick; tick < first_tick + count; ++tick) {
      ring_->Push(SampleAt(tick));
    }
  }

  const std::unique_ptr<SampleRing> ring_ = std::make_unique<SampleRing>();
  Keeper keeper_;
};

TEST_F(DrainTest, HandsOnWhatIsInTheRingAsOneBlock) {
  Drain drain(*ring_, {&keeper_}, 1h);
  Push(0, 5);
  EXPECT_EQ(drain.DrainOnce(), 5);
  ASSERT_EQ(keeper_.blocks.size(), 1);
  EXPECT_THAT(keeper_.Ticks(), ElementsAre(0, 1, 2, 3, 4));
}

TEST_F(DrainTest, HandsOnNothingWhereTheRingIsEmpty) {
  Drain drain(*ring_, {&keeper_}, 1h);
  EXPECT_EQ(drain.DrainOnce(), 0);
  EXPECT_THAT(keeper_.blocks, IsEmpty());
}

TEST_F(DrainTest, SharesABlockAmongItsSinks) {
  Keeper second;
  Drain drain(*ring_, {&keeper_, &second}, 1h);
  Push(0, 5);
  drain.DrainOnce();
  EXPECT_EQ(keeper_.blocks, second.blocks);
}

TEST_F(DrainTest, CutsALongBacklogIntoBlocksOfBoundedSize) {
  Drain drain(*ring_, {&keeper_}, 1h);
  Push(0, Drain::kMaxBlockSamples + 1);
  drain.DrainOnce();
  ASSERT_EQ(keeper_.blocks.size(), 2);
  EXPECT_EQ(keeper_.blocks[0]->size(), Drain::kMaxBlockSamples);
  EXPECT_EQ(keeper_.Ticks(), Consecutive(Drain::kMaxBlockSamples + 1));
}

TEST_F(DrainTest, ReportsWhatAFullRingDropped) {
  Drain drain(*ring_, {&keeper_}, 1h);
  Push(0, exchange::kSampleRingCapacity + 3);
  EXPECT_EQ(drain.dropped(), 3);
  EXPECT_EQ(drain.DrainOnce(), exchange::kSampleRingCapacity);
  EXPECT_EQ(drain.dropped(), 3);
}

TEST_F(DrainTest, TakesOneRingfulAtMostHoweverFastTheLoopFillsIt) {
  // A sink that refills the ring stands for a loop that is faster than the drain.
  class Refill final : public SampleSink {
   public:
    explicit Refill(SampleRing& ring) : ring_(ring) {}
    void Consume(std::shared_ptr<const SampleBlock> block) override {
      for (std::size_t i = 0; i < block->size(); ++i) {
        ring_.Push(SampleAt(0));
      }
    }

   private:
    SampleRing& ring_;
  };
  Refill refill(*ring_);
  Drain drain(*ring_, {&refill}, 1h);
  Push(0, exchange::kSampleRingCapacity);
  EXPECT_EQ(drain.DrainOnce(), exchange::kSampleRingCapacity);
}

TEST_F(DrainTest, LooksHalfAsOftenWhileNoSinkIsEager) {
  Keeper second;
  const Drain drain(*ring_, {&keeper_, &second}, 5ms);
  EXPECT_EQ(drain.period(), 10ms);
  second.impatient = true;
  EXPECT_EQ(drain.period(), 5ms);
}

TEST_F(DrainTest, StopDeliversWhatIsLeft) {
  Drain drain(*ring_, {&keeper_}, 1h);
  drain.Start();
  // The thread looks once now or has looked already, and then sleeps for an hour: Stop has to wake it.
  Push(0, 10);
  drain.Stop();
  EXPECT_EQ(keeper_.Ticks(), Consecutive(10));
  Push(10, 1);
  drain.Stop();
  EXPECT_EQ(keeper_.Ticks(), Consecutive(11));
}

TEST_F(DrainTest, ItsThreadDeliversEveryTickInOrderWhileTheLoopRuns) {
  constexpr uint64_t kTicks = 50'000;
  Drain drain(*ring_, {&keeper_}, 100us);
  drain.Start();
  for (uint64_t tick = 0; tick < kTicks; ++tick) {
    while (!ring_->Push(SampleAt(tick))) {
      std::this_thread::yield();
    }
  }
  drain.Stop();
  EXPECT_EQ(keeper_.Ticks(), Consecutive(kTicks));
}

TEST_F(DrainTest, RefusesAPeriodOfZero) {
  EXPECT_THROW(Drain(*ring_, {&keeper_}, 0us), std::invalid_argument);
}

}  // namespace
}  // namespace mwidth::record
