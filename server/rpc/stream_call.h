// One call of a method that streams.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include "server/rpc/stream_source.h"
#include "server/rpc/stream_thread.h"

namespace mwidth::rpc {

/// Writes what its source has to one client, message after message, and deletes itself when the call is over.
/// One write is under way at a time, so a client that does not read stops its own stream, and nothing else.
/// On the thread of StreamThread.
class StreamCall {
 public:
  /// A new one, which waits for a call. `thread` and `method` outlive it.
  static void Await(StreamThread& thread, const StreamMethod& method);
  StreamCall(const StreamCall&) = delete;
  StreamCall& operator=(const StreamCall&) = delete;

  /// Sends the next message, or finishes the call, if there is reason to and nothing is being written.
  void Advance();

 private:
  enum class Phase : uint8_t { kWaiting, kWriting, kFinishing, kFinished };

  StreamCall(StreamThread& thread, const StreamMethod& method) : thread_(thread), method_(method) {}
  ~StreamCall();

  void OnCall(bool ok);
  void OnWritten(bool ok);
  void OnDone();
  void DeleteIfOver();

  StreamThread& thread_;
  const StreamMethod& method_;
  grpc::ServerContext context_;
  grpc::ByteBuffer request_;
  StreamWriter writer_{&context_};
  StreamThread::Event on_call_ = [this](bool ok) { OnCall(ok); };
  StreamThread::Event on_written_ = [this](bool ok) { OnWritten(ok); };
  StreamThread::Event on_done_ = [this](bool /*ok*/) { OnDone(); };

  Phase phase_ = Phase::kWaiting;
  // gRPC has told that the call is over, by our doing or not.
  bool done_ = false;
  // What to finish with as soon as nothing is being written.
  std::optional<grpc::Status> verdict_;
  std::unique_ptr<StreamSource> source_;
  grpc::ByteBuffer message_;
};

}  // namespace mwidth::rpc
