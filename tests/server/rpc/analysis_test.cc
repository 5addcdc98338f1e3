// Frequency responses and accuracy over a channel.
#include <gmock/gmock.h>

#include <cmath>
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

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

class AnalysisTest : public ServedAxis {
 protected:
  using Stub = v1::StabilityService::Stub;

  grpc::Status Get(const v1::GetFrequencyResponseRequest& request,
                   v1::GetFrequencyResponseResponse& response) {
    return Call(&Stub::GetFrequencyResponse, *stability, request, response);
  }
  grpc::Status Get(const v1::GetAccuracyRequest& request, v1::GetAccuracyResponse& response) {
    return Call(&Stub::GetAccuracy, *stability, request, response);
  }
  /// Expects INVALID_NUMBER of this field.
  template <typename Response, typename Request>
  void ExpectRefused(const Request& request, const std::string& field) {
    Response response;
    const grpc::Status status = Get(request, response);
    ExpectStatus(status, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
    EXPECT_EQ(DetailsOf(status).info.metadata().at("field"), field);
    EXPECT_THAT(status.error_message(), HasSubstr(field));
    EXPECT_FALSE(DetailsOf(status).info.metadata().at("allowed").empty());
  }
};

TEST_F(AnalysisTest, GivesTheFrequencyResponseOfTheSampledLoop) {
  v1::GetMWidthResponse own;
  ASSERT_TRUE(Call(&Stub::GetMWidth, *stability, v1::GetMWidthRequest(), own).ok());
  v1::GetFrequencyResponseRequest request;
  request.set_mass(own.m_width().nominal().max());
  request.set_min_hz(own.m_width().max_critical_hz());
  v1::GetFrequencyResponseResponse response;
  ASSERT_TRUE(Get(request, response).ok());
  EXPECT_EQ(response.frequency_hz_size(), 200);
  EXPECT_EQ(response.magnitude_db_size(), 200);
  EXPECT_EQ(response.phase_deg_size(), 200);
  EXPECT_EQ(response.frequency_hz(199), 500);
  EXPECT_NEAR(response.magnitude_db(0), 0, 1e-9);
  EXPECT_NEAR(std::abs(response.phase_deg(0)), 180, 1e-9);
  EXPECT_EQ(response.loop().SerializeAsString(), own.loop().SerializeAsString());
  EXPECT_NEAR(response.margins().gain_db(), 0, 1e-12);
  EXPECT_NEAR(response.margins().modulus(), 0, 1e-9);
  // At the edge itself nothing settles.
  EXPECT_EQ(response.effective_mass_ratio_size(), 0);
  EXPECT_THAT(response.effective_missing_reason(), HasSubstr("unstable"));
}

TEST_F(AnalysisTest, GivesTheEffectiveRatiosOfAStableMass) {
  v1::GetFrequencyResponseRequest request;
  request.set_mass(0.21);
  request.set_min_hz(0.05);
  request.set_max_hz(20);
  request.set_count(11);
  for (const v1::ResponseModel model : {v1::RESPONSE_MODEL_DISCRETE, v1::RESPONSE_MODEL_CONTINUOUS}) {
    request.set_model(model);
    v1::GetFrequencyResponseResponse response;
    ASSERT_TRUE(Get(request, response).ok());
    EXPECT_EQ(response.effective_mass_ratio_size(), 11);
    EXPECT_EQ(response.effective_damping_ratio_size(), 11);
    EXPECT_NEAR(response.effective_mass_ratio(0), 4, 0.03);
    EXPECT_EQ(response.effective_missing_reason(), "");
    EXPECT_NEAR(response.margins().gain_db(), 20 * std::log10(34.2468304 / 3), 1e-6);
    EXPECT_GT(response.margins().phase_deg(), 0);
    EXPECT_GT(response.margins().delay_s(), 0);
    EXPECT_GT(response.margins().modulus(), 0);
    EXPECT_LT(response.margins().modulus(), 1);
  }
}

TEST_F(AnalysisTest, NamesWhatIsWrongWithAFrequencyResponse) {
  using Request = v1::GetFrequencyResponseRequest;
  const std::vector<std::pair<std::string, std::function<void(Request&)>>> faults = {
      {"mass", [](Request& request) { request.set_mass(kNan); }},
      {"mass", [](Request& request) { request.set_mass(-1.1e6); }},
      {"min_hz", [](Request& request) { request.set_min_hz(-1); }},
      {"min_hz", [](Request& request) { request.set_min_hz(kNan); }},
      {"max_hz", [](Request& request) { request.set_max_hz(500.5); }},
      {"max_hz", [](Request& request) { request.set_max_hz(0.01); }},
      {"max_hz", [](Request& request) { request.set_max_hz(kInf); }},
      {"count", [](Request& request) { request.set_count(1); }},
      {"count", [](Request& request) { request.set_count(10'001); }},
      {"model", [](Request& request) { request.set_model(static_cast<v1::ResponseModel>(7)); }},
      {"model",
       [](Request& request) {
         request.set_model(v1::RESPONSE_MODEL_CONTINUOUS);
         request.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_KALMAN);
       }},
      {"device_mass", [](Request& request) { request.mutable_loop()->set_device_mass(0); }},
  };
  for (const auto& [field, spoil] : faults) {
    Request request;
    spoil(request);
    ExpectRefused<v1::GetFrequencyResponseResponse>(request, field);
  }
}

TEST_F(AnalysisTest, PredictsAndSimulatesFigure9) {
  for (const auto& [mass, error] : {std::pair{0.21, -0.100}, std::pair{-0.035, 0.160}}) {
    v1::GetAccuracyRequest request;
    request.set_mass(mass);
    v1::GetAccuracyResponse response;
    ASSERT_TRUE(Get(request, response).ok());
    EXPECT_NEAR(response.accuracy().error(), error, 0.002);
    EXPECT_FALSE(response.accuracy().has_simulated_error());
    EXPECT_GT(response.accuracy().force_noise(), 0);
    request.set_simulate(true);
    ASSERT_TRUE(Get(request, response).ok());
    EXPECT_NEAR(response.accuracy().simulated_error(), error, 0.002);
    EXPECT_EQ(response.accuracy().unavailable_reason(), "");
  }
}

TEST_F(AnalysisTest, PutsTheBandOfFigure9InPlaceOfWhatIsUnset) {
  v1::GetAccuracyRequest request;
  request.set_mass(0.21);
  v1::GetAccuracyResponse unset;
  ASSERT_TRUE(Get(request, unset).ok());
  request.mutable_band()->set_max_hz(5);
  v1::GetAccuracyResponse same;
  ASSERT_TRUE(Get(request, same).ok());
  EXPECT_EQ(same.SerializeAsString(), unset.SerializeAsString());
  // The duration follows a slow band.
  request.mutable_band()->set_min_hz(0.002);
  EXPECT_TRUE(Get(request, same).ok());
  request.mutable_band()->set_max_hz(50);
  ASSERT_TRUE(Get(request, same).ok());
  EXPECT_LT(same.accuracy().error(), unset.accuracy().error());
}

TEST_F(AnalysisTest, SaysThatAMassIsUnstableInPlaceOfFigures) {
  v1::GetAccuracyRequest request;
  request.set_mass(3);
  request.set_simulate(true);
  v1::GetAccuracyResponse response;
  ASSERT_TRUE(Get(request, response).ok());
  EXPECT_FALSE(response.accuracy().has_perceived_mass());
  EXPECT_FALSE(response.accuracy().has_error());
  EXPECT_FALSE(response.accuracy().has_simulated_error());
  EXPECT_FALSE(response.accuracy().has_force_noise());
  EXPECT_THAT(response.accuracy().unavailable_reason(), HasSubstr("unstable"));
}

TEST_F(AnalysisTest, TellsNoNoiseOfAnAccelerometerThatTheAxisDoesNotHave) {
  v1::GetAccuracyRequest request;
  request.set_mass(0.1);
  request.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_FILTERED_ACCELEROMETER);
  request.mutable_loop()->set_accelerometer_bandwidth_hz(100);
  v1::GetAccuracyResponse response;
  ASSERT_TRUE(Get(request, response).ok());
  EXPECT_TRUE(response.accuracy().has_perceived_mass());
  EXPECT_FALSE(response.accuracy().has_force_noise());
  EXPECT_THAT(response.accuracy().unavailable_reason(), HasSubstr("no accelerometer"));
}

TEST_F(AnalysisTest, NamesWhatIsWrongWithABand) {
  using Request = v1::GetAccuracyRequest;
  const std::vector<std::pair<std::string, std::function<void(Request&)>>> faults = {
      {"mass", [](Request& request) { request.set_mass(kInf); }},
      {"band.min_hz", [](Request& request) { request.mutable_band()->set_min_hz(-0.1); }},
      {"band.min_hz", [](Request& request) { request.mutable_band()->set_min_hz(kNan); }},
      {"band.max_hz", [](Request& request) { request.mutable_band()->set_max_hz(0.05); }},
      {"band.max_hz", [](Request& request) { request.mutable_band()->set_max_hz(501); }},
      {"band.duration_s", [](Request& request) { request.mutable_band()->set_duration_s(9); }},
      {"band.duration_s", [](Request& request) { request.mutable_band()->set_duration_s(10'001); }},
      {"band.duration_s", [](Request& request) { request.mutable_band()->set_duration_s(kNan); }},
      {"band.duration_s", [](Request& request) { request.mutable_band()->set_min_hz(1e-9); }},
      {"hand_stiffness", [](Request& request) { request.mutable_loop()->set_hand_stiffness(-1); }},
  };
  for (const auto& [field, spoil] : faults) {
    Request request;
    spoil(request);
    ExpectRefused<v1::GetAccuracyResponse>(request, field);
  }
}

TEST_F(AnalysisTest, KnowsOnlyItsAxes) {
  v1::GetFrequencyResponseRequest response_request;
  response_request.set_axis("leg");
  v1::GetFrequencyResponseResponse response;
  ExpectStatus(Get(response_request, response), StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
  v1::GetAccuracyRequest accuracy_request;
  accuracy_request.set_axis("leg");
  v1::GetAccuracyResponse accuracy;
  ExpectStatus(Get(accuracy_request, accuracy), StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
}

}  // namespace
}  // namespace mwidth::rpc
