#include "server/record/batcher.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace mwidth::record {

Batcher::Batcher(uint32_t decimation, std::size_t max_batch, uint64_t first_tick)
    : decimation_(decimation), max_batch_(max_batch), first_tick_(first_tick) {
  if (decimation == 0 || max_batch == 0) {
    throw std::invalid_argument("decimation and max_batch must be above 0");
  }
}

std::size_t Batcher::Fill(std::span<const exchange::Sample> samples, Batch& batch) {
  for (std::size_t used = 0; used < samples.size(); ++used) {
    const exchange::Sample& sample = samples[used];
    if (sample.tick < first_tick_) {
      continue;
    }
    const bool gap = started_ && sample.tick != last_tick_ + 1;
    const bool selected = sample.tick % decimation_ == 0;
    if ((gap && !batch.samples.empty()) || (selected && batch.samples.size() >= max_batch_)) {
      return used;
    }
    Count(sample);
    if (selected) {
      Append(sample, batch);
    }
  }
  return samples.size();
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

void Batcher::Append(const exchange::Sample& sample, Batch& batch) {
  if (batch.samples.empty()) {
    batch.first_tick = sample.tick;
    batch.decimation = decimation_;
    batch.missed_ticks_before = std::exchange(missed_, 0);
    batch.dropped_ticks_before = std::exchange(dropped_, 0);
  }
  batch.samples.push_back(sample);
}

}  // namespace mwidth::record
