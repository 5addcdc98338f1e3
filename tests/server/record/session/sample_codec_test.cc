#include "server/record/session/sample_codec.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;

std::vector<std::byte> Encoded(const SessionAxis& axis, const std::vector<Sample>& samples, Packing packing) {
  SampleEncoder encoder(axis);
  const auto bytes = encoder.Encode(samples, packing);
  return {bytes.begin(), bytes.end()};
}

std::vector<Sample> Decoded(const SessionAxis& axis, const std::vector<std::byte>& block) {
  std::vector<Sample> samples;
  SampleDecoder(axis).Decode(block, samples);
  return samples;
}

TEST(SampleCodecTest, GivesBackEveryBitOfTheSamplesOfALoop) {
  SwingingArm arm;
  const std::vector<Sample> samples = arm.Take(6000);
  for (const Packing packing : {Packing::kPlain, Packing::kCompressed}) {
    EXPECT_TRUE(SameSamples(Decoded(arm.axis(), Encoded(arm.axis(), samples, packing)), samples));
  }
}

TEST(SampleCodecTest, StoresNoDerivedColumnOfALoop) {
  SwingingArm arm;
  std::vector<Sample> samples = arm.Take(4096);
  const std::size_t size = Encoded(arm.axis(), samples, Packing::kCompressed).size();
  EXPECT_LT(size, 4096 * 5);
  samples[2000].velocity += 1e-9;
  const std::vector<std::byte> foreign = Encoded(arm.axis(), samples, Packing::kCompressed);
  EXPECT_GT(foreign.size(), 4096 * 12) << "what does not follow is stored";
  EXPECT_TRUE(SameSamples(Decoded(arm.axis(), foreign), samples));
}

TEST(SampleCodecTest, BeginsAnywhere) {
  SwingingArm arm;
  const std::vector<Sample> samples = arm.Take(3000);
  SampleEncoder encoder(arm.axis());
  SampleDecoder decoder(arm.axis());
  std::vector<Sample> read;
  for (std::size_t first = 0; first < samples.size(); first += 37) {
    const std::vector<Sample> part(samples.begin() + static_cast<std::ptrdiff_t>(first), samples.end());
    const auto block = encoder.Encode(part, Packing::kCompressed);
    ASSERT_LT(block.size(), 512 + part.size() * 6) << "from " << first;
    decoder.Decode(block, read);
    ASSERT_TRUE(SameSamples(read, part)) << "from " << first;
  }
}

TEST(SampleCodecTest, GivesBackSamplesThatNoLoopWouldPost) {
  std::mt19937_64 random(11);
  const SessionAxis axis = SwingingArm().axis();
  const auto number = [&random] { return std::bit_cast<double>(random()); };
  std::vector<Sample> samples;
  uint64_t tick = 5;
  for (int i = 0; i < 500; ++i) {
    tick += 1 + random() % 3;
    samples.push_back({.tick = tick,
                       .monotonic_ns = static_cast<int64_t>(random()),
                       .position_counts = static_cast<int64_t>(random()),
                       .acceleration_counts = static_cast<int32_t>(random()),
                       .force_counts = static_cast<int32_t>(random()),
                       .state = static_cast<exchange::State>(random() % 4),
                       .saturated = random() % 2 == 0,
                       .slew_limited = random() % 2 == 0,
                       .position_stale = random() % 2 == 0,
                       .force_taken = random() % 2 == 0,
                       .missed_ticks = random(),
                       .position = number(),
                       .velocity = number(),
                       .acceleration = number(),
                       .force = number(),
                       .mass = number(),
                       .filter = {.estimator = static_cast<uint8_t>(random()), .cutoff_hz = number()},
                       .answered_tick = random(),
                       .filter_memory = {number(), number(), number()}});
  }
  samples[3].position = std::numeric_limits<double>::quiet_NaN();
  samples[4].position = -0.0;
  samples[5].position_counts = std::numeric_limits<int64_t>::min();
  samples[6].position_counts = std::numeric_limits<int64_t>::max();
  for (const Packing packing : {Packing::kPlain, Packing::kCompressed}) {
    EXPECT_TRUE(SameSamples(Decoded(axis, Encoded(axis, samples, packing)), samples));
  }
}

TEST(SampleCodecTest, GivesBackASingleSample) {
  SwingingArm arm;
  const std::vector<Sample> samples = arm.Take(1);
  EXPECT_TRUE(SameSamples(Decoded(arm.axis(), Encoded(arm.axis(), samples, Packing::kCompressed)), samples));
}

TEST(SampleCodecTest, RefusesABlockOfAnotherAxis) {
  SwingingArm arm;
  const std::vector<std::byte> block = Encoded(arm.axis(), arm.Take(100), Packing::kCompressed);
  SessionAxis other = arm.axis();
  other.position_quantum *= 1.0000001;
  EXPECT_THROW(Decoded(other, block), BlockError);
}

TEST(SampleCodecTest, RefusesEveryBlockThatIsCutShort) {
  SwingingArm arm;
  const std::vector<std::byte> block = Encoded(arm.axis(), arm.Take(300), Packing::kCompressed);
  for (std::size_t size = 0; size < block.size(); ++size) {
    const std::vector<std::byte> part(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_THROW(Decoded(arm.axis(), part), BlockError) << size;
  }
}

TEST(SampleCodecTest, TakesNoFlippedBitForWhatWasRecordedWithoutAChecksumOfTheBytes) {
  SwingingArm arm;
  const std::vector<Sample> samples = arm.Take(300);
  const std::vector<std::byte> block = Encoded(arm.axis(), samples, Packing::kCompressed);
  std::mt19937_64 random(3);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<std::byte> damaged = block;
    damaged[random() % damaged.size()] ^= std::byte{static_cast<uint8_t>(1U << random() % 8)};
    try {
      Decoded(arm.axis(), damaged);  // Any samples, or an error: no crash.
    } catch (const BlockError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(SampleCodecTest, TellsWhichSamplesCanStandInOneBlock) {
  Sample first;
  first.tick = 10;
  Sample next = first;
  next.tick = 11;
  EXPECT_TRUE(Follows(first, next));
  next.tick = 14;
  EXPECT_FALSE(Follows(first, next)) << "three ticks were lost";
  next.missed_ticks = 2;
  EXPECT_FALSE(Follows(first, next)) << "one tick was lost";
  next.missed_ticks = 3;
  EXPECT_TRUE(Follows(first, next));
  next.tick = 10;
  EXPECT_FALSE(Follows(first, next)) << "time does not stand still";
}

}  // namespace
}  // namespace mwidth::record
