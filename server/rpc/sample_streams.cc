#include "server/rpc/sample_streams.h"

#include <utility>

#include <grpc/support/time.h>

#include "server/rpc/sample_stream.h"

namespace mwidth::rpc {

SampleStreams::SampleStreams(const AxisRegistry& axes, RequestCall request_call)
    : axes_(axes), request_call_(std::move(request_call)) {}

SampleStreams::~SampleStreams() { Stop(); }

void SampleStreams::AddTo(grpc::ServerBuilder& builder) { queue_ = builder.AddCompletionQueue(); }

void SampleStreams::Start() {
  Accept();
  thread_ = std::thread([this] { Run(); });
}

void SampleStreams::Stop() {
  if (!thread_.joinable()) {
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (!std::exchange(waking_, true)) {
      alarm_.Set(queue_.get(), gpr_now(GPR_CLOCK_MONOTONIC), &awake_);
    }
  }
  thread_.join();
}

void SampleStreams::Accept() {
  if (open_) {
    SampleStream::Await(*this);
  }
}

void SampleStreams::Wake(SampleStream& stream) {
  const std::lock_guard lock(mutex_);
  if (stopping_) {
    return;
  }
  woken_.push_back(&stream);
  // One wake-up, however many streams.
  if (!std::exchange(waking_, true)) {
    alarm_.Set(queue_.get(), gpr_now(GPR_CLOCK_MONOTONIC), &awake_);
  }
}

void SampleStreams::Forget(SampleStream& stream) {
  const std::lock_guard lock(mutex_);
  std::erase(woken_, &stream);
}

void SampleStreams::Run() {
  void* tag = nullptr;
  bool ok = false;
  while (queue_->Next(&tag, &ok)) {
    (*static_cast<Event*>(tag))(ok);
  }
}

void SampleStreams::AdvanceWoken() {
  std::vector<SampleStream*> woken;
  {
    const std::lock_guard lock(mutex_);
    waking_ = false;
    woken.swap(woken_);
    if (stopping_ && open_) {
      // By this thread, so that no stream begins anything afterwards.
      open_ = false;
      queue_->Shutdown();
    }
  }
  for (SampleStream* stream : woken) {
    stream->Advance();
  }
}

}  // namespace mwidth::rpc
