#include "server/rpc/rendering_service.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <cmath>
#include <limits>

#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using grpc::StatusCode;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class RenderingServiceTest : public ServedAxis {};

TEST_F(RenderingServiceTest, DescribesAnAxisAndWhatItDoes) {
  Render(0.5);
  const v1::AxisState state = State();
  EXPECT_EQ(state.info().name(), "arm");
  EXPECT_EQ(state.info().kind(), v1::AXIS_KIND_LINEAR);
  EXPECT_EQ(state.info().loop().hand_stiffness(), 700);
  EXPECT_TRUE(state.info().loop().has_delay_s());
  EXPECT_EQ(state.info().mass_max(), 50);
  EXPECT_EQ(state.state(), v1::STATE_RENDERING);
  EXPECT_EQ(state.target_mass(), 0.5);
  EXPECT_EQ(state.controller(), "test");
  EXPECT_TRUE(state.realtime());
  EXPECT_FALSE(state.has_fault());
  EXPECT_LT(state.m_width().admitted().max(), state.m_width().nominal().max());
  EXPECT_GT(state.tick(), 0U);
}

TEST_F(RenderingServiceTest, GrantsALeaseWithItsTimeToLive) {
  v1::AcquireControlRequest request;
  request.mutable_ttl()->set_seconds(2);
  request.mutable_ttl()->set_nanos(500'000'000);
  v1::AcquireControlResponse response;
  ASSERT_TRUE(Call(&Rendering::AcquireControl, *rendering, request, response).ok());
  EXPECT_EQ(response.lease().lease_id().size(), 32U);
  EXPECT_EQ(response.lease().ttl().seconds(), 2);
  EXPECT_EQ(response.lease().ttl().nanos(), 500'000'000);
  EXPECT_TRUE(response.lease().has_expire_time());

  v1::RenewControlRequest renew;
  renew.set_lease_id(response.lease().lease_id());
  v1::RenewControlResponse renewed;
  ASSERT_TRUE(Call(&Rendering::RenewControl, *rendering, renew, renewed).ok());
  EXPECT_EQ(renewed.lease().lease_id(), response.lease().lease_id());
  EXPECT_EQ(renewed.lease().ttl().seconds(), 2);
}

TEST_F(RenderingServiceTest, RefusesATimeToLiveOutOfRange) {
  for (const int64_t seconds : {int64_t{0}, int64_t{61}, int64_t{-1}, std::numeric_limits<int64_t>::max()}) {
    v1::AcquireControlRequest request;
    request.mutable_ttl()->set_seconds(seconds);
    v1::AcquireControlResponse response;
    ExpectStatus(Call(&Rendering::AcquireControl, *rendering, request, response),
                 StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  }
}

TEST_F(RenderingServiceTest, RefusesControlToASecondClientThatMayStillWatch) {
  const std::string lease = Acquire("first");
  const auto other = v1::RenderingService::NewStub(channel);
  v1::AcquireControlRequest request;
  request.set_client_name("second");
  v1::AcquireControlResponse response;
  const grpc::Status refused = Call(&Rendering::AcquireControl, *other, request, response);
  ExpectStatus(refused, StatusCode::FAILED_PRECONDITION, "CONTROL_HELD");
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("holder"), "first");
  EXPECT_EQ(State().controller(), "first");
  EXPECT_TRUE(SetMass(lease, 0.1).ok());
}

TEST_F(RenderingServiceTest, AnswersASetMassWithItsStability) {
  v1::SetMassRequest request;
  request.set_lease_id(Acquire());
  request.set_mass(-0.03);
  v1::SetMassResponse response;
  ASSERT_TRUE(Call(&Rendering::SetMass, *rendering, request, response).ok());
  EXPECT_EQ(response.mass(), -0.03);
  EXPECT_GT(response.stability().gain_margin_db(), 3);
  EXPECT_NEAR(response.stability().margins().gain_db(), response.stability().gain_margin_db(), 1e-9);
  EXPECT_GT(response.stability().margins().phase_deg(), 0);
  EXPECT_GT(response.stability().margins().delay_s(), 0);
  EXPECT_GT(response.stability().margins().modulus(), 0);
  EXPECT_NEAR(response.accuracy().ideal_mass(), 0.04, 1e-15);
  EXPECT_GT(response.accuracy().error(), 0);
  EXPECT_GT(response.accuracy().force_noise(), 0);
  EXPECT_GT(response.tick(), 0U);
  request.set_validate_only(true);
  ASSERT_TRUE(Call(&Rendering::SetMass, *rendering, request, response).ok());
  EXPECT_EQ(response.tick(), 0U);
}

