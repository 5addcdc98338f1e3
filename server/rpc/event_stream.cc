#include "server/rpc/event_stream.h"

#include <utility>

#include "server/rpc/convert_record.h"
#include "server/rpc/stream_refusals.h"

namespace mwidth::rpc {

EventStream* EventStream::Open(std::string axis, record::EventLog& log, uint64_t after) {
  auto* stream = new EventStream(std::move(axis));  // NOLINT(cppcoreguidelines-owning-memory): see OnDone
  {
    // A notification may come before subscription_ is there: it waits for the lock.
    const std::lock_guard lock(stream->mutex());
    stream->subscription_ = log.Subscribe(after, kMaxEventStreams, [stream] { stream->Advance(); });
  }
  if (stream->subscription_ == nullptr) {
    stream->End(TooManyStreams(stream->axis_, kMaxEventStreams));
    return stream;
  }
  // The client sees at once that its stream is open: whatever it does then is in it.
  stream->StartSendInitialMetadata();
  stream->Advance();
  return stream;
}

EventStream::EventStream(std::string axis) : axis_(std::move(axis)) {}

bool EventStream::Pull(v1::StreamEventsResponse& message, std::optional<grpc::Status>& end) {
  const auto delivery = subscription_->Take();
  if (!delivery) {
    if (subscription_->ended()) {
      end = ShuttingDown();
    }
    return false;
  }
  message.Clear();
  Convert(axis_, delivery->event, *message.mutable_event());
  message.set_lost_before(delivery->lost_before);
  return true;
}

}  // namespace mwidth::rpc
