#include "server/record/subscriber_queue.h"

#include <algorithm>
#include <utility>

namespace mwidth::record {

std::shared_ptr<const EncodedBatch> MakeEncoded(const Batch& batch, const Encode& encode) {
  return std::make_shared<const EncodedBatch>(EncodedBatch{.first_tick = batch.first_tick,
                                                           .decimation = batch.decimation,
                                                           .samples = batch.samples.size(),
                                                           .missed_ticks_before = batch.missed_ticks_before,
                                                           .dropped_ticks_before = batch.dropped_ticks_before,
                                                           .bytes = encode(batch)});
}

std::size_t Delivery::samples() const {
  std::size_t sum = 0;
  for (const auto& batch : batches) {
    sum += batch->samples;
  }
  return sum;
}

bool Delivery::as_encoded() const {
  return batches.size() == 1 && missed_ticks_before == batches[0]->missed_ticks_before &&
         dropped_ticks_before == batches[0]->dropped_ticks_before;
}

bool SubscriberQueue::Waiting::AfterAGap() const {
  return batch->missed_ticks_before + batch->dropped_ticks_before + missed_before + dropped_before > 0;
}

SubscriberQueue::SubscriberQueue(const Terms& terms, std::function<void()> notify, bool closed)
    : terms_(terms), notification_(std::move(notify)), closed_(closed) {}

std::size_t SubscriberQueue::FirstSampleOf(const Batch& batch) const {
  if (terms_.first_tick <= batch.first_tick) {
    return 0;
  }
  const uint64_t ticks = terms_.first_tick - batch.first_tick;
  return static_cast<std::size_t>((ticks + batch.decimation - 1) / batch.decimation);
}

void SubscriberQueue::Offer(const std::shared_ptr<const EncodedBatch>& batch) {
  begun_ = true;
  const std::lock_guard lock(mutex_);
  // The oldest stay: what is delivered is then contiguous for as long as possible, with one gap behind it.
  if (!waiting_.empty() && waiting_samples_ + batch->samples > terms_.max_samples) {
    missed_ += batch->missed_ticks_before;
    dropped_ += batch->dropped_ticks_before + batch->samples * batch->decimation;
    return;
  }
  waiting_.push_back({.batch = batch,
                      .missed_before = std::exchange(missed_, 0),
                      .dropped_before = std::exchange(dropped_, 0)});
  waiting_samples_ += batch->samples;
}

bool SubscriberQueue::Take(Delivery& delivery) {
  delivery.batches.clear();
  const std::lock_guard lock(mutex_);
  if (waiting_.empty()) {
    return false;
  }
  const Waiting& first = waiting_.front();
  delivery.missed_ticks_before = first.batch->missed_ticks_before + first.missed_before;
  delivery.dropped_ticks_before = first.batch->dropped_ticks_before + first.dropped_before;
  std::size_t samples = 0;
  do {
    samples += waiting_.front().batch->samples;
    delivery.batches.push_back(std::move(waiting_.front().batch));
    waiting_.pop_front();
  } while (!waiting_.empty() && !waiting_.front().AfterAGap() &&
           samples + waiting_.front().batch->samples <= terms_.max_batch);
  waiting_samples_ -= samples;
  return true;
}

void SubscriberQueue::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  notification_.Notify();
}

bool SubscriberQueue::ended() const {
  const std::lock_guard lock(mutex_);
  return closed_ && waiting_.empty();
}

}  // namespace mwidth::record
