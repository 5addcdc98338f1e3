#include "server/record/drain.h"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

namespace mwidth::record {

Drain::Drain(SampleRing& ring, std::vector<SampleSink*> sinks, std::chrono::microseconds eager_period)
    : ring_(ring), sinks_(std::move(sinks)), eager_period_(eager_period) {
  if (eager_period_ <= std::chrono::microseconds::zero()) {
    throw std::invalid_argument("the drain's period must be above 0");
  }
}

Drain::~Drain() { Stop(); }

void Drain::Start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Drain::Stop() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  DrainOnce();
}

std::size_t Drain::DrainOnce() {
  std::size_t drained = 0;
  // One ringful at most: a loop that outran the drain must not keep it here.
  while (drained < exchange::kSampleRingCapacity) {
    auto block = std::make_shared<SampleBlock>();
    exchange::Sample sample;
    while (block->size() < kMaxBlockSamples && ring_.Pop(sample)) {
      block->push_back(sample);
    }
    if (block->empty()) {
      break;
    }
    drained += block->size();
    for (SampleSink* sink : sinks_) {
      sink->Consume(block);
    }
  }
  return drained;
}

std::chrono::microseconds Drain::period() const {
  const bool eager =
      std::any_of(sinks_.begin(), sinks_.end(), [](const SampleSink* sink) { return sink->eager(); });
  return eager ? eager_period_ : 2 * eager_period_;
}

void Drain::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    DrainOnce();
    // Nobody notifies but the stop token: this is a sleep that Stop ends at once.
    stopping_.wait_for(lock, stop, period(), [] { return false; });
  }
}

}  // namespace mwidth::record
