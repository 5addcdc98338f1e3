#include "server/record/session/unmerged_samples.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;

TEST(UnmergedSamplesTest, CutsWhereABlockIsFullOrATickIsLost) {
  SwingingArm arm;
  std::vector<Sample> samples = arm.Take(250);
  samples.erase(samples.begin() + 120, samples.begin() + 130);
  UnmergedSamples unmerged(arm.axis(), 100);
  for (const Sample& sample : samples) {
    unmerged.Push(sample);
  }
  ASSERT_EQ(unmerged.whole_blocks(), 3);
  EXPECT_EQ(unmerged.block(0).samples.size(), 100);
  EXPECT_EQ(unmerged.block(1).samples.size(), 20);
  EXPECT_EQ(unmerged.block(2).samples.size(), 100);
  EXPECT_EQ(unmerged.tail().samples.size(), 20);
  EXPECT_EQ(unmerged.pending(), 240);
  unmerged.Committed();
  EXPECT_EQ(unmerged.whole_blocks(), 0);
  EXPECT_EQ(unmerged.pending(), 0);
  EXPECT_TRUE(unmerged.tail().samples.empty());
  unmerged.Push(arm.Next());
  EXPECT_EQ(unmerged.tail().samples.size(), 1) << "the rest is in the tail already";
  unmerged.Close();
  ASSERT_EQ(unmerged.whole_blocks(), 1);
  EXPECT_EQ(unmerged.block(0).samples.size(), 21);
}

TEST(UnmergedSamplesTest, TellsOfEachBlockWhetherItsDerivedColumnsFollow) {
  SwingingArm arm;
  std::vector<Sample> samples = arm.Take(500);
  samples[150].velocity += 1e-9;  // neither it follows, nor what comes behind it
  samples[200].filter.cutoff_hz = -1;
  UnmergedSamples unmerged(arm.axis(), 100);
  SampleEncoder encoder(arm.axis());
  SampleDecoder decoder(arm.axis());
  for (const Sample& sample : samples) {
    unmerged.Push(sample);
  }
  unmerged.Close();
  const std::vector<bool> follow{true, false, false, true, true};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(unmerged.block(i).follow, follow[i]) << i;
    std::vector<Sample> read;
    decoder.Decode(encoder.Encode(unmerged.block(i), Packing::kPlain), read);
    const auto first = samples.begin() + static_cast<std::ptrdiff_t>(100 * i);
    EXPECT_TRUE(SameSamples(read, {first, first + 100})) << i;
  }
}

TEST(UnmergedSamplesTest, AgreesWithAFreshLookAtAnyPart) {
  SwingingArm arm;
  const std::vector<Sample> samples = arm.Take(3000);
  UnmergedSamples unmerged(arm.axis(), 37);
  SampleEncoder once(arm.axis());
  SampleEncoder fresh(arm.axis());
  for (const Sample& sample : samples) {
    unmerged.Push(sample);
  }
  unmerged.Close();
  for (std::size_t i = 0; i < unmerged.whole_blocks(); ++i) {
    const auto bytes = once.Encode(unmerged.block(i), Packing::kCompressed);
    const auto expected = fresh.Encode(unmerged.block(i).samples, Packing::kCompressed);
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), expected.begin(), expected.end())) << i;
  }
}

}  // namespace
}  // namespace mwidth::record
