// Whether the server serves, by gRPC's standard health-checking protocol.
#pragma once

#include <grpcpp/server_context.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "grpc/health/v1/health.grpc.pb.h"
#include "server/record/notification.h"
#include "server/rpc/stream_source.h"
#include "server/rpc/stream_thread.h"

namespace mwidth::rpc {

/// One status for all services: they serve from the server's start to StopServing. gRPC's own health service
/// does the same by callbacks, of which there must be none here: see StreamThread.
class HealthService final
    : public grpc::health::v1::Health::WithRawMethod_Watch<grpc::health::v1::Health::Service> {
 public:
  /// Full names of the services; the empty name, which is the server as a whole, is known besides.
  explicit HealthService(std::vector<std::string> services);

  /// Has `thread` serve Watch, before the server starts. This outlives the thread.
  void AddStreamsTo(StreamThread& thread);

  /// Says NOT_SERVING from here on, and ends every Watch once it is told. Any thread.
  void StopServing();

  /// NOT_FOUND for a service that is none.
  grpc::Status Check(grpc::ServerContext* context, const grpc::health::v1::HealthCheckRequest* request,
                     grpc::health::v1::HealthCheckResponse* response) override;

 private:
  using Status = grpc::health::v1::HealthCheckResponse::ServingStatus;
  class Watch;

  Status StatusOf(const std::string& service) const;
  std::shared_ptr<record::Notification> Listen(std::function<void()> wake);
  void Remove(const std::shared_ptr<record::Notification>& listener);

  const std::vector<std::string> services_;
  std::atomic<bool> serving_ = true;
  std::mutex mutex_;
  std::vector<std::shared_ptr<record::Notification>> listeners_;
};

}  // namespace mwidth::rpc
