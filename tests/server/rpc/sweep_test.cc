// SweepMWidth over a channel.
#include <gmock/gmock.h>
#include <grpcpp/support/sync_stream.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/rpc/stability_service.h"
#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using grpc::StatusCode;

/// One call of SweepMWidth.
class SweepCall {
 public:
  SweepCall(v1::StabilityService::Stub& stub, const v1::SweepMWidthRequest& request) {
    context_.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    reader_ = stub.SweepMWidth(&context_, request);
  }
  bool Read(v1::SweepMWidthResponse& row) { return reader_->Read(&row); }
  void Cancel() { context_.TryCancel(); }
  grpc::Status Finish() {
    v1::SweepMWidthResponse row;
    while (reader_->Read(&row)) {
    }
    return reader_->Finish();
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::SweepMWidthResponse>> reader_;
};

class SweepTest : public ServedAxis {
 protected:
  using Stub = v1::StabilityService::Stub;

  static void Fill(v1::SweepRange& range, v1::SweepParameter parameter, double min, double max,
                   uint32_t count) {
    range.set_parameter(parameter);
    range.set_min(min);
    range.set_max(max);
    range.set_count(count);
  }

  /// Damping by stiffness of the hand.
  static v1::SweepMWidthRequest Hands(uint32_t columns, uint32_t rows) {
    v1::SweepMWidthRequest request;
    Fill(*request.mutable_x(), v1::SWEEP_PARAMETER_HAND_DAMPING, 1, 20, columns);
    Fill(*request.mutable_y(), v1::SWEEP_PARAMETER_HAND_STIFFNESS, 10, 5000, rows);
    request.mutable_y()->set_logarithmic(true);
    return request;
  }

