#include "server/rpc/stability_service.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using grpc::StatusCode;
using testing::HasSubstr;

class StabilityServiceTest : public ServedAxis {
 protected:
  grpc::Status GetMWidth(const v1::LoopParameters& loop, v1::GetMWidthResponse& response) {
    v1::GetMWidthRequest request;
    *request.mutable_loop() = loop;
    return Call(&v1::StabilityService::Stub::GetMWidth, *stability, request, response);
  }
};

TEST_F(StabilityServiceTest, GivesTheMWidthOfThePaper) {
  v1::GetMWidthResponse response;
  ASSERT_TRUE(GetMWidth({}, response).ok());
  const double mass = response.loop().device_mass();
  EXPECT_NEAR(response.m_width().nominal().min() / mass, -1.3981549, 5e-8);
  EXPECT_NEAR(response.m_width().nominal().max() / mass, 34.2468304, 5e-8);
  EXPECT_EQ(response.m_width().robust().max(), response.m_width().nominal().max());
  EXPECT_NEAR(response.m_width().admitted().max() / response.m_width().robust().max(), 0.70794578438, 1e-10);
  EXPECT_EQ(response.m_width().required_gain_margin_db(), 3);
}

TEST_F(StabilityServiceTest, OverridesWhatIsSetAndNothingElse) {
  v1::LoopParameters loop;
  loop.set_period_s(2e-3);
  loop.set_cutoff_hz(30);
  v1::GetMWidthResponse response;
  ASSERT_TRUE(GetMWidth(loop, response).ok());
  EXPECT_NEAR(response.m_width().nominal().min() / 0.07, -0.8516775, 5e-8);
  EXPECT_NEAR(response.m_width().nominal().max() / 0.07, 6.7990892, 5e-8);
  EXPECT_EQ(response.loop().period_s(), 2e-3);
  EXPECT_EQ(response.loop().hand_stiffness(), 700);
}

TEST_F(StabilityServiceTest, OverridesEachParameter) {
  using Loop = v1::LoopParameters;
  const std::vector<std::function<void(Loop&)>> setters = {
      [](Loop& loop) { loop.set_device_mass(0.1); },    [](Loop& loop) { loop.set_device_damping(0.5); },
      [](Loop& loop) { loop.set_hand_mass(0.2); },      [](Loop& loop) { loop.set_hand_damping(9); },
      [](Loop& loop) { loop.set_hand_stiffness(300); }, [](Loop& loop) { loop.set_period_s(5e-4); },
      [](Loop& loop) { loop.set_cutoff_hz(20); },       [](Loop& loop) { loop.set_delay_s(1e-3); }};
  v1::GetMWidthResponse own;
  ASSERT_TRUE(GetMWidth({}, own).ok());
  for (const auto& set : setters) {
    Loop overrides;
    set(overrides);
    Loop expected = own.loop();
    set(expected);
    v1::GetMWidthResponse response;
    ASSERT_TRUE(GetMWidth(overrides, response).ok());
    EXPECT_EQ(response.loop().SerializeAsString(), expected.SerializeAsString());
    EXPECT_NE(response.m_width().nominal().max(), own.m_width().nominal().max());
  }
}

