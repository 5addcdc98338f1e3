#include "client/cpp/client.h"

#include <google/protobuf/util/time_util.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include "client/cpp/call.h"
#include "client/cpp/channel_arguments.h"
#include "client/cpp/read_stream.h"

namespace mwidth::client {
namespace {

using std::chrono::system_clock;

bool WaitUntilConnected(grpc::Channel& channel, Seconds timeout) {
  const auto deadline = system_clock::now() + std::chrono::duration_cast<system_clock::duration>(timeout);
  while (true) {
    const auto state = channel.GetState(/*try_to_connect=*/true);
    if (state == GRPC_CHANNEL_READY) {
      return true;
    }
    // Every address has refused: waiting on would only hide it.
    if (state == GRPC_CHANNEL_TRANSIENT_FAILURE || state == GRPC_CHANNEL_SHUTDOWN) {
      return false;
    }
    if (!channel.WaitForStateChange(state, deadline)) {
      return false;
    }
  }
}

}  // namespace

Client Client::Connect(const std::string& address, Seconds timeout) {
  const auto channel =
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), ChannelArguments());
  if (!WaitUntilConnected(*channel, timeout)) {
    throw Error(grpc::Status(grpc::StatusCode::UNAVAILABLE,
                             "no server answers at " + address + "; start mwidthd or check the address"));
  }
  return Client(channel, timeout);
}

Client::Client(const std::shared_ptr<grpc::ChannelInterface>& channel, Seconds call_timeout)
    : rendering_(v1::RenderingService::NewStub(channel)),
      stability_(v1::StabilityService::NewStub(channel)),
      telemetry_(v1::TelemetryService::NewStub(channel)),
      sessions_(v1::SessionService::NewStub(channel)),
      call_timeout_(call_timeout) {}

v1::GetStateResponse Client::State(const std::string& axis) const {
  v1::GetStateRequest request;
  request.set_axis(axis);
  return Call(*rendering_, &v1::RenderingService::StubInterface::GetState, request, call_timeout_);
}

v1::AxisState Client::Axis(const std::string& axis) const {
  auto response = State(axis);
  if (response.axes_size() != 1) {
    std::string names;
    for (const auto& each : response.axes()) {
      names += (names.empty() ? "" : ", ") + each.info().name();
    }
    throw Error(grpc::Status(grpc::StatusCode::NOT_FOUND, "name one of the server's axes: " + names));
  }
  return std::move(*response.mutable_axes(0));
}

v1::GetMWidthResponse Client::MWidth(const std::string& axis, const v1::LoopParameters& overrides,
                                     const std::optional<v1::HandEnvelope>& envelope,
                                     const std::optional<v1::DeviceTolerance>& tolerance) const {
  v1::GetMWidthRequest request;
  request.set_axis(axis);
  *request.mutable_loop() = overrides;
  if (envelope) {
    *request.mutable_envelope() = *envelope;
  }
  if (tolerance) {
    *request.mutable_tolerance() = *tolerance;
  }
  return Call(*stability_, &v1::StabilityService::StubInterface::GetMWidth, request,
              envelope || tolerance ? kAnalysisTimeout : call_timeout_);
}

v1::GetFrequencyResponseResponse Client::FrequencyResponse(
    const v1::GetFrequencyResponseRequest& request) const {
  return Call(*stability_, &v1::StabilityService::StubInterface::GetFrequencyResponse, request,
              call_timeout_);
}

v1::GetAccuracyResponse Client::Accuracy(const v1::GetAccuracyRequest& request) const {
  return Call(*stability_, &v1::StabilityService::StubInterface::GetAccuracy, request,
              request.simulate() ? kAnalysisTimeout : call_timeout_);
}

bool Client::SweepMWidth(const v1::SweepMWidthRequest& request,
                         const std::function<bool(const v1::SweepMWidthResponse&)>& take) const {
  grpc::ClientContext context;
  SetTimeout(context, kAnalysisTimeout);
  const auto reader = stability_->SweepMWidth(&context, request);
  return ReadStream(context, *reader, take);
}

v1::EmergencyStopResponse Client::EmergencyStop(const std::string& reason, const std::string& axis) const {
  v1::EmergencyStopRequest request;
  request.set_axis(axis);
  request.set_reason(reason);
  return Call(*rendering_, &v1::RenderingService::StubInterface::EmergencyStop, request, call_timeout_);
}

Control Client::AcquireControl(const std::string& client_name, const std::string& axis,
                               std::optional<Seconds> ttl) const {
  v1::AcquireControlRequest request;
  request.set_axis(axis);
  request.set_client_name(client_name);
  if (ttl) {
    *request.mutable_ttl() = google::protobuf::util::TimeUtil::NanosecondsToDuration(
        std::chrono::duration_cast<std::chrono::nanoseconds>(*ttl).count());
  }
  const auto sent = std::chrono::steady_clock::now();
  auto response =
      Call(*rendering_, &v1::RenderingService::StubInterface::AcquireControl, request, call_timeout_);
  return Control(rendering_, axis, std::move(*response.mutable_lease()), sent, call_timeout_);
}

SampleStream Client::Stream(const std::string& axis, uint32_t decimation, uint32_t max_batch,
                            uint32_t min_batch, v1::Reduction reduction) const {
  v1::StreamSamplesRequest request;
  request.set_axis(axis);
  request.set_decimation(decimation);
  request.set_max_batch(max_batch);
  request.set_min_batch(min_batch);
  request.set_reduction(reduction);
  return SampleStream(telemetry_, request);
}

}  // namespace mwidth::client
