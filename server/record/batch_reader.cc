#include "server/record/batch_reader.h"

#include <optional>
#include <span>
#include <utility>

namespace mwidth::record {

BatchReader::BatchReader(std::unique_ptr<Subscription> subscription, Batcher batcher)
    : subscription_(std::move(subscription)), batcher_(batcher) {}

bool BatchReader::Next(Batch& batch) {
  batch.samples.clear();
  while (true) {
    if (position_ == size()) {
      std::optional<Delivery> delivery = subscription_->Take();
      if (!delivery) {
        break;
      }
      block_ = std::move(delivery->block);
      position_ = 0;
    }
    position_ += batcher_.Fill(std::span(*block_).subspan(position_), batch);
    if (position_ < size()) {
      break;
    }
  }
  return !batch.samples.empty();
}

}  // namespace mwidth::record