TEST_F(StabilityServiceTest, NamesTheParameterThatIsOutOfRange) {
  v1::LoopParameters loop;
  loop.set_cutoff_hz(501);
  v1::GetMWidthResponse response;
  const grpc::Status refused = GetMWidth(loop, response);
  ExpectStatus(refused, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_THAT(refused.error_message(), HasSubstr("cutoff_hz"));
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("field"), "cutoff_hz");
  loop.set_cutoff_hz(std::numeric_limits<double>::quiet_NaN());
  ExpectStatus(GetMWidth(loop, response), StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
}

TEST_F(StabilityServiceTest, GivesAReasonInPlaceOfARangeWhereNothingDamps) {
  v1::LoopParameters loop;
  loop.set_device_damping(0);
  loop.set_hand_damping(0);
  v1::GetMWidthResponse response;
  ASSERT_TRUE(GetMWidth(loop, response).ok());
  EXPECT_TRUE(response.m_width().nominal().empty());
  EXPECT_TRUE(response.m_width().admitted().empty());
  EXPECT_FALSE(response.m_width().nominal().empty_reason().empty());
  EXPECT_EQ(response.m_width().nominal().max(), 0);
}

TEST_F(StabilityServiceTest, ProvesTheRobustIntervalOfAnEnvelope) {
  v1::GetMWidthRequest request;
  request.mutable_envelope()->mutable_stiffness()->set_min(100);
  request.mutable_envelope()->mutable_stiffness()->set_max(2000);
  request.mutable_envelope()->set_include_released_hand(true);
  v1::GetMWidthResponse response;
  ASSERT_TRUE(Call(&v1::StabilityService::Stub::GetMWidth, *stability, request, response).ok());
  const v1::MWidth& m_width = response.m_width();
  EXPECT_GT(m_width.robust().min(), m_width.nominal().min());
  EXPECT_LT(m_width.robust().max(), m_width.nominal().max());
  // A negative mass suffers most from the hand that has let go: it damps nothing.
  EXPECT_EQ(m_width.min_binding().hand_stiffness(), 0);
  EXPECT_EQ(m_width.min_binding().hand_damping(), 0);
  // The edge of the loop that binds, to half a percent.
  v1::GetMWidthResponse binding;
  ASSERT_TRUE(GetMWidth(m_width.min_binding(), binding).ok());
  EXPECT_NEAR(m_width.robust().min() / binding.m_width().nominal().min(), 1, 0.01);
  // A tolerance alone leaves the hand the loop's own.
  request.clear_envelope();
  request.mutable_tolerance()->mutable_mass()->set_min(0.06);
  request.mutable_tolerance()->mutable_mass()->set_max(0.08);
  ASSERT_TRUE(Call(&v1::StabilityService::Stub::GetMWidth, *stability, request, response).ok());
  EXPECT_EQ(response.m_width().max_binding().hand_stiffness(), 700);
  EXPECT_LT(response.m_width().robust().max(), response.m_width().nominal().max());
}

TEST_F(StabilityServiceTest, NamesTheRangeThatIsEmptyOrNotAllowed) {
  using Envelope = v1::HandEnvelope;
  const std::vector<std::pair<std::string, std::function<void(Envelope&)>>> faults = {
      {"hand_stiffness", [](Envelope& hand) { hand.mutable_stiffness()->set_min(1); }},
      {"hand_stiffness", [](Envelope& hand) { hand.mutable_stiffness()->set_max(1e7); }},
      {"hand_damping", [](Envelope& hand) { hand.mutable_damping()->set_min(-1); }},
      {"hand_mass",
       [](Envelope& hand) { hand.mutable_mass()->set_max(std::numeric_limits<double>::quiet_NaN()); }},
  };
  for (const auto& [field, spoil] : faults) {
    v1::GetMWidthRequest request;
    spoil(*request.mutable_envelope());
    v1::GetMWidthResponse response;
    const grpc::Status refused = Call(&v1::StabilityService::Stub::GetMWidth, *stability, request, response);
    ExpectStatus(refused, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
    EXPECT_EQ(DetailsOf(refused).info.metadata().at("field"), field);
  }
}

TEST_F(StabilityServiceTest, KnowsEveryEstimator) {
  double previous = 0;
  for (int kind = 1; kind <= 6; ++kind) {
    v1::LoopParameters loop;
    loop.set_estimator(static_cast<v1::EstimatorKind>(kind));
    loop.set_accelerometer_bandwidth_hz(100);
    v1::GetMWidthResponse response;
    ASSERT_TRUE(GetMWidth(loop, response).ok()) << kind;
    EXPECT_EQ(response.loop().estimator(), kind);
    EXPECT_GT(response.m_width().nominal().max(), 0);
    EXPECT_NE(response.m_width().nominal().max(), previous);
    previous = response.m_width().nominal().max();
  }
  v1::LoopParameters loop;
  loop.set_estimator(static_cast<v1::EstimatorKind>(7));
  v1::GetMWidthResponse response;
  const grpc::Status refused = GetMWidth(loop, response);
  ExpectStatus(refused, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("field"), "estimator");
}

TEST_F(StabilityServiceTest, NeedsTheBandwidthOfAnAccelerometer) {
  v1::LoopParameters loop;
  loop.set_estimator(v1::ESTIMATOR_KIND_FILTERED_ACCELEROMETER);
  v1::GetMWidthResponse response;
  const grpc::Status refused = GetMWidth(loop, response);
  ExpectStatus(refused, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("field"), "accelerometer_bandwidth_hz");
}

TEST_F(StabilityServiceTest, KnowsOnlyItsAxes) {
  v1::GetMWidthRequest request;
  request.set_axis("leg");
  v1::GetMWidthResponse response;
  ExpectStatus(Call(&v1::StabilityService::Stub::GetMWidth, *stability, request, response),
               StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
}

}  // namespace
}  // namespace mwidth::rpc
