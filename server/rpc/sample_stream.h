// One open StreamSamples call.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>

#include "server/record/batch_reader.h"
#include "server/record/broadcast.h"

namespace mwidth::rpc {

/// Writes an axis's samples to one client, batch after batch, and deletes itself when the call is over.
///
/// No thread of its own: it moves when the drain has queued a block and when gRPC has taken the previous
/// batch, and whichever comes first sends what is there. One write is under way at a time, so a client that
/// does not read stops its own stream, and its queue in the broadcast fills and drops.
class SampleStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  /// A new stream, owned by gRPC once it is returned from the method. It is finished already, with
  /// RESOURCE_EXHAUSTED, where the broadcast has no room. `broadcast` outlives the server.
  static SampleStream* Open(std::string axis, record::Broadcast& broadcast, record::Batcher batcher);

  // Called by gRPC, from any of its threads.
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  enum class Phase : uint8_t { kWaiting, kWriting, kFinished };

  explicit SampleStream(std::string axis);
  void Subscribe(record::Broadcast& broadcast, const record::Batcher& batcher);
  /// Sends the next batch, or finishes the call, if there is reason to and nothing is being written.
  void Advance();

  const std::string axis_;
  std::mutex mutex_;
  Phase phase_ = Phase::kWaiting;
  // What to finish with as soon as nothing is being written: Finish must not overlap a write.
  std::optional<grpc::Status> verdict_;
  std::optional<record::BatchReader> reader_;
  // Owned by whoever moved the phase to kWriting, until OnWriteDone.
  record::Batch batch_;
  grpc::ByteBuffer bytes_;
};

}  // namespace mwidth::rpc
