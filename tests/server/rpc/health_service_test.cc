#include "server/rpc/health_service.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>

#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using grpc::health::v1::Health;
using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;

class HealthServiceTest : public ServedAxis {
 protected:
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<HealthCheckResponse>> reader;

    /// UNKNOWN where the stream has ended.
    HealthCheckResponse::ServingStatus Read() const {
      HealthCheckResponse response;
      reader->Read(&response);
      return response.status();
    }
  };

  std::unique_ptr<Call> Watch(const std::string& service) {
    HealthCheckRequest request;
    request.set_service(service);
    auto call = std::make_unique<Call>();
    call->context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    call->reader = health->Watch(&call->context, request);
    return call;
  }

  const std::unique_ptr<Health::Stub> health = Health::NewStub(channel);
};

TEST_F(HealthServiceTest, AWatchTellsThatTheServerEnds) {
  const auto whole = Watch("");
  const auto service = Watch("mwidth.v1.RenderingService");
  EXPECT_EQ(whole->Read(), HealthCheckResponse::SERVING);
  EXPECT_EQ(service->Read(), HealthCheckResponse::SERVING);
  // Ends them, or it would last as long as its patience: the test's own time limit is shorter.
  server->Shutdown(std::chrono::hours(1));
  for (const auto* call : {whole.get(), service.get()}) {
    EXPECT_EQ(call->Read(), HealthCheckResponse::NOT_SERVING);
    ExpectStatus(call->reader->Finish(), grpc::StatusCode::UNAVAILABLE, "SHUTTING_DOWN");
  }
}

TEST_F(HealthServiceTest, AWatchOfAServiceThatIsNoneStaysOpen) {
  const auto call = Watch("mwidth.v1.Nope");
  EXPECT_EQ(call->Read(), HealthCheckResponse::SERVICE_UNKNOWN);
  call->context.TryCancel();
  EXPECT_EQ(call->reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

}  // namespace
}  // namespace mwidth::rpc
