// One open StreamEvents call.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "mwidth/v1/telemetry.pb.h"
#include "server/record/event_log.h"
#include "server/rpc/pulled_stream.h"

namespace mwidth::rpc {

/// Most StreamEvents calls on one axis.
inline constexpr std::size_t kMaxEventStreams = 64;

class EventStream final : public PulledStream<v1::StreamEventsResponse> {
 public:
  /// A new stream of the events behind number `after`, owned by gRPC once it is returned from the method.
  /// `log` outlives the server.
  static EventStream* Open(std::string axis, record::EventLog& log, uint64_t after);

 private:
  explicit EventStream(std::string axis);
  ~EventStream() override = default;
  bool Pull(v1::StreamEventsResponse& message, std::optional<grpc::Status>& end) override;

  const std::string axis_;
  std::unique_ptr<record::EventSubscription> subscription_;
};

}  // namespace mwidth::rpc
