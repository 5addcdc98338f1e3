#include "client/cpp/client.h"

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include "tests/client/fake_server.h"

namespace mwidth::client {
namespace {

using mwidth::testing::FakeServer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Runs `call` and returns the Error that it throws.
template <typename Function>
Error ErrorOf(Function call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no Error was thrown";
  return Error(grpc::Status(grpc::StatusCode::UNKNOWN, ""));
}

TEST(ClientTest, ConnectFailsAtOnceWhereNobodyListens) {
  std::string address;
  {
    const FakeServer gone;
    address = gone.address();
  }
  const auto error = ErrorOf([&] { Client::Connect(address, Seconds(60)); });
  EXPECT_EQ(error.code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(error.what(), HasSubstr(address));
  EXPECT_FALSE(error.DeclinedByServer());
}

TEST(ClientTest, ReadsTheStateOfTheOnlyAxis) {
  const FakeServer server;
  const auto client = Client::Connect(server.address());
  EXPECT_EQ(client.State().server_version(), "9.9.9");
  EXPECT_EQ(client.Axis().info().name(), "elbow");
}

TEST(ClientTest, UnknownAxisIsAnErrorWithTheServersReason) {
  const FakeServer server;
  const auto client = Client::Connect(server.address());
  const auto error = ErrorOf([&] { client.State("knee"); });
  EXPECT_EQ(error.code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(error.reason(), "UNKNOWN_AXIS");
  EXPECT_TRUE(error.DeclinedByServer());
}

TEST(ClientTest, MWidthSendsOnlyTheOverridesThatAreSet) {
  const FakeServer server;
  const auto client = Client::Connect(server.address());
  v1::LoopParameters overrides;
  overrides.set_hand_stiffness(0);
  const auto response = client.MWidth("", overrides);
  EXPECT_TRUE(server.LastMWidth().loop().has_hand_stiffness());
  EXPECT_FALSE(server.LastMWidth().loop().has_cutoff_hz());
  EXPECT_EQ(response.loop().hand_stiffness(), 0);
  EXPECT_EQ(response.m_width().nominal().max(), 0.5);
}

TEST(ClientTest, MWidthSendsAnEnvelopeOnlyWhereOneIsGiven) {
  const FakeServer server;
  const auto client = Client::Connect(server.address());
  client.MWidth();
  EXPECT_FALSE(server.LastMWidth().has_envelope());
  EXPECT_FALSE(server.LastMWidth().has_tolerance());
  // An envelope without a range is one all the same: any hand like the axis's own.
  client.MWidth("", {}, v1::HandEnvelope());
  EXPECT_TRUE(server.LastMWidth().has_envelope());
  EXPECT_FALSE(server.LastMWidth().has_tolerance());
  v1::DeviceTolerance tolerance;
  tolerance.mutable_mass()->set_max(0.06);
  client.MWidth("", {}, std::nullopt, tolerance);
  EXPECT_FALSE(server.LastMWidth().has_envelope());
  EXPECT_EQ(server.LastMWidth().tolerance().mass().max(), 0.06);
}

TEST(ClientTest, EmergencyStopNeedsNoLeaseAndCarriesItsReason) {
  const FakeServer server;
  const auto stopped = Client::Connect(server.address()).EmergencyStop("strap came loose");
  EXPECT_THAT(stopped.states(), ElementsAre(v1::STATE_FAULT));
  EXPECT_THAT(stopped.axes(), ElementsAre("elbow"));
  EXPECT_EQ(server.StopReason(), "strap came loose");
}

TEST(ClientTest, ControlHeldByAnotherIsAnErrorWithItsReason) {
  FakeServer server;
  server.Behave({.held_by_another = true});
  const auto client = Client::Connect(server.address());
  const auto error = ErrorOf([&] { client.AcquireControl("test"); });
  EXPECT_EQ(error.code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(error.reason(), "CONTROL_HELD");
}

TEST(ClientTest, WorksOverAChannelOfTheCallersMaking) {
  const FakeServer server;
  const Client client(grpc::CreateChannel(server.address(), grpc::InsecureChannelCredentials()));
  EXPECT_EQ(client.Axis("elbow").info().name(), "elbow");
}

}  // namespace
}  // namespace mwidth::client
