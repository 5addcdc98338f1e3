// One open StreamSamples call.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <grpcpp/support/byte_buffer.h>

#include "server/record/broadcast.h"
#include "server/rpc/pulled_stream.h"

namespace mwidth::rpc {

/// Where a client does not read, its queue in the broadcast fills and drops.
class SampleStream final : public PulledStream<grpc::ByteBuffer> {
 public:
  /// A new stream of the ticks from `first_tick` on, owned by gRPC once it is returned from the method. It is
  /// finished already, with RESOURCE_EXHAUSTED, where the broadcast has no room. `broadcast` outlives the
  /// server.
  static SampleStream* Open(const std::string& axis, record::Broadcast& broadcast, const record::Cut& cut,
                            uint64_t first_tick);

 private:
  SampleStream() = default;
  ~SampleStream() override = default;
  bool Pull(grpc::ByteBuffer& message, std::optional<grpc::Status>& end) override;

  std::unique_ptr<record::Subscription> subscription_;
  record::Delivery delivery_;
};

}  // namespace mwidth::rpc
