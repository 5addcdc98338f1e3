// The head of a block of samples: what stands before its columns' bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "server/record/session/sample_columns.h"

namespace mwidth::record {

static_assert(std::endian::native == std::endian::little,
              "files are little-endian, and written as memory is");

inline constexpr uint8_t kBlockVersion = 1;

/// Bytes 0 to 15.
struct BlockHead {
  uint8_t version = kBlockVersion;
  /// 0: derived columns follow from the others; 1: they are stored.
  uint8_t derived_stored = 0;
  uint8_t stored_columns = kStoredColumns;
  uint8_t derived_columns = kDerivedColumns;
  uint32_t samples = 0;
  /// Of the derived columns row by row, 64 bytes each.
  uint64_t derived_checksum = 0;
};
static_assert(sizeof(BlockHead) == 16);

/// Then one of these for each column, 10 bytes in the file: the number of the first row, how often
/// differences were taken, and how many bytes the largest of them needs.
struct ColumnHead {
  uint64_t first = 0;
  uint8_t order = 0;
  uint8_t width = 0;
};
inline constexpr std::size_t kColumnHeadBytes = 10;
inline constexpr std::size_t kHeadBytes = sizeof(BlockHead) + kColumns * kColumnHeadBytes;

inline void Put(const ColumnHead& head, std::byte* at) noexcept {
  std::memcpy(at, &head.first, 8);
  at[8] = std::byte{head.order};
  at[9] = std::byte{head.width};
}

inline ColumnHead GetColumnHead(const std::byte* at) noexcept {
  ColumnHead head;
  std::memcpy(&head.first, at, 8);
  head.order = std::to_integer<uint8_t>(at[8]);
  head.width = std::to_integer<uint8_t>(at[9]);
  return head;
}

/// Small numbers of either sign as small numbers: 0, -1, 1, -2, ...
constexpr uint64_t ZigZag(uint64_t difference) noexcept {
  return (difference << 1U) ^ (0 - (difference >> 63U));
}
constexpr uint64_t UnZigZag(uint64_t value) noexcept { return (value >> 1U) ^ (0 - (value & 1U)); }

}  // namespace mwidth::record
