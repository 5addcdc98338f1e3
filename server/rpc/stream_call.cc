#include "server/rpc/stream_call.h"

#include <utility>

#include "server/rpc/status.h"

namespace mwidth::rpc {

void StreamCall::Await(StreamThread& thread, const StreamMethod& method) {
  auto* call = new StreamCall(thread, method);  // NOLINT(cppcoreguidelines-owning-memory): see DeleteIfOver
  call->context_.AsyncNotifyWhenDone(&call->on_done_);
  method.request_call(call->context_, call->request_, call->writer_, thread.queue(), &call->on_call_);
}

StreamCall::~StreamCall() {
  // First nothing that wakes, then no wake-up by an earlier one.
  source_.reset();
  thread_.Forget(*this);
}

void StreamCall::OnCall(bool ok) {
  if (!ok) {
    // The server shuts down: no call came, and none will be told to be over.
    delete this;  // NOLINT(cppcoreguidelines-owning-memory): as in DeleteIfOver
    return;
  }
  thread_.Accept(method_);
  const grpc::Status opened = Guarded(method_.name, [this] {
    grpc::Status refusal;
    source_ = method_.open(
        request_, [this] { thread_.Wake(*this); }, refusal);
    return refusal;
  });
  if (!opened.ok()) {
    verdict_ = opened;
    Advance();
    return;
  }
  // The client sees at once that its stream is open: whatever it starts then is in it from the beginning.
  if (thread_.open()) {
    phase_ = Phase::kWriting;
    writer_.SendInitialMetadata(&on_written_);
  }
}

void StreamCall::Advance() {
  if (phase_ != Phase::kWaiting || done_ || !thread_.open()) {
    return;
  }
  if (!verdict_) {
    if (source_->Pull(message_, verdict_)) {
      phase_ = Phase::kWriting;
      writer_.Write(message_, &on_written_);
      return;
    }
    if (!verdict_) {
      return;
    }
  }
  phase_ = Phase::kFinishing;
  writer_.Finish(*verdict_, &on_written_);
}

void StreamCall::OnWritten(bool ok) {
  phase_ = phase_ == Phase::kFinishing ? Phase::kFinished : Phase::kWaiting;
  if (!ok && !verdict_) {
    verdict_ = grpc::Status::CANCELLED;
  }
  Advance();
  DeleteIfOver();
}

void StreamCall::OnDone() {
  // Where the client went away nothing needs to be finished.
  done_ = true;
  DeleteIfOver();
}

void StreamCall::DeleteIfOver() {
  if (done_ && (phase_ == Phase::kWaiting || phase_ == Phase::kFinished)) {
    delete this;  // NOLINT(cppcoreguidelines-owning-memory): gRPC has it until here, by its tags
  }
}

}  // namespace mwidth::rpc
