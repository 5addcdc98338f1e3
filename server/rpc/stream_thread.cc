#include "server/rpc/stream_thread.h"

#include <utility>

#include <grpc/support/time.h>

#include "server/rpc/stream_call.h"

namespace mwidth::rpc {

StreamThread::~StreamThread() { Stop(); }

void StreamThread::AddTo(grpc::ServerBuilder& builder) { queue_ = builder.AddCompletionQueue(); }

void StreamThread::Add(StreamMethod method) {
  methods_.push_back(std::make_unique<const StreamMethod>(std::move(method)));
}

void StreamThread::Start() {
  for (const auto& method : methods_) {
    Accept(*method);
  }
  thread_ = std::thread([this] { Run(); });
}

void StreamThread::Stop() {
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

void StreamThread::Accept(const StreamMethod& method) {
  if (open_) {
    StreamCall::Await(*this, method);
  }
}

void StreamThread::Wake(StreamCall& call) {
  const std::lock_guard lock(mutex_);
  if (stopping_) {
    return;
  }
  woken_.push_back(&call);
  // One wake-up, however many calls.
  if (!std::exchange(waking_, true)) {
    alarm_.Set(queue_.get(), gpr_now(GPR_CLOCK_MONOTONIC), &awake_);
  }
}

void StreamThread::Forget(StreamCall& call) {
  const std::lock_guard lock(mutex_);
  std::erase(woken_, &call);
}

void StreamThread::Run() {
  void* tag = nullptr;
  bool ok = false;
  while (queue_->Next(&tag, &ok)) {
    (*static_cast<Event*>(tag))(ok);
  }
}

void StreamThread::AdvanceWoken() {
  std::vector<StreamCall*> woken;
  {
    const std::lock_guard lock(mutex_);
    waking_ = false;
    woken.swap(woken_);
    if (stopping_ && open_) {
      // By this thread, so that no call begins anything afterwards.
      open_ = false;
      queue_->Shutdown();
    }
  }
  for (StreamCall* call : woken) {
    call->Advance();
  }
}

}  // namespace mwidth::rpc
