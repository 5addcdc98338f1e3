// One StreamSamples call.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include "mwidth/v1/telemetry.pb.h"
#include "server/gate/refusal.h"
#include "server/record/broadcast.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/sample_streams.h"

namespace mwidth::rpc {

/// Writes an axis's samples to one client, batch after batch, and deletes itself when the call is over. One
/// write is under way at a time, so a client that does not read stops its own stream, and its queue in the
/// broadcast fills and drops. On the thread of SampleStreams.
class SampleStream {
 public:
  /// A new one, which waits for a call. `streams` outlives it.
  static void Await(SampleStreams& streams);
  SampleStream(const SampleStream&) = delete;
  SampleStream& operator=(const SampleStream&) = delete;

  /// Sends the next batch, or finishes the call, if there is reason to and nothing is being written.
  void Advance();

 private:
  enum class Phase : uint8_t { kWaiting, kWriting, kFinishing, kFinished };

  explicit SampleStream(SampleStreams& streams) : streams_(streams) {}
  ~SampleStream();

  void OnCall(bool ok);
  void OnWritten(bool ok);
  void OnDone();
  /// Subscribes, or says why not.
  grpc::Status Open();
  gate::Result<const Axis*> Subscribe(const v1::StreamSamplesRequest& request);
  void DeleteIfOver();

  SampleStreams& streams_;
  grpc::ServerContext context_;
  grpc::ByteBuffer request_;
  SampleStreams::Writer writer_{&context_};
  SampleStreams::Event on_call_ = [this](bool ok) { OnCall(ok); };
  SampleStreams::Event on_written_ = [this](bool ok) { OnWritten(ok); };
  SampleStreams::Event on_done_ = [this](bool /*ok*/) { OnDone(); };

  Phase phase_ = Phase::kWaiting;
  // gRPC has told that the call is over, by our doing or not.
  bool done_ = false;
  // What to finish with as soon as nothing is being written.
  std::optional<grpc::Status> verdict_;
  std::unique_ptr<record::Subscription> subscription_;
  record::Delivery delivery_;
};

}  // namespace mwidth::rpc
