#include "server/rpc/server.h"

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <future>
#include <stdexcept>
#include <vector>

#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using grpc::StatusCode;
using testing::HasSubstr;

class ServerTest : public ServedAxis {
 protected:
  /// Sends bytes to a method and returns the status; `answer` gets what comes back.
  grpc::Status Send(const std::string& method, const std::string& bytes, std::string& answer) {
    const grpc::Slice slice(bytes);
    const grpc::ByteBuffer request(&slice, 1);
    grpc::ByteBuffer response;
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    grpc::GenericStub stub(channel);
    std::promise<grpc::Status> done;
    stub.UnaryCall(&context, method, {}, &request, &response,
                   [&done](const grpc::Status& status) { done.set_value(status); });
    const grpc::Status status = done.get_future().get();
    std::vector<grpc::Slice> slices;
    if (status.ok() && response.Dump(&slices).ok()) {
      for (const grpc::Slice& part : slices) {
        answer.append(reinterpret_cast<const char*>(part.begin()), part.size());
      }
    }
    return status;
  }

  /// The status of grpc.health.v1.Health/Check in the wire format of its response: field 1, an enum.
  std::string Health(const std::string& service) {
    std::string answer;
    const std::string request =
        service.empty() ? "" : "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
    EXPECT_TRUE(Send("/grpc.health.v1.Health/Check", request, answer).ok()) << service;
    return answer;
  }
};

TEST_F(ServerTest, AnswersGarbageWithInternalAndGoesOn) {
  const std::string lease = Render(0.5);
  for (const char* method : {"RenderingService/SetMass", "RenderingService/StopRendering",
                             "RenderingService/EmergencyStop", "StabilityService/GetMWidth"}) {
    std::string answer;
    const grpc::Status status =
        Send(std::string("/mwidth.v1.") + method, std::string("\xff\xff\xff\x00garbage", 11), answer);
    EXPECT_EQ(status.error_code(), StatusCode::INTERNAL) << method;
  }
  EXPECT_EQ(State().state(), v1::STATE_RENDERING);
  EXPECT_EQ(State().mass(), 0.5);
}

TEST_F(ServerTest, RefusesTooLargeARequest) {
  v1::AcquireControlRequest request;
  request.set_client_name(std::string(kMaxRequestBytes + 1, 'x'));
  v1::AcquireControlResponse response;
  EXPECT_EQ(Call(&Rendering::AcquireControl, *rendering, request, response).error_code(),
            StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(ServerTest, KnowsNoOtherMethod) {
  std::string answer;
  EXPECT_EQ(Send("/mwidth.v1.RenderingService/Fly", "", answer).error_code(), StatusCode::UNIMPLEMENTED);
}

TEST_F(ServerTest, ReportsTheHealthOfEveryService) {
  for (const char* service :
       {"", "mwidth.v1.RenderingService", "mwidth.v1.StabilityService", "mwidth.v1.TelemetryService"}) {
    EXPECT_EQ(Health(service), "\x08\x01") << service;
  }
  std::string answer;
  EXPECT_EQ(Send("/grpc.health.v1.Health/Check", "\x0a\x04nope", answer).error_code(), StatusCode::NOT_FOUND);
}

TEST_F(ServerTest, DescribesItselfByReflection) {
  // ServerReflectionRequest with list_services (field 7) "": one message of a stream that a unary call can
  // be.
  std::string answer;
  ASSERT_TRUE(Send("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                   std::string("\x3a\x00", 2), answer)
                  .ok());
  for (const char* service : {"mwidth.v1.RenderingService", "mwidth.v1.StabilityService",
                              "mwidth.v1.TelemetryService", "grpc.health.v1.Health"}) {
    EXPECT_THAT(answer, HasSubstr(service));
  }
}

TEST_F(ServerTest, TakesAnAddressForItselfAlone) {
  EXPECT_THAT(server->address(), testing::MatchesRegex("127\\.0\\.0\\.1:[1-9][0-9]*"));
  try {
    const Server second(axes, server->address(), "0.0.0-test");
    FAIL() << "two servers on " << server->address();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot listen on " + server->address()));
  }
  EXPECT_EQ(State().state(), v1::STATE_IDLE);
}

TEST_F(ServerTest, RefusesAnAddressThatIsNone) {
  for (const char* address :
       {"", "nonsense", ":50051", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:http", "::1:0"}) {
    EXPECT_THROW(Server(axes, address, "0.0.0-test"), std::invalid_argument) << address;
  }
}

TEST_F(ServerTest, RefusesAnAddressOfAnotherHost) {
  EXPECT_THROW(Server(axes, "192.0.2.1:0", "0.0.0-test"), std::runtime_error);
}

TEST_F(ServerTest, EndsOnceShutDown) {
  server->Shutdown(std::chrono::milliseconds(0));
  server->Shutdown(std::chrono::milliseconds(0));
  v1::GetStateResponse response;
  EXPECT_EQ(Call(&Rendering::GetState, *rendering, v1::GetStateRequest(), response).error_code(),
            StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace mwidth::rpc
