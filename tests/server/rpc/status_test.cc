#include "server/rpc/status.h"

#include <gmock/gmock.h>

#include <map>
#include <stdexcept>

#include "tests/server/rpc/served_axis.h"

namespace mwidth::rpc {
namespace {

using gate::RefusalCode;
using grpc::StatusCode;

TEST(ToStatus, KeepsCodeReasonMessageAndMetadata) {
  const std::map<RefusalCode, StatusCode> codes = {
      {RefusalCode::kInvalidArgument, StatusCode::INVALID_ARGUMENT},
      {RefusalCode::kFailedPrecondition, StatusCode::FAILED_PRECONDITION},
      {RefusalCode::kAborted, StatusCode::ABORTED},
      {RefusalCode::kNotFound, StatusCode::NOT_FOUND},
      {RefusalCode::kPermissionDenied, StatusCode::PERMISSION_DENIED},
      {RefusalCode::kResourceExhausted, StatusCode::RESOURCE_EXHAUSTED},
      {RefusalCode::kUnavailable, StatusCode::UNAVAILABLE}};
  for (const auto& [code, expected] : codes) {
    const grpc::Status status = ToStatus(
        {.code = code, .reason = "SOME_REASON", .message = "Do this.", .metadata = {{"figure", "7"}}});
    ExpectStatus(status, expected, "SOME_REASON");
    EXPECT_EQ(status.error_message(), "Do this.");
    EXPECT_EQ(DetailsOf(status).info.metadata().at("figure"), "7");
    EXPECT_FALSE(DetailsOf(status).report.has_value());
  }
}

TEST(ToStatus, CarriesTheStabilityReport) {
  gate::StabilityReport report;
  report.requested_mass = 3;
  report.admitting_cutoff_hz = 4.5;
  const Details details =
      DetailsOf(ToStatus({.reason = gate::kUnstableMass, .message = "No.", .stability = report}));
  ASSERT_TRUE(details.report.has_value());
  EXPECT_EQ(details.report->requested_mass(), 3);
  EXPECT_EQ(details.report->admitting_cutoff_hz(), 4.5);
}

TEST(Guarded, AnswersInternalWhereAHandlerThrowsAndKeepsItsSecret) {
  const grpc::Status status = Guarded("Method", []() -> grpc::Status { throw std::runtime_error("secret"); });
  EXPECT_EQ(status.error_code(), StatusCode::INTERNAL);
  EXPECT_THAT(status.error_message(), testing::HasSubstr("Method"));
  EXPECT_THAT(status.error_message(), testing::Not(testing::HasSubstr("secret")));
  EXPECT_EQ(Guarded("Method", []() -> grpc::Status { throw 1; }).error_code(), StatusCode::INTERNAL);
  EXPECT_TRUE(Guarded("Method", [] { return grpc::Status::OK; }).ok());
}

}  // namespace
}  // namespace mwidth::rpc
