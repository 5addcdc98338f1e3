#include "server/rpc/sample_stream.h"

#include <utility>

#include "server/gate/refusal.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {
namespace {

grpc::Status TooManyStreams(const std::string& axis, std::size_t max_streams) {
  const std::string limit = std::to_string(max_streams);
  return ToStatus(
      {.code = gate::RefusalCode::kResourceExhausted,
       .reason = gate::kTooManyStreams,
       .message = "Axis '" + axis + "' streams to " + limit +
                  " clients already, its limit: end one of these streams, or raise the limit in the "
                  "server's configuration.",
       .metadata = {{"axis", axis}, {"max_streams", limit}}});
}

grpc::Status ShuttingDown() {
  return ToStatus({.code = gate::RefusalCode::kUnavailable,
                   .reason = gate::kShuttingDown,
                   .message = "The server is shutting down: connect again when it is back."});
}

}  // namespace

SampleStream* SampleStream::Open(std::string axis, record::Broadcast& broadcast, record::Batcher batcher) {
  auto* stream = new SampleStream(std::move(axis));  // NOLINT(cppcoreguidelines-owning-memory): see OnDone
  stream->Subscribe(broadcast, batcher);
  stream->Advance();
  return stream;
}

SampleStream::SampleStream(std::string axis) : axis_(std::move(axis)) {}

void SampleStream::Subscribe(record::Broadcast& broadcast, const record::Batcher& batcher) {
  // A notification may come before reader_ is there: it waits for the lock.
  const std::lock_guard lock(mutex_);
  auto subscription = broadcast.Subscribe([this] { Advance(); });
  if (subscription == nullptr) {
    verdict_ = TooManyStreams(axis_, broadcast.limits().max_subscribers);
    return;
  }
  reader_.emplace(std::move(subscription), batcher);
  // The client sees at once that its stream is open: whatever it starts then is in it from the first tick.
  StartSendInitialMetadata();
}

void SampleStream::Advance() {
  std::optional<grpc::Status> last;
  {
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::kWaiting) {
      return;
    }
    if (!verdict_ && !reader_->Next(batch_)) {
      if (!reader_->ended()) {
        return;
      }
      verdict_ = ShuttingDown();
    }
    phase_ = verdict_ ? Phase::kFinished : Phase::kWriting;
    last = verdict_;
  }
  // Without the lock, because gRPC may call back at once. Nothing of this object is touched after Finish or
  // StartWrite: OnDone may have deleted it.
  if (last) {
    Finish(*std::move(last));
    return;
  }
  const grpc::Status encoded = Guarded("StreamSamples", [this] {
    bytes_ = Encode(axis_, batch_);
    return grpc::Status::OK;
  });
  if (!encoded.ok()) {
    Finish(encoded);  // Still kWriting, so that nobody else finishes.
    return;
  }
  StartWrite(&bytes_);
}

void SampleStream::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    phase_ = Phase::kWaiting;
    if (!ok && !verdict_) {
      verdict_ = grpc::Status::CANCELLED;
    }
  }
  Advance();
}

void SampleStream::OnCancel() {
  {
    const std::lock_guard lock(mutex_);
    if (!verdict_) {
      verdict_ = grpc::Status::CANCELLED;
    }
  }
  Advance();
}

void SampleStream::OnDone() {
  // Ends the subscription, and with it the last notification that could still be running.
  delete this;  // NOLINT(cppcoreguidelines-owning-memory): gRPC's reactors own themselves until here
}

}  // namespace mwidth::rpc
