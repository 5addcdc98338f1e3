#include "server/rpc/telemetry_service.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/server_callback.h>

#include "server/gate/axis_gate.h"
#include "server/gate/invalid_number.h"
#include "server/gate/refusal.h"
#include "server/rpc/sample_stream.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {
namespace {

constexpr uint32_t kDefaultBatch = 100;
constexpr uint32_t kMaxBatch = 1000;
constexpr uint32_t kMaxDecimation = 10'000;

/// A call that was refused: finishes at once.
class RefusedStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit RefusedStream(grpc::Status status) { Finish(std::move(status)); }
  void OnDone() override { delete this; }  // NOLINT(cppcoreguidelines-owning-memory): reactors own themselves
};

std::optional<gate::Refusal> CheckRange(const std::string& field, uint32_t value, uint32_t max) {
  if (value <= max) {
    return std::nullopt;
  }
  return gate::InvalidNumber(field, value, "0 to " + std::to_string(max));
}

/// Opens the stream that `request` asks for, or says why not.
gate::Result<SampleStream*> Open(const AxisRegistry& axes, const v1::StreamSamplesRequest& request) {
  if (auto refusal = CheckRange("decimation", request.decimation(), kMaxDecimation)) {
    return *std::move(refusal);
  }
  if (auto refusal = CheckRange("max_batch", request.max_batch(), kMaxBatch)) {
    return *std::move(refusal);
  }
  const gate::Result<const Axis*> axis = axes.Find(request.axis());
  if (!axis.ok()) {
    return axis.refusal();
  }
  // As proto3 has it, 0 is a field that was not set.
  const uint32_t decimation = request.decimation() == 0 ? 1 : request.decimation();
  const uint32_t max_batch = request.max_batch() == 0 ? kDefaultBatch : request.max_batch();
  // The ring still holds ticks that ran before: to a client that began to render, they would read as an end.
  const uint64_t first_tick = (*axis)->gate.Status().tick + 1;
  return SampleStream::Open((*axis)->name, (*axis)->broadcast,
                            record::Batcher(decimation, max_batch, first_tick));
}

}  // namespace

TelemetryService::TelemetryService(const AxisRegistry& axes) : axes_(axes) {}

grpc::ServerWriteReactor<grpc::ByteBuffer>* TelemetryService::StreamSamples(
    grpc::CallbackServerContext* /*context*/, const grpc::ByteBuffer* request) {
  SampleStream* stream = nullptr;
  const grpc::Status status = Guarded("StreamSamples", [&]() -> grpc::Status {
    v1::StreamSamplesRequest parsed;
    grpc::ByteBuffer bytes = *request;  // shares the memory; parsing consumes it
    if (!grpc::SerializationTraits<v1::StreamSamplesRequest>::Deserialize(&bytes, &parsed).ok()) {
      return {grpc::StatusCode::INTERNAL, "the bytes are no StreamSamplesRequest"};
    }
    const gate::Result<SampleStream*> opened = Open(axes_, parsed);
    if (!opened.ok()) {
      return ToStatus(opened.refusal());
    }
    stream = *opened;
    return grpc::Status::OK;
  });
  if (stream != nullptr) {
    return stream;
  }
  return new RefusedStream(status);
}

}  // namespace mwidth::rpc