  /// A sweep whose rows do not fit into the buffers of a client that does not read: it goes on until
  /// cancelled.
  static v1::SweepMWidthRequest Long() { return Hands(10'000, 100); }

  v1::Interval Nominal(const v1::LoopParameters& overrides) {
    v1::GetMWidthRequest request;
    *request.mutable_loop() = overrides;
    v1::GetMWidthResponse response;
    EXPECT_TRUE(Call(&Stub::GetMWidth, *stability, request, response).ok());
    return response.m_width().nominal();
  }
};

TEST_F(SweepTest, StreamsConsecutiveRowsThatAgreeWithGetMWidth) {
  v1::SweepMWidthRequest request = Hands(5, 4);
  request.mutable_loop()->set_delay_s(5e-4);
  SweepCall call(*stability, request);
  v1::SweepMWidthResponse row;
  for (uint32_t next = 0; next < 4; ++next) {
    ASSERT_TRUE(call.Read(row));
    EXPECT_EQ(row.row(), next);
    EXPECT_EQ(row.row_count(), 4U);
    ASSERT_EQ(row.x_size(), 5);
    ASSERT_EQ(row.min_size(), 5);
    ASSERT_EQ(row.max_size(), 5);
    for (int i = 0; i < 5; ++i) {
      EXPECT_NEAR(row.x(i), 1 + 4.75 * i, 1e-12);
      v1::LoopParameters loop = request.loop();
      loop.set_hand_damping(row.x(i));
      loop.set_hand_stiffness(row.y());
      const v1::Interval nominal = Nominal(loop);
      EXPECT_EQ(row.min(i), nominal.min());
      EXPECT_EQ(row.max(i), nominal.max());
    }
  }
  EXPECT_EQ(row.y(), 5000);
  EXPECT_FALSE(call.Read(row));
  EXPECT_TRUE(call.Finish().ok());
}

TEST_F(SweepTest, SweepsEachParameterInARowOfItsOwn) {
  const std::vector<std::pair<v1::SweepParameter, std::function<void(v1::LoopParameters&, double)>>>
      parameters = {
          {v1::SWEEP_PARAMETER_DEVICE_MASS, [](auto& loop, double value) { loop.set_device_mass(value); }},
          {v1::SWEEP_PARAMETER_DEVICE_DAMPING,
           [](auto& loop, double value) { loop.set_device_damping(value); }},
          {v1::SWEEP_PARAMETER_HAND_MASS, [](auto& loop, double value) { loop.set_hand_mass(value); }},
          {v1::SWEEP_PARAMETER_HAND_DAMPING, [](auto& loop, double value) { loop.set_hand_damping(value); }},
          {v1::SWEEP_PARAMETER_HAND_STIFFNESS,
           [](auto& loop, double value) { loop.set_hand_stiffness(value); }},
          {v1::SWEEP_PARAMETER_PERIOD_S, [](auto& loop, double value) { loop.set_period_s(value); }},
          {v1::SWEEP_PARAMETER_CUTOFF_HZ, [](auto& loop, double value) { loop.set_cutoff_hz(value); }},
          {v1::SWEEP_PARAMETER_DELAY_S, [](auto& loop, double value) { loop.set_delay_s(value); }}};
  static_assert(v1::SweepParameter_MAX == v1::SWEEP_PARAMETER_ACCELEROMETER_BANDWIDTH_HZ);  // below
  for (const auto& [parameter, set] : parameters) {
    v1::SweepMWidthRequest request;
    Fill(*request.mutable_x(), parameter, 1e-3, 3e-3, 2);
    SweepCall call(*stability, request);
    v1::SweepMWidthResponse row;
    ASSERT_TRUE(call.Read(row)) << parameter;
    EXPECT_EQ(row.row_count(), 1U);
    EXPECT_EQ(row.y(), 0);
    v1::LoopParameters loop;
    set(loop, 3e-3);
    EXPECT_EQ(row.max(1), Nominal(loop).max()) << parameter;
    EXPECT_NE(row.max(1), row.max(0)) << parameter;
    EXPECT_TRUE(call.Finish().ok());
  }
}

TEST_F(SweepTest, SweepsTheBandwidthOfAnAccelerometerAlone) {
  v1::SweepMWidthRequest request;
  Fill(*request.mutable_x(), v1::SWEEP_PARAMETER_ACCELEROMETER_BANDWIDTH_HZ, 10, 300, 2);
  request.mutable_loop()->set_estimator(v1::ESTIMATOR_KIND_ACCELEROMETER);
  SweepCall call(*stability, request);
  v1::SweepMWidthResponse row;
  ASSERT_TRUE(call.Read(row));
  v1::LoopParameters loop = request.loop();
  loop.set_accelerometer_bandwidth_hz(300);
  EXPECT_EQ(row.max(1), Nominal(loop).max());
  EXPECT_LT(row.max(1), row.max(0));
  EXPECT_TRUE(call.Finish().ok());
}

TEST_F(SweepTest, NamesWhatIsWrong) {
  using Request = v1::SweepMWidthRequest;
  const std::vector<std::pair<std::string, std::function<void(Request&)>>> faults = {
      {"x.parameter", [](Request& request) { request.clear_x(); }},
      {"x.parameter",
       [](Request& request) { request.mutable_x()->set_parameter(static_cast<v1::SweepParameter>(99)); }},
      {"y.parameter", [](Request& request) { *request.mutable_y() = request.x(); }},
      {"x.parameter",
       [](Request& request) {
         request.mutable_x()->set_parameter(v1::SWEEP_PARAMETER_ACCELEROMETER_BANDWIDTH_HZ);
       }},
      {"x.count", [](Request& request) { request.mutable_x()->set_count(1); }},
      {"y.count", [](Request& request) { request.mutable_y()->set_count(10'001); }},
      {"x.count times y.count", [](Request& request) { request = Hands(1001, 1000); }},
      {"x.min", [](Request& request) { request.mutable_x()->set_min(std::nan("")); }},
      {"x.max", [](Request& request) { request.mutable_x()->set_max(0.5); }},
      {"y.min", [](Request& request) { request.mutable_y()->set_min(0); }},
      {"hand_stiffness", [](Request& request) { request.mutable_y()->set_max(1e7); }},
      {"cutoff_hz", [](Request& request) { request.mutable_loop()->set_cutoff_hz(-3); }},
  };
  for (const auto& [field, spoil] : faults) {
    Request request = Hands(3, 3);
    spoil(request);
    const grpc::Status status = SweepCall(*stability, request).Finish();
    ExpectStatus(status, StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
    EXPECT_EQ(DetailsOf(status).info.metadata().at("field"), field);
  }
  Request request = Hands(3, 3);
  request.set_axis("leg");
  ExpectStatus(SweepCall(*stability, request).Finish(), StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
}

TEST_F(SweepTest, RunsAFewAtOnceAndFreesThePlaceOfACancelledOne) {
  std::vector<std::unique_ptr<SweepCall>> calls;
  v1::SweepMWidthResponse row;
  for (int i = 0; i < StabilityService::kMostComputations; ++i) {
    calls.push_back(std::make_unique<SweepCall>(*stability, Long()));
    ASSERT_TRUE(calls.back()->Read(row));
  }
  ExpectStatus(SweepCall(*stability, Hands(3, 3)).Finish(), StatusCode::RESOURCE_EXHAUSTED,
               "TOO_MANY_COMPUTATIONS");
  v1::GetAccuracyRequest accuracy;
  accuracy.set_simulate(true);
  v1::GetAccuracyResponse response;
  ExpectStatus(Call(&Stub::GetAccuracy, *stability, accuracy, response), StatusCode::RESOURCE_EXHAUSTED,
               "TOO_MANY_COMPUTATIONS");
  // What is quick is answered all the same.
  accuracy.set_simulate(false);
  EXPECT_TRUE(Call(&Stub::GetAccuracy, *stability, accuracy, response).ok());

  calls.front()->Cancel();
  EXPECT_EQ(calls.front()->Finish().error_code(), StatusCode::CANCELLED);
  // The handler hears of it with its next row.
  grpc::Status status;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    status = SweepCall(*stability, Hands(3, 3)).Finish();
    if (status.ok()) {
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(SweepTest, EndsWithTheServer) {
  SweepCall call(*stability, Long());
  v1::SweepMWidthResponse row;
  ASSERT_TRUE(call.Read(row));
  server->Shutdown(std::chrono::milliseconds(0));
  EXPECT_FALSE(call.Finish().ok());
}

}  // namespace
}  // namespace mwidth::rpc