TEST_F(RenderingServiceTest, RefusesAnUnstableMassWithTheReportAndLeavesTheOldOne) {
  const std::string lease = Render(0.5);
  const grpc::Status refused = SetMass(lease, 40);
  ExpectStatus(refused, StatusCode::FAILED_PRECONDITION, "UNSTABLE_MASS");
  EXPECT_THAT(refused.error_message(), HasSubstr("Ask for"));
  const Details details = DetailsOf(refused);
  ASSERT_TRUE(details.report.has_value());
  EXPECT_EQ(details.report->requested_mass(), 40);
  EXPECT_LT(details.report->gain_margin_db(), 0);
  EXPECT_EQ(details.report->loop().cutoff_hz(), 10);
  EXPECT_EQ(State().mass(), 0.5);
  EXPECT_TRUE(SetMass(lease, details.report->nearest_admitted_mass()).ok());
}

TEST_F(RenderingServiceTest, ChangesTheFilterAndFromThenOnEverythingThatFollowsFromIt) {
  v1::SetFilterRequest request;
  request.set_lease_id(Render(0.1));
  request.set_cutoff_hz(20);
  request.set_validate_only(true);
  v1::SetFilterResponse response;
  ASSERT_TRUE(Call(&Rendering::SetFilter, *rendering, request, response).ok());
  EXPECT_EQ(response.tick(), 0U);
  EXPECT_EQ(response.loop().cutoff_hz(), 20);
  EXPECT_EQ(State().info().loop().cutoff_hz(), 10);

  const v1::MWidth before = State().m_width();
  request.set_validate_only(false);
  request.set_estimator(v1::ESTIMATOR_KIND_BUTTERWORTH);
  ASSERT_TRUE(Call(&Rendering::SetFilter, *rendering, request, response).ok());
  EXPECT_GT(response.tick(), 0U);
  EXPECT_EQ(response.loop().estimator(), v1::ESTIMATOR_KIND_BUTTERWORTH);
  EXPECT_EQ(response.stability().requested_mass(), 0.1);
  const v1::AxisState after = State();
  EXPECT_EQ(after.info().loop().SerializeAsString(), response.loop().SerializeAsString());
  EXPECT_NE(after.m_width().nominal().max(), before.nominal().max());
  v1::GetMWidthResponse own;
  ASSERT_TRUE(Call(&v1::StabilityService::Stub::GetMWidth, *stability, v1::GetMWidthRequest(), own).ok());
  EXPECT_EQ(own.loop().SerializeAsString(), response.loop().SerializeAsString());
  EXPECT_EQ(own.m_width().SerializeAsString(), after.m_width().SerializeAsString());

  // Unspecified: the running estimator.
  request.clear_estimator();
  request.set_cutoff_hz(15);
  ASSERT_TRUE(Call(&Rendering::SetFilter, *rendering, request, response).ok());
  EXPECT_EQ(response.loop().estimator(), v1::ESTIMATOR_KIND_BUTTERWORTH);
}

