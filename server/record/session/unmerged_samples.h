// The samples of a session that are in no block of its file yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/session/derived_columns.h"
#include "server/record/session/sample_codec.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// Cuts them into blocks: a block is whole once there are `block_samples` behind its first, or a tick is
/// lost. Each sample is looked at once, whether it goes into the tail, a block, or both. One thread.
class UnmergedSamples {
 public:
  UnmergedSamples(const SessionAxis& axis, std::size_t block_samples);

  /// Samples rise in their ticks.
  void Push(const exchange::Sample& sample);
  /// Nothing comes behind the last sample.
  void Close();

  std::size_t whole_blocks() const { return block_ends_.size(); }
  /// The whole block of this index.
  CheckedSamples block(std::size_t index) const;
  /// What is neither in the tail nor in a whole block; may be empty.
  CheckedSamples tail() const;
  /// Samples that wait to be committed.
  std::size_t pending() const { return samples_.size() - committed_; }

  /// The whole blocks are in the file now, and the rest is in its tail.
  void Committed();
  /// All were read from the tail of a file.
  void FoundInTail() { committed_ = samples_.size(); }

 private:
  CheckedSamples Range(std::size_t begin, std::size_t end) const;

  const std::size_t block_samples_;
  ColumnRebuilder rebuilder_;
  bool can_follow_ = false;
  std::vector<exchange::Sample> samples_;
  std::vector<DerivedColumns> derived_;
  // Those whose derived columns do not follow from the sample before.
  std::vector<std::size_t> breaks_;
  std::vector<std::size_t> block_ends_;
  std::size_t block_begin_ = 0;
  // So many from the front are in the tail.
  std::size_t committed_ = 0;
};

}  // namespace mwidth::record
