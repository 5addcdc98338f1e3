#include "client/cpp/control.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/cpp/client.h"
#include "tests/client/fake_server.h"

namespace mwidth::client {
namespace {

using mwidth::testing::FakeServer;
using ::testing::ElementsAre;

// Long enough for any machine; tests end long before.
constexpr Seconds kPatience{60};

TEST(ControlTest, RendersAMassAndReleasesWhenItGoes) {
  const FakeServer server;
  {
    auto control = Client::Connect(server.address()).AcquireControl("test");
    EXPECT_EQ(control.StartRendering().state(), v1::STATE_RENDERING);
    const auto answer = control.SetMass(-0.05, Seconds(1.5));
    ASSERT_TRUE(std::holds_alternative<v1::SetMassResponse>(answer));
    EXPECT_EQ(std::get<v1::SetMassResponse>(answer).mass(), -0.05);
    EXPECT_EQ(server.LastMass().ramp().seconds(), 1);
    EXPECT_EQ(server.LastMass().ramp().nanos(), 500'000'000);
    EXPECT_EQ(control.StopRendering().state(), v1::STATE_READY);
    EXPECT_EQ(control.ClearFault().state(), v1::STATE_IDLE);
  }
  EXPECT_THAT(server.Calls(), ElementsAre("AcquireControl", "StartRendering", "SetMass", "StopRendering",
                                          "ClearFault", "ReleaseControl"));
}

TEST(ControlTest, WithoutARampTheServersOwnApplies) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  control.SetMass(0.1);
  EXPECT_FALSE(server.LastMass().has_ramp());
}

TEST(ControlTest, ARefusedMassIsAnAnswerWithItsReport) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  const auto answer = control.SetMass(0.8);
  ASSERT_TRUE(std::holds_alternative<Refusal>(answer));
  const auto& refusal = std::get<Refusal>(answer);
  EXPECT_EQ(refusal.reason, "UNSTABLE_MASS");
  EXPECT_EQ(refusal.sentence, "that mass is unstable");
  EXPECT_EQ(refusal.stability.requested_mass(), 0.8);
  EXPECT_EQ(refusal.stability.nearest_admitted_mass(), mwidth::testing::kAdmittedMax);
  EXPECT_EQ(refusal.stability.admitting_cutoff_hz(), 4.5);
  EXPECT_EQ(refusal.status.details_size(), 2);
}

TEST(ControlTest, AMassThatIsNoNumberIsAnError) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  EXPECT_THROW(control.SetMass(std::nan("")), Error);
}

TEST(ControlTest, ValidateMassChangesNothing) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  EXPECT_TRUE(std::holds_alternative<v1::SetMassResponse>(control.ValidateMass(0.1)));
  EXPECT_TRUE(server.LastMass().validate_only());
  EXPECT_TRUE(std::holds_alternative<Refusal>(control.ValidateMass(0.8)));
}

TEST(ControlTest, AFilterIsChangedAndAnsweredWithItsLoop) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  const auto answer = control.SetFilter(v1::ESTIMATOR_KIND_KALMAN, 20);
  ASSERT_TRUE(std::holds_alternative<v1::SetFilterResponse>(answer));
  const auto& response = std::get<v1::SetFilterResponse>(answer);
  EXPECT_EQ(response.loop().estimator(), v1::ESTIMATOR_KIND_KALMAN);
  EXPECT_EQ(response.loop().cutoff_hz(), 20);
  EXPECT_EQ(response.stability().loop().cutoff_hz(), 20);
  EXPECT_FALSE(server.LastFilter().validate_only());
  control.SetFilter(v1::ESTIMATOR_KIND_UNSPECIFIED, 30);
  EXPECT_EQ(server.LastFilter().estimator(), v1::ESTIMATOR_KIND_UNSPECIFIED);
  EXPECT_THAT(server.Calls(), ElementsAre("AcquireControl", "SetFilter", "SetFilter"));
}

TEST(ControlTest, AFilterThatTheMassIsUnstableWithIsAnAnswer) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  control.SetMass(0.1);
  const auto answer = control.SetFilter(v1::ESTIMATOR_KIND_UNSPECIFIED, 100);
  ASSERT_TRUE(std::holds_alternative<Refusal>(answer));
  EXPECT_EQ(std::get<Refusal>(answer).reason, "UNSTABLE_MASS");
  EXPECT_EQ(std::get<Refusal>(answer).stability.requested_mass(), 0.1);
  EXPECT_THROW(control.SetFilter(v1::ESTIMATOR_KIND_UNSPECIFIED, -1), Error);
}

TEST(ControlTest, ValidateFilterChangesNothing) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  EXPECT_TRUE(
      std::holds_alternative<v1::SetFilterResponse>(control.ValidateFilter(v1::ESTIMATOR_KIND_KALMAN, 20)));
  EXPECT_TRUE(server.LastFilter().validate_only());
  EXPECT_TRUE(std::holds_alternative<Refusal>(control.ValidateFilter(v1::ESTIMATOR_KIND_KALMAN, 100)));
  EXPECT_THAT(server.Calls(), ElementsAre("AcquireControl", "ValidateFilter"));
}

TEST(ControlTest, RenewsInTheBackground) {
  FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test", "", Seconds(1));
  EXPECT_TRUE(server.WaitForRenewals(3));
  EXPECT_FALSE(control.Loss().has_value());
}

TEST(ControlTest, ALeaseTakenByAnotherIsLostAtOnceAndNotReleased) {
  FakeServer server;
  server.Behave({.ttl_s = 0.1, .renewal = grpc::Status(grpc::StatusCode::ABORTED, "somebody else has it")});
  {
    auto control = Client::Connect(server.address()).AcquireControl("test");
    EXPECT_TRUE(control.WaitForLoss({}, kPatience));
    ASSERT_TRUE(control.Loss().has_value());
    EXPECT_EQ(control.Loss()->code(), grpc::StatusCode::ABORTED);
  }
  EXPECT_EQ(server.Renewals(), 1);
  EXPECT_THAT(server.Calls(), ElementsAre("AcquireControl"));
}

TEST(ControlTest, AFailedRenewalIsTriedAgainBeforeTheLeaseCountsAsLost) {
  FakeServer server;
  const FakeServer::Behaviour silent{.ttl_s = 3,
                                     .renewal = grpc::Status(grpc::StatusCode::UNAVAILABLE, "no answer")};
  server.Behave(silent);
  auto control = Client::Connect(server.address()).AcquireControl("test");
  ASSERT_TRUE(server.WaitForRenewals(1));
  server.Behave({.ttl_s = 3});
  ASSERT_TRUE(server.WaitForRenewals(2));
  EXPECT_FALSE(control.Loss().has_value());
}

TEST(ControlTest, WithoutAnyAnswerTheLeaseIsLostWhenItsTimeIsOver) {
  FakeServer server;
  server.Behave({.ttl_s = 0.2, .renewal = grpc::Status(grpc::StatusCode::UNAVAILABLE, "no answer")});
  auto control = Client::Connect(server.address()).AcquireControl("test");
  EXPECT_TRUE(control.WaitForLoss({}, kPatience));
  EXPECT_GE(server.Renewals(), 2);
}

TEST(ControlTest, WaitForLossEndsWhenItIsStopped) {
  const FakeServer server;
  auto control = Client::Connect(server.address()).AcquireControl("test");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(control.WaitForLoss(stop.get_token(), kPatience));
}

}  // namespace
}  // namespace mwidth::client
