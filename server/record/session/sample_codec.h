// Blocks of samples as bytes, and back, to the bit. The format is in README.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/session/derived_columns.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// Bytes that are no block of this format, or one that was damaged. what() says how that shows.
class BlockError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The most samples of one block, so that a damaged count cannot ask for much memory.
inline constexpr std::size_t kMaxBlockSamples = 65536;

/// True where `next` can stand behind `previous` in one block: every tick between them was missed.
inline bool Follows(const exchange::Sample& previous, const exchange::Sample& next) noexcept {
  return next.tick - previous.tick - 1 <= next.missed_ticks - previous.missed_ticks;
}

/// The period as blocks reckon with it: whole nanoseconds, or 0 where it is no period.
uint64_t PeriodNs(const SessionAxis& axis) noexcept;

/// XXH3, 64 bits.
uint64_t Checksum(std::span<const std::byte> bytes) noexcept;

/// How the bytes of a block's columns are kept.
enum class Packing : uint8_t {
  /// As they are, for blocks so small that a compressor takes longer than it saves.
  kPlain,
  /// By zstd.
  kCompressed,
};

/// Samples of one block, their derived columns, and whether those of all but the first follow from the sample
/// before.
struct CheckedSamples {
  std::span<const exchange::Sample> samples;
  std::span<const DerivedColumns> derived;
  bool follow = false;
};

/// Keeps its buffers from call to call. One thread.
class SampleEncoder {
 public:
  explicit SampleEncoder(const SessionAxis& axis);
  SampleEncoder(SampleEncoder&&) noexcept;
  SampleEncoder& operator=(SampleEncoder&&) noexcept;
  ~SampleEncoder();

  /// The bytes of `samples`, valid until the next call. Derived columns are left out where they follow from
  /// the rest, as those of render::Tick do, and stored in full where they do not. Precondition: 1 to
  /// kMaxBlockSamples samples; each Follows the one before.
  std::span<const std::byte> Encode(std::span<const exchange::Sample> samples, Packing packing);
  /// The same, of samples whose derived columns were looked at before.
  std::span<const std::byte> Encode(const CheckedSamples& samples, Packing packing);

 private:
  class Planes;
  std::unique_ptr<Planes> planes_;
};

/// One thread.
class SampleDecoder {
 public:
  explicit SampleDecoder(const SessionAxis& axis);
  SampleDecoder(SampleDecoder&&) noexcept;
  SampleDecoder& operator=(SampleDecoder&&) noexcept;
  ~SampleDecoder();

  /// Replaces `samples` by those of a block, ticks rising strictly. Any bytes give samples or a BlockError,
  /// and then `samples` is empty.
  void Decode(std::span<const std::byte> block, std::vector<exchange::Sample>& samples);

 private:
  class Planes;
  std::unique_ptr<Planes> planes_;
};

}  // namespace mwidth::record
