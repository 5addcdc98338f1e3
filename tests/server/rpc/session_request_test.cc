#include "server/rpc/session_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace mwidth::rpc {
namespace {

using testing::HasSubstr;

v1::SessionLabels Labels(const std::string& subject, const std::string& task) {
  v1::SessionLabels labels;
  labels.set_subject(subject);
  labels.set_task(task);
  return labels;
}

v1::AddMarkerRequest MarkerAt(int64_t client_ns, int64_t offset_ns, int64_t error_ns) {
  v1::AddMarkerRequest request;
  request.mutable_time()->set_client_ns(client_ns);
  request.mutable_time()->set_offset_ns(offset_ns);
  request.mutable_time()->set_error_ns(error_ns);
  return request;
}

void ExpectRefused(const v1::SessionLabels& labels, const std::string& reason, const std::string& message) {
  const auto read = ReadLabels(labels);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.refusal().code, gate::RefusalCode::kInvalidArgument);
  EXPECT_EQ(read.refusal().reason, reason);
  EXPECT_THAT(read.refusal().message, HasSubstr(message));
}

TEST(SessionRequestTest, TakesLabelsWithOrWithoutTheirPrefix) {
  v1::SessionLabels labels = Labels("sub-01", "task-reach");
  labels.set_visit("ses-2");
  labels.set_run(3);
  labels.set_operator_("who ran it");
  (*labels.mutable_metadata())["arm"] = "left";
  EXPECT_EQ(*ReadLabels(labels), (record::SessionLabels{.subject = "01",
                                                        .visit = "2",
                                                        .task = "reach",
                                                        .run = 3,
                                                        .operator_name = "who ran it",
                                                        .metadata = {{"arm", "left"}}}));
  EXPECT_EQ(ReadLabels(Labels("01", "reach"))->visit, "");
}

TEST(SessionRequestTest, RefusesWhatCannotBeAFilesName) {
  for (const char* subject :
       {"", "sub-", "../01", "0 1", "0_1", "a\nb", "123456789012345678901234567890123"}) {
    ExpectRefused(Labels(subject, "reach"), "INVALID_TEXT", "labels.subject must be");
  }
  ExpectRefused(Labels("01", ""), "INVALID_TEXT", "labels.task");
  v1::SessionLabels labels = Labels("01", "reach");
  labels.set_visit("1/2");
  ExpectRefused(labels, "INVALID_TEXT", "labels.visit");
}

TEST(SessionRequestTest, RefusesNumbersAndTextsThatAreTooLarge) {
  v1::SessionLabels labels = Labels("01", "reach");
  labels.set_run(10'000);
  ExpectRefused(labels, "INVALID_NUMBER", "labels.run");
  labels.set_run(1);
  labels.set_operator_(std::string(101, 'x'));
  ExpectRefused(labels, "INVALID_TEXT", "labels.operator");
  labels.clear_operator_();
  (*labels.mutable_metadata())["key"] = std::string(4001, 'x');
  ExpectRefused(labels, "INVALID_TEXT", "metadata's values");
  labels.clear_metadata();
  for (int i = 0; i < 9; ++i) {
    (*labels.mutable_metadata())[std::to_string(i)] = std::string(4000, 'x');
  }
  ExpectRefused(labels, "INVALID_TEXT", "at most 32000 bytes in all");
  labels.clear_metadata();
  for (int i = 0; i <= 100; ++i) {
    (*labels.mutable_metadata())[std::to_string(i)] = "";
  }
  ExpectRefused(labels, "INVALID_TEXT", "at most 100 entries");
}

TEST(SessionRequestTest, PutsAMarkerOnTheAxissClock) {
  const auto marker = ReadMarker(MarkerAt(1000, 50, 7), 2000);
  ASSERT_TRUE(marker.ok());
  EXPECT_EQ(marker->monotonic_ns, 1050);
  EXPECT_EQ(marker->error_ns, 7);
  EXPECT_EQ(marker->client_ns, 1000);
  EXPECT_EQ(marker->arrival_ns, 2000);
}

TEST(SessionRequestTest, DatesAMarkerWithoutATimeWhenItArrives) {
  const auto marker = ReadMarker(v1::AddMarkerRequest(), 2000);
  ASSERT_TRUE(marker.ok());
  EXPECT_EQ(marker->monotonic_ns, 2000);
  EXPECT_EQ(marker->client_ns, 0);
}

TEST(SessionRequestTest, RefusesTimesThatCannotBe) {
  EXPECT_FALSE(ReadMarker(MarkerAt(INT64_MAX, INT64_MAX, 0), 0).ok());
  EXPECT_FALSE(ReadMarker(MarkerAt(INT64_MIN, 0, 0), 0).ok());
  EXPECT_FALSE(ReadMarker(MarkerAt(0, 0, -1), 0).ok());
  EXPECT_FALSE(ReadMarker(MarkerAt(0, 0, INT64_MAX), 0).ok());
}

}  // namespace
}  // namespace mwidth::rpc
