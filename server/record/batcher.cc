#include "server/record/batcher.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace mwidth::record {
namespace {

Cut Checked(const Cut& cut) {
  if (cut.decimation == 0 || cut.min_batch == 0 || cut.min_batch > cut.max_batch) {
    throw std::invalid_argument("decimation and min_batch must be above 0, and max_batch at least min_batch");
  }
  return cut;
}

}  // namespace

Batcher::Batcher(const Cut& cut, std::size_t phase)
    : cut_(Checked(cut)), phase_(phase), reducer_(cut.reduction, cut.decimation) {}

void Batcher::Take(std::span<const exchange::Sample> samples, const Emit& emit) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const exchange::Sample& sample = samples[i];
    if (started_ && sample.tick != last_tick_ + 1) {
      Flush(emit);
      reducer_.Reset();
    }
    Count(sample);
    if (const auto reduced = reducer_.Push(sample)) {
      Append(*reduced);
      if (Complete(samples.size() - i - 1)) {
        Flush(emit);
      }
    }
  }
  if (cut_.min_batch == 1) {
    Flush(emit);
  }
}

void Batcher::Flush(const Emit& emit) {
  if (!batch_.samples.empty()) {
    emit(batch_);
    batch_.samples.clear();
    batch_.extremes.clear();
  }
}

void Batcher::Count(const exchange::Sample& sample) {
  if (started_) {
    const uint64_t absent = sample.tick - last_tick_ - 1;
    // The loop's own count can only explain ticks that are absent.
    const uint64_t missed = std::min(absent, sample.missed_ticks - last_missed_ticks_);
    missed_ += missed;
    dropped_ += absent - missed;
  }
  started_ = true;
  last_tick_ = sample.tick;
  last_missed_ticks_ = sample.missed_ticks;
}

void Batcher::Append(const ReducedSample& reduced) {
  if (batch_.samples.empty()) {
    batch_.first_tick = reduced.sample.tick;
    batch_.decimation = cut_.decimation;
    batch_.reduction = cut_.reduction;
    batch_.missed_ticks_before = std::exchange(missed_, 0);
    batch_.dropped_ticks_before = std::exchange(dropped_, 0);
  }
  batch_.samples.push_back(reduced.sample);
  if (cut_.reduction == Reduction::kMinMax) {
    batch_.extremes.push_back(reduced.extremes);
  }
}

bool Batcher::Complete(std::size_t ticks_at_hand) const {
  const std::size_t size = batch_.samples.size();
  if (size == cut_.max_batch || cut_.min_batch == 1) {
    return size == cut_.max_batch;
  }
  const uint64_t next = batch_.samples.back().tick / cut_.decimation + 1;
  const bool end = (next + phase_) % cut_.min_batch == 0;
  // Where the next end is at hand as well, one batch serves for both.
  const bool more =
      ticks_at_hand >= cut_.min_batch * cut_.decimation && size + cut_.min_batch <= cut_.max_batch;
  return end && !more;
}

}  // namespace mwidth::record
