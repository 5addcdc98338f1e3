#include "server/rpc/health_service.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/rpc/stream_refusals.h"

namespace mwidth::rpc {

using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

/// Tells the status at once, and whenever it changes.
class HealthService::Watch final : public StreamSource {
 public:
  Watch(HealthService& health, std::string service, std::function<void()> wake)
      : health_(health), service_(std::move(service)), listener_(health.Listen(std::move(wake))) {}
  ~Watch() override {
    health_.Remove(listener_);
    listener_->Detach();
  }

  bool Pull(grpc::ByteBuffer& message, std::optional<grpc::Status>& end) override {
    const bool last = !health_.serving_;
    const Status status = health_.StatusOf(service_);
    if (status != told_) {
      told_ = status;
      HealthCheckResponse response;
      response.set_status(status);
      message = BytesOf(response);
      return true;
    }
    if (last) {
      end = ShuttingDown();
    }
    return false;
  }

 private:
  HealthService& health_;
  const std::string service_;
  const std::shared_ptr<record::Notification> listener_;
  std::optional<Status> told_;
};

HealthService::HealthService(std::vector<std::string> services) : services_(std::move(services)) {}

void HealthService::AddStreamsTo(StreamThread& thread) {
  thread.Add(MethodOf<HealthCheckRequest>("Watch", *this, &HealthService::RequestWatch,
                                          [this](const auto& request, auto wake, auto& /*refusal*/) {
                                            return std::make_unique<Watch>(*this, request.service(),
                                                                           std::move(wake));
                                          }));
}

void HealthService::StopServing() {
  serving_ = false;
  std::vector<std::shared_ptr<record::Notification>> listeners;
  {
    const std::lock_guard lock(mutex_);
    listeners = listeners_;
  }
  for (const auto& listener : listeners) {
    listener->Notify();
  }
}

grpc::Status HealthService::Check(grpc::ServerContext*, const HealthCheckRequest* request,
                                  HealthCheckResponse* response) {
  const Status status = StatusOf(request->service());
  if (status == HealthCheckResponse::SERVICE_UNKNOWN) {
    return {grpc::StatusCode::NOT_FOUND, "no such service; reflection lists those that there are"};
  }
  response->set_status(status);
  return grpc::Status::OK;
}

HealthService::Status HealthService::StatusOf(const std::string& service) const {
  if (!service.empty() && std::find(services_.begin(), services_.end(), service) == services_.end()) {
    return HealthCheckResponse::SERVICE_UNKNOWN;
  }
  return serving_ ? HealthCheckResponse::SERVING : HealthCheckResponse::NOT_SERVING;
}

std::shared_ptr<record::Notification> HealthService::Listen(std::function<void()> wake) {
  auto listener = std::make_shared<record::Notification>(std::move(wake));
  const std::lock_guard lock(mutex_);
  listeners_.push_back(listener);
  return listener;
}

void HealthService::Remove(const std::shared_ptr<record::Notification>& listener) {
  const std::lock_guard lock(mutex_);
  std::erase(listeners_, listener);
}

}  // namespace mwidth::rpc
