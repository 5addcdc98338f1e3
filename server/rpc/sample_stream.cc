#include "server/rpc/sample_stream.h"

#include "server/rpc/sample_encoding.h"
#include "server/rpc/stream_refusals.h"

namespace mwidth::rpc {

SampleStream* SampleStream::Open(const std::string& axis, record::Broadcast& broadcast,
                                 const record::Cut& cut, uint64_t first_tick) {
  auto* stream = new SampleStream();  // NOLINT(cppcoreguidelines-owning-memory): see OnDone
  {
    // A notification may come before subscription_ is there: it waits for the lock.
    const std::lock_guard lock(stream->mutex());
    stream->subscription_ = broadcast.Subscribe(cut, first_tick, [stream] { stream->Advance(); });
  }
  if (stream->subscription_ == nullptr) {
    stream->End(TooManyStreams(axis, broadcast.limits().max_subscribers));
    return stream;
  }
  // The client sees at once that its stream is open: whatever it starts then is in it from the first tick.
  stream->StartSendInitialMetadata();
  stream->Advance();
  return stream;
}

bool SampleStream::Pull(grpc::ByteBuffer& message, std::optional<grpc::Status>& end) {
  if (!subscription_->Take(delivery_)) {
    if (subscription_->ended()) {
      end = ShuttingDown();
    }
    return false;
  }
  message = Assemble(delivery_);
  return true;
}

}  // namespace mwidth::rpc
