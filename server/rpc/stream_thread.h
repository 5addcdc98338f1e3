// Every open call of the methods that stream, served by one thread.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <grpcpp/alarm.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/server_builder.h>

#include "server/rpc/stream_source.h"

namespace mwidth::rpc {

class StreamCall;

/// gRPC's completion-queue API rather than its callbacks: there the end of every write is told by another
/// thread, which has to be woken for it, at more cost than the write; and where any service has callbacks,
/// two threads more wait for the same sockets, and hand whatever arrives from one to the other. Here one
/// thread writes to all calls that have something, then takes note of all writes that have ended, and sleeps
/// until there is something new.
class StreamThread {
 public:
  /// What a completion queue's tag points to; called with its `ok` by the thread.
  using Event = std::function<void(bool ok)>;

  StreamThread() = default;
  StreamThread(const StreamThread&) = delete;
  StreamThread& operator=(const StreamThread&) = delete;
  /// Stops.
  ~StreamThread();

  /// Before the server starts: the queue, once, and every method.
  void AddTo(grpc::ServerBuilder& builder);
  void Add(StreamMethod method);
  /// When the server has started.
  void Start();
  /// Between the shutdown of the server and its destruction: afterwards no call is left. Does no harm twice.
  void Stop();

  // For the calls, on the thread, but for Wake.

  grpc::ServerCompletionQueue& queue() { return *queue_; }
  /// Makes a new StreamCall wait for the next call of `method`, which is one of those added.
  void Accept(const StreamMethod& method);
  /// False once no operation may be started any more.
  bool open() const { return open_; }
  /// Has the thread call Advance of `call`, soon. Any thread.
  void Wake(StreamCall& call);
  /// `call` goes; nothing wakes it any more.
  void Forget(StreamCall& call);

 private:
  void Run();
  void AdvanceWoken();

  std::vector<std::unique_ptr<const StreamMethod>> methods_;
  std::unique_ptr<grpc::ServerCompletionQueue> queue_;
  // Of the thread.
  bool open_ = true;
  Event awake_ = [this](bool /*ok*/) { AdvanceWoken(); };

  std::mutex mutex_;
  grpc::Alarm alarm_;
  // The alarm is set, and its event has not come.
  bool waking_ = false;
  bool stopping_ = false;
  std::vector<StreamCall*> woken_;
  std::thread thread_;
};

}  // namespace mwidth::rpc
