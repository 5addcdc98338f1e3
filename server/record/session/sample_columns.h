// The columns of a block of samples, each as whole numbers of 64 bits that differ little from row to row.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "server/exchange/crossing.h"

namespace mwidth::record {

/// How many columns a block has: those that are stored, and those that follow from them and are stored only
/// where they do not.
inline constexpr unsigned kStoredColumns = 10;
inline constexpr unsigned kDerivedColumns = 8;
inline constexpr unsigned kColumns = kStoredColumns + kDerivedColumns;

inline constexpr uint8_t kSaturatedBit = 1;
inline constexpr uint8_t kSlewLimitedBit = 2;
inline constexpr uint8_t kStaleBit = 4;
inline constexpr uint8_t kForceTakenBit = 8;

/// State in the low byte, what is true or false above.
inline uint64_t PackFlags(const exchange::Sample& sample) noexcept {
  const unsigned flags =
      (sample.saturated ? kSaturatedBit : 0U) | (sample.slew_limited ? kSlewLimitedBit : 0U) |
      (sample.position_stale ? kStaleBit : 0U) | (sample.force_taken ? kForceTakenBit : 0U);
  return static_cast<uint64_t>(sample.state) | uint64_t{flags} << 8U;
}

inline bool UnpackFlags(uint64_t packed, exchange::Sample& sample) noexcept {
  const uint64_t flags = packed >> 8U;
  sample.state = static_cast<exchange::State>(packed & 0xFFU);
  sample.saturated = (flags & kSaturatedBit) != 0;
  sample.slew_limited = (flags & kSlewLimitedBit) != 0;
  sample.position_stale = (flags & kStaleBit) != 0;
  sample.force_taken = (flags & kForceTakenBit) != 0;
  return flags < 16 && sample.state <= exchange::State::kFault;
}

/// False where a number is none of the type's.
template <typename Integer>
bool Narrow(uint64_t value, Integer& out) noexcept {
  const auto wide = static_cast<int64_t>(value);
  out = static_cast<Integer>(wide);
  return wide >= std::numeric_limits<Integer>::min() && wide <= std::numeric_limits<Integer>::max();
}

inline uint64_t Bits(double value) noexcept { return std::bit_cast<uint64_t>(value); }
inline bool FromBits(uint64_t bits, double& out) noexcept {
  out = std::bit_cast<double>(bits);
  return true;
}

/// Calls visit(order, get, set) for each stored column in the file's order. get(sample, index) is the number
/// of row `index`, set(number, index, sample) puts it back and is false where it can be none; `order` is how
/// often differences from row to row are taken. Ticks are told as what they are beyond their index, times as
/// what they are beyond tick * period_ns: both stand still while no deadline is missed and the loop wakes in
/// time. Arithmetic is modulo 2^64 throughout, so that any sample survives. A set may use the columns before.
template <typename Visit>
void ForEachStoredColumn(uint64_t period_ns, const Visit& visit) {
  using exchange::Sample;
  visit(
      1, [](const Sample& s, uint64_t index) { return s.tick - index; },
      [](uint64_t value, uint64_t index, Sample& s) {
        s.tick = value + index;
        return true;
      });
  visit(
      0,
      [period_ns](const Sample& s, uint64_t) {
        return static_cast<uint64_t>(s.monotonic_ns) - s.tick * period_ns;
      },
      [period_ns](uint64_t value, uint64_t, Sample& s) {
        s.monotonic_ns = static_cast<int64_t>(value + s.tick * period_ns);
        return true;
      });
  visit(
      2, [](const Sample& s, uint64_t) { return static_cast<uint64_t>(s.position_counts); },
      [](uint64_t value, uint64_t, Sample& s) {
        s.position_counts = static_cast<int64_t>(value);
        return true;
      });
  visit(
      1, [](const Sample& s, uint64_t) { return static_cast<uint64_t>(int64_t{s.acceleration_counts}); },
      [](uint64_t value, uint64_t, Sample& s) { return Narrow(value, s.acceleration_counts); });
  visit(
      2, [](const Sample& s, uint64_t) { return static_cast<uint64_t>(int64_t{s.force_counts}); },
      [](uint64_t value, uint64_t, Sample& s) { return Narrow(value, s.force_counts); });
  visit(
      1, [](const Sample& s, uint64_t) { return PackFlags(s); },
      [](uint64_t value, uint64_t, Sample& s) { return UnpackFlags(value, s); });
  visit(
      1, [](const Sample& s, uint64_t) { return s.missed_ticks; },
      [](uint64_t value, uint64_t, Sample& s) {
        s.missed_ticks = value;
        return true;
      });
  // The bits of a double on a ramp rise evenly, too, but where its exponent changes.
  visit(
      2, [](const Sample& s, uint64_t) { return Bits(s.mass); },
      [](uint64_t value, uint64_t, Sample& s) { return FromBits(value, s.mass); });
  visit(
      1, [](const Sample& s, uint64_t) { return uint64_t{s.filter.estimator}; },
      [](uint64_t value, uint64_t, Sample& s) { return Narrow(value, s.filter.estimator); });
  visit(
      1, [](const Sample& s, uint64_t) { return Bits(s.filter.cutoff_hz); },
      [](uint64_t value, uint64_t, Sample& s) { return FromBits(value, s.filter.cutoff_hz); });
}

/// The same for the derived columns.
template <typename Visit>
void ForEachDerivedColumn(const Visit& visit) {
  using exchange::Sample;
  const auto number = [&visit](auto member) {
    visit(
        1, [member](const Sample& s, uint64_t) { return Bits(s.*member); },
        [member](uint64_t value, uint64_t, Sample& s) { return FromBits(value, s.*member); });
  };
  number(&Sample::position);
  number(&Sample::velocity);
  number(&Sample::acceleration);
  number(&Sample::force);
  visit(
      1, [](const Sample& s, uint64_t) { return s.answered_tick; },
      [](uint64_t value, uint64_t, Sample& s) {
        s.answered_tick = value;
        return true;
      });
  for (std::size_t i = 0; i < 3; ++i) {
    visit(
        1, [i](const Sample& s, uint64_t) { return Bits(s.filter_memory[i]); },
        [i](uint64_t value, uint64_t, Sample& s) { return FromBits(value, s.filter_memory[i]); });
  }
}

}  // namespace mwidth::record
