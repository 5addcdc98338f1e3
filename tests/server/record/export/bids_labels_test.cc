#include "server/record/export/bids_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/record/export/file_set.h"

namespace mwidth::record {
namespace {

using ::testing::HasSubstr;

SessionInfo Info(const std::string& subject, const std::string& visit, const std::string& task, int run) {
  SessionInfo info;
  info.id = "one";
  info.labels = {
      .subject = subject, .visit = visit, .task = task, .run = run, .operator_name = {}, .metadata = {}};
  return info;
}

TEST(BidsLabelsTest, NameARecordingAsTheStandardDoes) {
  const auto labels = LabelsOf(Info("01", "pre", "reach", 2));
  EXPECT_EQ(labels.Folder(), "sub-01/ses-pre");
  EXPECT_EQ(labels.Recording(), "sub-01_ses-pre_task-reach_tracksys-mwidth_run-02");
}

TEST(BidsLabelsTest, LeaveOutAVisitThatThereIsNot) {
  const auto labels = LabelsOf(Info("P7", "", "reach", 123));
  EXPECT_EQ(labels.Folder(), "sub-P7");
  EXPECT_EQ(labels.Recording(), "sub-P7_task-reach_tracksys-mwidth_run-123");
}

TEST(BidsLabelsTest, RefuseWhatIsNoLabel) {
  for (const auto& info :
       {Info("", "", "reach", 1), Info("sub-01", "", "reach", 1), Info("01", "a b", "reach", 1),
        Info("01", "", "", 1), Info("01", "", "../reach", 1), Info("01", "", "größer", 1),
        Info("01", "", "reach", 0), Info("01", "", "reach", -1)}) {
    try {
      LabelsOf(info);
      ADD_FAILURE() << info.labels.subject << info.labels.visit << info.labels.task << info.labels.run;
    } catch (const ExportRefused& refusal) {
      EXPECT_THAT(refusal.what(), HasSubstr("session one: "));
      EXPECT_THAT(refusal.what(), HasSubstr("csv or hdf5"));
    }
  }
}

}  // namespace
}  // namespace mwidth::record
