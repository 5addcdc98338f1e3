// Every open StreamSamples call of a server, served by one thread.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <grpcpp/alarm.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/server_builder.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/async_stream.h>
#include <grpcpp/support/byte_buffer.h>

#include "server/rpc/axis_registry.h"

namespace mwidth::rpc {

class SampleStream;

/// gRPC's completion-queue API rather than its callbacks: there the end of every write is told by another
/// thread, which has to be woken for it, at more cost than the write. Here one thread writes to all streams
/// that have something, then takes note of all writes that have ended, and sleeps until samples come.
class SampleStreams {
 public:
  using Writer = grpc::ServerAsyncWriter<grpc::ByteBuffer>;
  /// Asks gRPC for the next call, whose coming `tag` tells.
  using RequestCall = std::function<void(grpc::ServerContext& context, grpc::ByteBuffer& request,
                                         Writer& writer, grpc::ServerCompletionQueue& queue, void* tag)>;
  /// What a completion queue's tag points to; called with its `ok` by the thread.
  using Event = std::function<void(bool ok)>;

  /// `axes` outlives this.
  SampleStreams(const AxisRegistry& axes, RequestCall request_call);
  SampleStreams(const SampleStreams&) = delete;
  SampleStreams& operator=(const SampleStreams&) = delete;
  /// Stops.
  ~SampleStreams();

  /// Before the server starts, once.
  void AddTo(grpc::ServerBuilder& builder);
  /// When the server has started.
  void Start();
  /// Between the shutdown of the server and its destruction: afterwards no stream is left. Does no harm
  /// twice.
  void Stop();

  // For the streams, on the thread, but for Wake.

  const AxisRegistry& axes() const { return axes_; }
  grpc::ServerCompletionQueue& queue() { return *queue_; }
  const RequestCall& request_call() const { return request_call_; }
  /// Makes a new stream wait for the next call.
  void Accept();
  /// False once no operation may be started any more.
  bool open() const { return open_; }
  /// Has the thread call Advance of `stream`, soon. Any thread.
  void Wake(SampleStream& stream);
  /// `stream` goes; nothing wakes it any more.
  void Forget(SampleStream& stream);

 private:
  void Run();
  void AdvanceWoken();

  const AxisRegistry& axes_;
  const RequestCall request_call_;
  std::unique_ptr<grpc::ServerCompletionQueue> queue_;
  // Of the thread.
  bool open_ = true;
  Event awake_ = [this](bool /*ok*/) { AdvanceWoken(); };

  std::mutex mutex_;
  grpc::Alarm alarm_;
  // The alarm is set, and its event has not come.
  bool waking_ = false;
  bool stopping_ = false;
  std::vector<SampleStream*> woken_;
  std::thread thread_;
};

}  // namespace mwidth::rpc
