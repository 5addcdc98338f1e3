#include "device/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "tests/support/temporary_file.h"

namespace mwidth::device {
namespace {

using model::AxisKind;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// The message with which a file of this content is refused; empty where it is read.
std::string Refusal(const std::string& content, AxisKind kind = AxisKind::kRotary) {
  const TemporaryFile file(content);
  try {
    ReadRecording(file.path(), kind);
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_THAT(message, StartsWith(file.path().string() + ":"));
    return message.substr(file.path().string().size() + 1);
  }
  return {};
}

TEST(Recording, ReadsReachesThatStartAgainAtTimeZero) {
  const TemporaryFile file(
      "task,time_s,elbow_angle_rad,force_n\n"
      "1,0.00,0.5,x\n1,0.01,0.6,x\n1,0.02,0.7,x\n1,0.03,0.8,x\n"
      "1,0,0.9,x\n1,1e-2,1.0,x\n1,0.02,-1.1,x\n1,0.05,1.2,x\n1,0.06,1.3,x\n");
  const std::vector<Reach> reaches = ReadRecording(file.path(), AxisKind::kRotary);
  ASSERT_EQ(reaches.size(), 2U);
  EXPECT_THAT(reaches[0].times_s, ElementsAre(0, 0.01, 0.02, 0.03));
  EXPECT_THAT(reaches[0].positions, ElementsAre(0.5, 0.6, 0.7, 0.8));
  EXPECT_THAT(reaches[1].times_s, ElementsAre(0, 0.01, 0.02, 0.05, 0.06));
  EXPECT_THAT(reaches[1].positions, ElementsAre(0.9, 1.0, -1.1, 1.2, 1.3));
}

TEST(Recording, ReadsFilesOfOtherSystemsToo) {
  const TemporaryFile file(
      "\xEF\xBB\xBFhandle_m , time_s\r\n"
      " 0.1,0\r\n0.2, 1\r\n\r\n0.3,2\r\n0.4,3");
  const std::vector<Reach> reaches = ReadRecording(file.path(), AxisKind::kLinear);
  ASSERT_EQ(reaches.size(), 1U);
  EXPECT_THAT(reaches[0].positions, ElementsAre(0.1, 0.2, 0.3, 0.4));
}

TEST(Recording, RefusesAMissingTimeColumn) {
  EXPECT_THAT(Refusal("t,angle_rad\n0,1\n"), AllOf(StartsWith("1: "), HasSubstr("time_s")));
  EXPECT_THAT(Refusal(""), AllOf(StartsWith("1: "), HasSubstr("time_s")));
}

TEST(Recording, RefusesAPositionOfTheOtherAxisKind) {
  const std::string content = "time_s,handle_m\n0,1\n1,1\n2,1\n3,1\n";
  EXPECT_THAT(Refusal(content), AllOf(StartsWith("1: 0 columns"), HasSubstr("_rad")));
  EXPECT_EQ(Refusal(content, AxisKind::kLinear), "");
  EXPECT_THAT(Refusal("time_s,angle_rad\n0,1\n", AxisKind::kLinear),
              AllOf(StartsWith("1: 0 columns"), HasSubstr("_m")));
}

TEST(Recording, RefusesTwoPositionColumns) {
  EXPECT_THAT(Refusal("time_s,elbow_rad,wrist_rad\n"), AllOf(StartsWith("1: 2 columns"), HasSubstr("_rad")));
}

TEST(Recording, RefusesWhatIsNotAFiniteNumber) {
  const std::string head = "time_s,angle_rad\n0,0.1\n0.1,";
  for (const std::string field : {"", "abc", "0.1 rad", "0,2", "nan", "inf", "1e999", "0x1"}) {
    EXPECT_THAT(Refusal(head + field + "\n"), StartsWith("3: ")) << field;
  }
  EXPECT_THAT(Refusal(head + "abc\n"), AllOf(HasSubstr("angle_rad is 'abc'"), HasSubstr("finite number")));
}

TEST(Recording, RefusesARowOfAnotherLength) {
  EXPECT_THAT(Refusal("time_s,angle_rad\n0\n"), AllOf(StartsWith("2: 1 columns"), HasSubstr("expected 2")));
  EXPECT_THAT(Refusal("time_s,angle_rad\n0,1,2\n"), StartsWith("2: 3 columns"));
}

TEST(Recording, RefusesTimesThatDoNotRise) {
  const std::string head = "time_s,angle_rad\n0,1\n0.2,1\n";
  EXPECT_THAT(Refusal(head + "0.2,1\n"), AllOf(StartsWith("4: "), HasSubstr("does not rise from 0.2 s")));
  EXPECT_THAT(Refusal(head + "0.1,1\n"), StartsWith("4: "));
  EXPECT_THAT(Refusal(head + "-0.1,1\n"), StartsWith("4: "));
  EXPECT_THAT(Refusal("time_s,angle_rad\n0.1,1\n"), AllOf(StartsWith("2: "), HasSubstr("expected 0")));
}

TEST(Recording, RefusesReachesOfTooFewSamples) {
  const std::string reach = "0,1\n0.1,1\n0.2,1\n0.3,1\n";
  EXPECT_THAT(Refusal("time_s,angle_rad\n"), HasSubstr("no samples"));
  EXPECT_THAT(Refusal("time_s,angle_rad\n" + reach + "0,1\n0.1,1\n0.2,1\n"),
              AllOf(StartsWith("6: reach 2"), HasSubstr("3 samples"), HasSubstr("at least 4")));
  EXPECT_THAT(Refusal("time_s,angle_rad\n0,1\n" + reach), StartsWith("2: reach 1"));
}

TEST(Recording, RefusesWhatIsNoFile) {
  EXPECT_THROW(ReadRecording("/no/such/recording.csv", AxisKind::kRotary), std::runtime_error);
  EXPECT_THROW(ReadRecording("/", AxisKind::kRotary), std::runtime_error);
}

}  // namespace
}  // namespace mwidth::device
