// Any bytes: samples whose block gives them back, or an error. Any samples: a block that gives them back.
#include <vector>

#include "server/record/session/sample_codec.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using mwidth::exchange::Sample;
using mwidth::fuzz::Require;
namespace record = mwidth::record;

const record::SessionAxis kAxis{.name = "elbow",
                                .rotary = true,
                                .period_s = 1e-3,
                                .position_quantum = 7e-5,
                                .force_quantum = 1e-3,
                                .acceleration_quantum = 1e-2,
                                .force_limit = 10,
                                .force_slew_limit = 100};

void RequireRoundTrip(const std::vector<Sample>& samples, record::Packing packing) {
  static record::SampleEncoder encoder(kAxis);
  static record::SampleDecoder decoder(kAxis);
  const auto bytes = encoder.Encode(samples, packing);
  std::vector<Sample> read;
  decoder.Decode(bytes, read);
  Require(read.size() == samples.size(), "as many samples");
  for (std::size_t i = 0; i < read.size(); ++i) {
    Require(read[i].tick == samples[i].tick && read[i].monotonic_ns == samples[i].monotonic_ns &&
                read[i].position_counts == samples[i].position_counts &&
                read[i].force_counts == samples[i].force_counts && read[i].state == samples[i].state &&
                read[i].missed_ticks == samples[i].missed_ticks &&
                record::SameBits(record::DerivedOf(read[i]), record::DerivedOf(samples[i])),
            "the same samples");
  }
}

void DecodeBytes(const uint8_t* data, std::size_t size) {
  static record::SampleDecoder decoder(kAxis);
  std::vector<Sample> samples;
  try {
    decoder.Decode(std::as_bytes(std::span(data, size)), samples);
  } catch (const record::BlockError&) {
    Require(samples.empty(), "no samples with an error");
    return;
  }
  RequireRoundTrip(samples, record::Packing::kPlain);
}

// A block as the server writes it, with some of its bytes replaced: gets past the head.
void DecodeDamaged(mwidth::fuzz::Input& input) {
  std::vector<Sample> samples(1 + input.Take<uint8_t>());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Sample& sample = samples[i];
    sample.tick = i + 1;
    sample.position_counts = static_cast<int64_t>(i * i);
    sample.force_counts = static_cast<int32_t>(i);
    sample.filter = {.estimator = 0, .cutoff_hz = 20};
  }
  record::SampleEncoder encoder(kAxis);
  const auto bytes = encoder.Encode(samples, record::Packing::kCompressed);
  std::vector<uint8_t> damaged(bytes.size());
  std::memcpy(damaged.data(), bytes.data(), bytes.size());
  for (int i = input.Take<uint8_t>() % 16; i > 0; --i) {
    damaged[input.Take<uint16_t>() % damaged.size()] = input.Take<uint8_t>();
  }
  DecodeBytes(damaged.data(), damaged.size());
}

void EncodeSamples(mwidth::fuzz::Input& input) {
  std::vector<Sample> samples(1 + input.Take<uint8_t>() % 64);
  uint64_t tick = 0;
  for (Sample& sample : samples) {
    tick += 1 + input.Take<uint8_t>() % 4;
    sample.tick = tick;
    sample.monotonic_ns = input.Take<int64_t>();
    sample.position_counts = input.Take<int64_t>();
    sample.acceleration_counts = input.Take<int32_t>();
    sample.force_counts = input.Take<int32_t>();
    sample.state = static_cast<mwidth::exchange::State>(input.Take<uint8_t>() % 4);
    sample.position_stale = input.Take<uint8_t>() % 2 != 0;
    sample.missed_ticks = input.Take<uint64_t>();
    sample.filter = {.estimator = input.Take<uint8_t>(), .cutoff_hz = input.Number(0, 500)};
    sample.mass = input.Number(-1, 1);
    sample.velocity = input.Number(-1, 1);
  }
  RequireRoundTrip(samples,
                   input.Take<uint8_t>() % 2 == 0 ? record::Packing::kPlain : record::Packing::kCompressed);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, std::size_t size) {
  mwidth::fuzz::Input input(data, size);
  switch (input.Take<uint8_t>() % 3) {
    case 0:
      DecodeBytes(data + (size > 0 ? 1 : 0), size > 0 ? size - 1 : 0);
      break;
    case 1:
      DecodeDamaged(input);
      break;
    default:
      EncodeSamples(input);
  }
  return 0;
}
