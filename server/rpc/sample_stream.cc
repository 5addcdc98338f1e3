#include "server/rpc/sample_stream.h"

#include <utility>

#include <grpcpp/impl/codegen/proto_utils.h>

#include "mwidth/v1/telemetry.pb.h"
#include "server/gate/axis_gate.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/status.h"
#include "server/rpc/stream_refusals.h"
#include "server/rpc/stream_request.h"

namespace mwidth::rpc {

void SampleStream::Await(SampleStreams& streams) {
  auto* stream = new SampleStream(streams);  // NOLINT(cppcoreguidelines-owning-memory): see DeleteIfOver
  stream->context_.AsyncNotifyWhenDone(&stream->on_done_);
  streams.request_call()(stream->context_, stream->request_, stream->writer_, streams.queue(),
                         &stream->on_call_);
}

SampleStream::~SampleStream() {
  // First no notification, then no wake-up by an earlier one.
  subscription_.reset();
  streams_.Forget(*this);
}

void SampleStream::OnCall(bool ok) {
  if (!ok) {
    // The server shuts down: no call came, and none will be told to be over.
    delete this;  // NOLINT(cppcoreguidelines-owning-memory): as in DeleteIfOver
    return;
  }
  streams_.Accept();
  const grpc::Status opened = Guarded("StreamSamples", [this] { return Open(); });
  if (!opened.ok()) {
    verdict_ = opened;
    Advance();
    return;
  }
  // The client sees at once that its stream is open: whatever it starts then is in it from the first tick.
  if (streams_.open()) {
    phase_ = Phase::kWriting;
    writer_.SendInitialMetadata(&on_written_);
  }
}

grpc::Status SampleStream::Open() {
  v1::StreamSamplesRequest request;
  if (!grpc::SerializationTraits<v1::StreamSamplesRequest>::Deserialize(&request_, &request).ok()) {
    return {grpc::StatusCode::INTERNAL, "the bytes are no StreamSamplesRequest"};
  }
  const gate::Result<const Axis*> axis = Subscribe(request);
  if (!axis.ok()) {
    return ToStatus(axis.refusal());
  }
  return subscription_ != nullptr
             ? grpc::Status::OK
             : TooManyStreams((*axis)->name, (*axis)->broadcast.limits().max_subscribers);
}

gate::Result<const Axis*> SampleStream::Subscribe(const v1::StreamSamplesRequest& request) {
  const gate::Result<record::Cut> cut = CutOf(request);
  if (!cut.ok()) {
    return cut.refusal();
  }
  gate::Result<const Axis*> axis = streams_.axes().Find(request.axis());
  if (axis.ok()) {
    // The ring still holds ticks that ran before: to a client that began to render, they would read as an
    // end.
    const uint64_t first_tick = (*axis)->gate.Status().tick + 1;
    subscription_ = (*axis)->broadcast.Subscribe(*cut, first_tick, [this] { streams_.Wake(*this); });
  }
  return axis;
}

void SampleStream::Advance() {
  if (phase_ != Phase::kWaiting || done_ || !streams_.open()) {
    return;
  }
  if (!verdict_) {
    if (subscription_->Take(delivery_)) {
      phase_ = Phase::kWriting;
      writer_.Write(Assemble(delivery_), &on_written_);
      return;
    }
    if (!subscription_->ended()) {
      return;
    }
    verdict_ = ShuttingDown();
  }
  phase_ = Phase::kFinishing;
  writer_.Finish(*verdict_, &on_written_);
}

void SampleStream::OnWritten(bool ok) {
  phase_ = phase_ == Phase::kFinishing ? Phase::kFinished : Phase::kWaiting;
  if (!ok && !verdict_) {
    verdict_ = grpc::Status::CANCELLED;
  }
  Advance();
  DeleteIfOver();
}

void SampleStream::OnDone() {
  // Where the client went away nothing needs to be finished.
  done_ = true;
  DeleteIfOver();
}

void SampleStream::DeleteIfOver() {
  if (done_ && (phase_ == Phase::kWaiting || phase_ == Phase::kFinished)) {
    delete this;  // NOLINT(cppcoreguidelines-owning-memory): gRPC has it until here, by its tags
  }
}

}  // namespace mwidth::rpc
