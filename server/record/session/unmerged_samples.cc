#include "server/record/session/unmerged_samples.h"

#include <algorithm>
#include <span>

namespace mwidth::record {

UnmergedSamples::UnmergedSamples(const SessionAxis& axis, std::size_t block_samples)
    : block_samples_(block_samples), rebuilder_(axis) {}

void UnmergedSamples::Push(const exchange::Sample& sample) {
  const bool follows_in_time = !samples_.empty() && Follows(samples_.back(), sample);
  if (samples_.size() - block_begin_ == block_samples_ ||
      (samples_.size() > block_begin_ && !follows_in_time)) {
    block_ends_.push_back(samples_.size());
    block_begin_ = samples_.size();
  }
  const DerivedColumns derived = DerivedOf(sample);
  const auto rebuilt = can_follow_ && follows_in_time ? rebuilder_.Follow(sample) : std::nullopt;
  if (!rebuilt || !SameBits(*rebuilt, derived)) {
    breaks_.push_back(samples_.size());
    can_follow_ = rebuilder_.Begin(sample);
  }
  samples_.push_back(sample);
  derived_.push_back(derived);
}

void UnmergedSamples::Close() {
  if (block_begin_ < samples_.size()) {
    block_ends_.push_back(samples_.size());
    block_begin_ = samples_.size();
  }
}

CheckedSamples UnmergedSamples::Range(std::size_t begin, std::size_t end) const {
  // The first of a block is stored whole, and need not follow.
  const auto next_break = std::upper_bound(breaks_.begin(), breaks_.end(), begin);
  return {.samples = std::span(samples_).subspan(begin, end - begin),
          .derived = std::span(derived_).subspan(begin, end - begin),
          .follow = (next_break == breaks_.end() || *next_break >= end)};
}

CheckedSamples UnmergedSamples::block(std::size_t index) const {
  return Range(index == 0 ? 0 : block_ends_[index - 1], block_ends_[index]);
}

CheckedSamples UnmergedSamples::tail() const {
  return Range(std::max(block_begin_, committed_), samples_.size());
}

void UnmergedSamples::Committed() {
  const auto merged = static_cast<std::ptrdiff_t>(block_begin_);
  samples_.erase(samples_.begin(), samples_.begin() + merged);
  derived_.erase(derived_.begin(), derived_.begin() + merged);
  breaks_.erase(breaks_.begin(), std::lower_bound(breaks_.begin(), breaks_.end(), block_begin_));
  for (std::size_t& at : breaks_) {
    at -= block_begin_;
  }
  block_ends_.clear();
  block_begin_ = 0;
  committed_ = samples_.size();
}

}  // namespace mwidth::record
