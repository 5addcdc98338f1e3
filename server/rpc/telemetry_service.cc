#include "server/rpc/telemetry_service.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/server_callback.h>

#include "server/exchange/clock.h"
#include "server/gate/axis_gate.h"
#include "server/gate/invalid_number.h"
#include "server/gate/refusal.h"
#include "server/record/event_log.h"
#include "server/rpc/convert_record.h"
#include "server/rpc/event_stream.h"
#include "server/rpc/sample_stream.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {
namespace {

constexpr uint32_t kDefaultBatch = 100;
constexpr uint32_t kMaxBatch = 1000;
constexpr uint32_t kMaxDecimation = 10'000;
constexpr uint32_t kMaxFilteredDecimation = 1000;

std::optional<gate::Refusal> CheckRange(const std::string& field, uint32_t value, uint32_t max) {
  if (value <= max) {
    return std::nullopt;
  }
  return gate::InvalidNumber(field, value, "0 to " + std::to_string(max));
}

std::optional<record::Reduction> ReductionOf(v1::Reduction reduction) {
  switch (reduction) {
    case v1::REDUCTION_UNSPECIFIED:
    case v1::REDUCTION_PICK:
      return record::Reduction::kPick;
    case v1::REDUCTION_LOW_PASS:
      return record::Reduction::kLowPass;
    case v1::REDUCTION_MIN_MAX:
      return record::Reduction::kMinMax;
    default:  // proto3 passes on any number
      return std::nullopt;
  }
}

/// How `request` wants its stream cut, or what is wrong with that. As proto3 has it, 0 is a field that was
/// not set.
gate::Result<record::Cut> CutOf(const v1::StreamSamplesRequest& request) {
  const std::optional<record::Reduction> reduction = ReductionOf(request.reduction());
  if (!reduction) {
    return gate::InvalidNumber("reduction", request.reduction(),
                               "1 (PICK), 2 (LOW_PASS), 3 (MIN_MAX), or 0 for PICK");
  }
  const bool filtered = *reduction == record::Reduction::kLowPass;
  if (auto refusal = CheckRange("decimation", request.decimation(),
                                filtered ? kMaxFilteredDecimation : kMaxDecimation)) {
    return *std::move(refusal);
  }
  if (auto refusal = CheckRange("max_batch", request.max_batch(), kMaxBatch)) {
    return *std::move(refusal);
  }
  if (auto refusal = CheckRange("min_batch", request.min_batch(), kMaxBatch)) {
    return *std::move(refusal);
  }
  if (request.max_batch() != 0 && request.min_batch() > request.max_batch()) {
    return gate::InvalidNumber("min_batch", request.min_batch(),
                               "at most max_batch, which is " + std::to_string(request.max_batch()));
  }
  const uint32_t min_batch = std::max(request.min_batch(), 1U);
  return record::Cut{
      .decimation = std::max(request.decimation(), 1U),
      .reduction = *reduction,
      .min_batch = min_batch,
      .max_batch = request.max_batch() == 0 ? std::max(kDefaultBatch, min_batch) : request.max_batch()};
}

/// Opens the stream that `request` asks for, or says why not.
gate::Result<SampleStream*> Open(const AxisRegistry& axes, const v1::StreamSamplesRequest& request) {
  const gate::Result<record::Cut> cut = CutOf(request);
  if (!cut.ok()) {
    return cut.refusal();
  }
  const gate::Result<const Axis*> axis = axes.Find(request.axis());
  if (!axis.ok()) {
    return axis.refusal();
  }
  // The ring still holds ticks that ran before: to a client that began to render, they would read as an end.
  const uint64_t first_tick = (*axis)->gate.Status().tick + 1;
  return SampleStream::Open((*axis)->name, (*axis)->broadcast, *cut, first_tick);
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
  return new RefusedStream<grpc::ByteBuffer>(status);
}

grpc::ServerWriteReactor<v1::StreamEventsResponse>* TelemetryService::StreamEvents(
    grpc::CallbackServerContext* /*context*/, const v1::StreamEventsRequest* request) {
  EventStream* stream = nullptr;
  const grpc::Status status = Guarded("StreamEvents", [&]() -> grpc::Status {
    const gate::Result<const Axis*> axis = axes_.Find(request->axis());
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    record::EventLog& events = (*axis)->events;
    const uint64_t after = request->has_after_number() ? request->after_number() : events.newest();
    stream = EventStream::Open((*axis)->name, events, after);
    return grpc::Status::OK;
  });
  if (stream != nullptr) {
    return stream;
  }
  return new RefusedStream<v1::StreamEventsResponse>(status);
}

grpc::Status TelemetryService::SyncClock(grpc::ServerContext*, const v1::SyncClockRequest* request,
                                         v1::SyncClockResponse* response) {
  return Guarded("SyncClock", [&] {
    const gate::Result<const Axis*> axis = axes_.Find(request->axis());
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    response->set_server_receive_ns((*axis)->clock.NowNs());
    response->set_client_send_ns(request->client_send_ns());
    const auto wall = std::chrono::system_clock::now().time_since_epoch();
    *response->mutable_wall_time() =
        WallTime(std::chrono::duration_cast<std::chrono::nanoseconds>(wall).count());
    response->set_server_send_ns((*axis)->clock.NowNs());
    return grpc::Status::OK;
  });
}

}  // namespace mwidth::rpc
