// How long something took, over very many times: a histogram that one thread fills and any thread reads.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace mwidth::exchange {

/// Order statistics of durations; all 0 where none was recorded. A percentile p is a duration that at least
/// that share of the recorded ones does not exceed: the upper end of its bucket, so never too small, and at
/// most 1/64 too large.
struct DurationFigures {
  uint64_t count = 0;
  int64_t min_ns = 0;
  int64_t p50_ns = 0;
  int64_t p99_ns = 0;
  int64_t p999_ns = 0;
  int64_t max_ns = 0;
};

/// Histogram of durations with a fixed relative resolution (log-linear buckets, as in HdrHistogram): exact
/// below 128 ns, then 64 buckets to every doubling, up to 69 s; the last one holds
/// what is longer, and ends at the longest. Lock-free,
/// wait-free, no allocation, no pointer inside, 16 KiB. One thread records.
///
/// What a reader sees: every duration whose Record returned before Figures was called (and happens before
/// it), and any of those recorded meanwhile. The percentiles are of one set of durations; min and max may
/// already know of a newer one.
class DurationHistogram {
 public:
  /// A negative duration counts as 0. Writer only. Rt.
  void Record(int64_t duration_ns) noexcept {
    const int64_t ns = std::max<int64_t>(0, duration_ns);
    // One writer: nobody else changes what was just loaded, so no read-modify-write is needed.
    Add(buckets_[BucketOf(ns)], 1);
    if (ns < min_ns_.load(std::memory_order_relaxed)) {
      min_ns_.store(ns, std::memory_order_relaxed);
    }
    if (ns > max_ns_.load(std::memory_order_relaxed)) {
      max_ns_.store(ns, std::memory_order_relaxed);
    }
  }

  /// Of everything since construction; there is no reset, which would take the history from every other
  /// reader. Any thread.
  DurationFigures Figures() const noexcept {
    std::array<uint64_t, kBuckets> counts{};
    uint64_t count = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      counts[i] = buckets_[i].load(std::memory_order_relaxed);
      count += counts[i];
    }
    if (count == 0) {
      return {};
    }
    const int64_t max_ns = max_ns_.load(std::memory_order_relaxed);
    const auto percentile = [&counts, count, max_ns](uint64_t per_mille) {
      return std::min(max_ns, UpperEnd(counts, RankOf(count, per_mille)));
    };
    return {.count = count,
            .min_ns = min_ns_.load(std::memory_order_relaxed),
            .p50_ns = percentile(500),
            .p99_ns = percentile(990),
            .p999_ns = percentile(999),
            .max_ns = max_ns};
  }

 private:
  static constexpr unsigned kResolutionBits = 6;
  static constexpr unsigned kRangeBits = 36;
  static constexpr std::size_t kBuckets = (kRangeBits - kResolutionBits + 1) << kResolutionBits;
  static_assert(std::atomic<uint64_t>::is_always_lock_free);

  static void Add(std::atomic<uint64_t>& counter, uint64_t more) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  }

  // Below 2^(kResolutionBits + 1) a bucket holds one value; above, the leading kResolutionBits + 1 bits
  // count.
  static std::size_t BucketOf(int64_t duration_ns) noexcept {
    const uint64_t ns = std::min<uint64_t>(static_cast<uint64_t>(duration_ns), (1ULL << kRangeBits) - 1);
    const unsigned leading_bits = kResolutionBits + 1;
    const unsigned shift = std::max(static_cast<unsigned>(std::bit_width(ns)), leading_bits) - leading_bits;
    return (static_cast<std::size_t>(shift) << kResolutionBits) + static_cast<std::size_t>(ns >> shift);
  }

  // How many durations are at or below the percentile: rounded up, at least one.
  static uint64_t RankOf(uint64_t count, uint64_t per_mille) noexcept {
    return std::max<uint64_t>(1, count / 1000 * per_mille + (count % 1000 * per_mille + 999) / 1000);
  }

  static int64_t UpperEnd(const std::array<uint64_t, kBuckets>& counts, uint64_t rank) noexcept {
    std::size_t bucket = 0;
    for (uint64_t below = counts[0]; below < rank; below += counts[bucket]) {
      ++bucket;
    }
    if (bucket == kBuckets - 1) {
      return INT64_MAX;
    }
    const std::size_t octave = bucket >> kResolutionBits;
    const unsigned shift = octave > 1 ? static_cast<unsigned>(octave) - 1 : 0;
    const std::size_t leading = bucket - (static_cast<std::size_t>(shift) << kResolutionBits);
    return static_cast<int64_t>(((leading + 1) << shift) - 1);
  }

  std::array<std::atomic<uint64_t>, kBuckets> buckets_{};
  std::atomic<int64_t> min_ns_{INT64_MAX};
  std::atomic<int64_t> max_ns_{0};
};

}  // namespace mwidth::exchange