TEST_F(RenderingServiceTest, RefusesAFilterThatIsNoneOrThatTheMassIsNotStableWith) {
  v1::SetFilterRequest request;
  request.set_lease_id(Render(1.5));
  request.set_cutoff_hz(100);
  v1::SetFilterResponse response;
  const grpc::Status unstable = Call(&Rendering::SetFilter, *rendering, request, response);
  ExpectStatus(unstable, StatusCode::FAILED_PRECONDITION, "UNSTABLE_MASS");
  EXPECT_EQ(DetailsOf(unstable).report->loop().cutoff_hz(), 100);
  for (const double cutoff_hz : {0.0, -1.0, 501.0, kNan}) {
    request.set_cutoff_hz(cutoff_hz);
    ExpectStatus(Call(&Rendering::SetFilter, *rendering, request, response), StatusCode::INVALID_ARGUMENT,
                 "INVALID_NUMBER");
  }
  request.set_cutoff_hz(10);
  request.set_estimator(static_cast<v1::EstimatorKind>(9));
  const grpc::Status unknown = Call(&Rendering::SetFilter, *rendering, request, response);
  ExpectStatus(unknown, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_EQ(DetailsOf(unknown).info.metadata().at("field"), "estimator");
  request.clear_estimator();
  request.set_lease_id("0123456789abcdef0123456789abcdef");
  ExpectStatus(Call(&Rendering::SetFilter, *rendering, request, response), StatusCode::FAILED_PRECONDITION,
               "NO_LEASE");
  EXPECT_EQ(State().info().loop().cutoff_hz(), 10);
  EXPECT_EQ(State().mass(), 1.5);
}

TEST_F(RenderingServiceTest, RefusesNumbersThatAreNoneOrOutOfRange) {
  const std::string lease = Render(0.5);
  for (const double mass : {kNan, kInf, -kInf}) {
    ExpectStatus(SetMass(lease, mass), StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  }
  ExpectStatus(SetMass(lease, 51), StatusCode::INVALID_ARGUMENT, "MASS_LIMIT");
  v1::SetMassRequest request;
  request.set_lease_id(lease);
  request.mutable_ramp()->set_seconds(11);
  v1::SetMassResponse response;
  ExpectStatus(Call(&Rendering::SetMass, *rendering, request, response), StatusCode::INVALID_ARGUMENT,
               "INVALID_NUMBER");
  EXPECT_EQ(State().mass(), 0.5);
  EXPECT_EQ(State().state(), v1::STATE_RENDERING);
}

TEST_F(RenderingServiceTest, RefusesCommandsWithoutALease) {
  ExpectStatus(SetMass("", 0.1), StatusCode::FAILED_PRECONDITION, "NO_LEASE");
  ExpectStatus(Start("0123456789abcdef0123456789abcdef"), StatusCode::FAILED_PRECONDITION, "NO_LEASE");
}

TEST_F(RenderingServiceTest, EndsRenderingWhenTheLeaseIsLost) {
  const std::string lease = Render(0.5);
  axis.AdvanceS(1);
  ExpectStatus(SetMass(lease, 0.1), StatusCode::FAILED_PRECONDITION, "NO_LEASE");
  const std::string other = Acquire("other");
  ExpectStatus(SetMass(lease, 0.1), StatusCode::ABORTED, "LEASE_LOST");
  v1::StopRenderingRequest request;
  request.set_lease_id(other);
  v1::StopRenderingResponse response;
  ASSERT_TRUE(Call(&Rendering::StopRendering, *rendering, request, response).ok());
  EXPECT_EQ(response.state(), v1::STATE_READY);
  EXPECT_EQ(State().mass(), 0);
}

TEST_F(RenderingServiceTest, StopsAndReleases) {
  const std::string lease = Render(0.5);
  ExpectStatus(Start(lease), StatusCode::FAILED_PRECONDITION, "WRONG_STATE");
  v1::ReleaseControlRequest request;
  request.set_lease_id(lease);
  v1::ReleaseControlResponse response;
  ASSERT_TRUE(Call(&Rendering::ReleaseControl, *rendering, request, response).ok());
  EXPECT_EQ(State().state(), v1::STATE_READY);
  EXPECT_EQ(State().controller(), "");
}

TEST_F(RenderingServiceTest, StopsInAnEmergencyWithoutALeaseUntilCleared) {
  const std::string lease = Render(0.5);
  v1::EmergencyStopRequest stop;
  stop.set_reason("line one\nline two" + std::string(1000, 'x'));
  v1::EmergencyStopResponse stopped;
  ASSERT_TRUE(Call(&Rendering::EmergencyStop, *rendering, stop, stopped).ok());
  EXPECT_THAT(stopped.states(), ElementsAre(v1::STATE_FAULT));
  EXPECT_EQ(State().fault().kind(), v1::FAULT_KIND_EMERGENCY_STOP);
  ExpectStatus(SetMass(lease, 0.1), StatusCode::FAILED_PRECONDITION, "WRONG_STATE");

  v1::ClearFaultRequest clear;
  v1::ClearFaultResponse cleared;
  ExpectStatus(Call(&Rendering::ClearFault, *rendering, clear, cleared), StatusCode::FAILED_PRECONDITION,
               "NO_LEASE");
  clear.set_lease_id(lease);
  ASSERT_TRUE(Call(&Rendering::ClearFault, *rendering, clear, cleared).ok());
  EXPECT_EQ(cleared.state(), v1::STATE_IDLE);
}

TEST_F(RenderingServiceTest, TellsAFaultWithItsFigures) {
  axis.Trip(exchange::Fault::kVelocityLimit);
  while (State().state() != v1::STATE_FAULT) {
  }
  EXPECT_EQ(State().fault().kind(), v1::FAULT_KIND_VELOCITY_LIMIT);
  EXPECT_THAT(State().fault().message(), HasSubstr("clear the fault"));
}

TEST_F(RenderingServiceTest, RefusesAnUnknownAxis) {
  v1::GetStateRequest request;
  request.set_axis("leg");
  v1::GetStateResponse response;
  const grpc::Status refused = Call(&Rendering::GetState, *rendering, request, response);
  ExpectStatus(refused, StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
  EXPECT_THAT(refused.error_message(), HasSubstr("arm"));
  v1::SetMassRequest set;
  set.set_axis("leg");
  v1::SetMassResponse grant;
  ExpectStatus(Call(&Rendering::SetMass, *rendering, set, grant), StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
}

TEST_F(RenderingServiceTest, ReportsALoopThatDoesNotAnswer) {
  const std::string lease = Acquire();
  axis.Silence();
  ExpectStatus(SetMass(lease, 0.1), StatusCode::UNAVAILABLE, "LOOP_SILENT");
}

class TwoAxesTest : public ServedAxis {
 protected:
  TwoAxesTest() {
    // A server's axes are fixed once it runs: a second server for both.
    both.Add(axis.Registered());
    both.Add(leg.Registered());
    server_of_both = std::make_unique<Server>(both, "127.0.0.1:0", "0.0.0-test");
    stub = v1::RenderingService::NewStub(
        grpc::CreateChannel(server_of_both->address(), grpc::InsecureChannelCredentials()));
  }

  TickingAxis leg{"leg"};
  AxisRegistry both;
  std::unique_ptr<Server> server_of_both;
  std::unique_ptr<Rendering> stub;
};

TEST_F(TwoAxesTest, ShowsBothAndAsksWhichOneToCommand) {
  v1::GetStateResponse response;
  ASSERT_TRUE(Call(&Rendering::GetState, *stub, v1::GetStateRequest(), response).ok());
  ASSERT_EQ(response.axes_size(), 2);
  EXPECT_EQ(response.axes(0).info().name(), "arm");
  EXPECT_EQ(response.axes(1).info().name(), "leg");
  v1::AcquireControlRequest request;
  v1::AcquireControlResponse lease;
  const grpc::Status refused = Call(&Rendering::AcquireControl, *stub, request, lease);
  ExpectStatus(refused, StatusCode::INVALID_ARGUMENT, "AMBIGUOUS_AXIS");
  EXPECT_THAT(refused.error_message(), HasSubstr("arm, leg"));
  request.set_axis("leg");
  EXPECT_TRUE(Call(&Rendering::AcquireControl, *stub, request, lease).ok());
}

TEST_F(TwoAxesTest, StopsBothInAnEmergencyWhicheverIsNamed) {
  uint64_t stops = 0;
  for (const std::string name : {"", "arm", "leg", "no such axis"}) {
    ++stops;
    v1::EmergencyStopRequest stop;
    stop.set_axis(name);
    v1::EmergencyStopResponse stopped;
    ASSERT_TRUE(Call(&Rendering::EmergencyStop, *stub, stop, stopped).ok()) << name;
    EXPECT_THAT(stopped.axes(), ElementsAre("arm", "leg")) << name;
    EXPECT_THAT(stopped.states(), ElementsAre(v1::STATE_FAULT, v1::STATE_FAULT)) << name;
    EXPECT_EQ(axis.Status().fault.number, stops) << name;
    EXPECT_EQ(leg.Status().fault.number, stops) << name;
  }
}

TEST_F(TwoAxesTest, StopsTheOneInAnEmergencyWhereTheOtherIsSilentAndTellsWhichIsWhich) {
  axis.Silence();
  v1::EmergencyStopRequest stop;
  stop.set_axis("arm");
  v1::EmergencyStopResponse stopped;
  const grpc::Status refused = Call(&Rendering::EmergencyStop, *stub, stop, stopped);
  ExpectStatus(refused, StatusCode::UNAVAILABLE, "LOOP_SILENT");
  EXPECT_THAT(refused.error_message(), HasSubstr("Not known to have stopped: arm. Stopped: leg."));
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("silent_axes"), "arm");
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("stopped_axes"), "leg");
  EXPECT_EQ(leg.Status().state, exchange::State::kFault);
}

}  // namespace
}  // namespace mwidth::rpc
