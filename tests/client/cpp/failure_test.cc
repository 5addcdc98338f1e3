#include "client/cpp/failure.h"

#include <google/rpc/error_details.pb.h>
#include <gtest/gtest.h>

#include "tests/client/fake_answers.h"

namespace mwidth::client {
namespace {

grpc::Status WithReport() {
  google::rpc::Status status;
  status.set_code(grpc::StatusCode::FAILED_PRECONDITION);
  google::rpc::ErrorInfo info;
  info.set_reason("UNSTABLE_MASS");
  status.add_details()->PackFrom(info);
  v1::StabilityReport report;
  report.set_requested_mass(2);
  status.add_details()->PackFrom(report);
  return {grpc::StatusCode::FAILED_PRECONDITION, "unstable", status.SerializeAsString()};
}

TEST(DecodeRefusalTest, FindsReasonAndReport) {
  const auto refusal = DecodeRefusal(WithReport());
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(refusal->sentence, "unstable");
  EXPECT_EQ(refusal->reason, "UNSTABLE_MASS");
  EXPECT_EQ(refusal->stability.requested_mass(), 2);
}

TEST(DecodeRefusalTest, AnAnswerWithoutReportIsNoRefusal) {
  EXPECT_FALSE(DecodeRefusal(grpc::Status::OK).has_value());
  EXPECT_FALSE(DecodeRefusal({grpc::StatusCode::FAILED_PRECONDITION, "no lease"}).has_value());
}

TEST(ErrorTest, KeepsCodeMessageAndReason) {
  const Error error(WithReport());
  EXPECT_STREQ(error.what(), "unstable");
  EXPECT_EQ(error.code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(error.reason(), "UNSTABLE_MASS");
  EXPECT_EQ(error.status().details_size(), 2);
}

TEST(ErrorTest, DetailsThatDoNotDecodeAreLeftOut) {
  const Error error({grpc::StatusCode::ABORTED, "lease lost", "\xff\xff garbage"});
  EXPECT_EQ(error.code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(error.reason(), "");
  EXPECT_EQ(error.status().code(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(error.status().message(), "lease lost");
}

TEST(ErrorTest, TellsADecisionOfTheServerFromABreakdown) {
  for (const auto code : {grpc::StatusCode::FAILED_PRECONDITION, grpc::StatusCode::INVALID_ARGUMENT,
                          grpc::StatusCode::NOT_FOUND, grpc::StatusCode::ABORTED,
                          grpc::StatusCode::PERMISSION_DENIED, grpc::StatusCode::RESOURCE_EXHAUSTED}) {
    EXPECT_TRUE(Error({code, ""}).DeclinedByServer()) << code;
  }
  for (const auto code : {grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::DEADLINE_EXCEEDED,
                          grpc::StatusCode::INTERNAL, grpc::StatusCode::UNIMPLEMENTED}) {
    EXPECT_FALSE(Error({code, ""}).DeclinedByServer()) << code;
  }
}

TEST(CallErrorTest, SaysWhatTheWordsOfGrpcMean) {
  const auto gone = CallError({grpc::StatusCode::UNAVAILABLE, "Socket closed"});
  EXPECT_STREQ(gone.what(), "the server cannot be reached: Socket closed");
  EXPECT_EQ(gone.code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_STREQ(CallError({grpc::StatusCode::DEADLINE_EXCEEDED, "Deadline Exceeded"}).what(),
               "the server did not answer in time");
}

TEST(CallErrorTest, KeepsTheWordsOfTheServer) {
  const auto silent = CallError(mwidth::testing::Failure(grpc::StatusCode::UNAVAILABLE, "LOOP_SILENT",
                                                         "The loop of this axis does not answer"));
  EXPECT_STREQ(silent.what(), "The loop of this axis does not answer");
  EXPECT_EQ(silent.reason(), "LOOP_SILENT");
}

}  // namespace
}  // namespace mwidth::client
