#include "server/doctor/report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/doctor/examine.h"
#include "tests/server/doctor/fake_host.h"

namespace mwidth::doctor {
namespace {

const std::vector<Finding> kFindings = {
    {.subject = "kernel", .verdict = Verdict::kOk, .seen = "PREEMPT_RT", .advice = ""},
    {.subject = "isolation", .verdict = Verdict::kWarning, .seen = "not pinned", .advice = "pin it"},
    {.subject = "locked memory", .verdict = Verdict::kProblem, .seen = "8 KiB", .advice = "set memlock"}};

TEST(ReportTest, ShowsEveryFindingWithItsAdvice) {
  EXPECT_EQ(TextReport(kFindings),
            "ok       kernel: PREEMPT_RT\n"
            "warning  isolation: not pinned\n"
            "         -> pin it\n"
            "problem  locked memory: 8 KiB\n"
            "         -> set memlock\n"
            "\n"
            "1 problems, 1 warnings\n");
}

TEST(ReportTest, TellsTheSameToAProgram) {
  const auto report = nlohmann::json::parse(JsonReport(kFindings));
  ASSERT_EQ(report["findings"].size(), 3);
  EXPECT_EQ(report["findings"][1]["subject"], "isolation");
  EXPECT_EQ(report["findings"][1]["verdict"], "warning");
  EXPECT_EQ(report["findings"][1]["seen"], "not pinned");
  EXPECT_EQ(report["findings"][1]["advice"], "pin it");
  EXPECT_EQ(report["problems"], 1);
  EXPECT_EQ(report["warnings"], 1);
}

TEST(ReportTest, SurvivesBytesThatAreNoText) {
  const auto report = nlohmann::json::parse(JsonReport({{.subject = "s", .seen = "\xff\xfe", .advice = ""}}));
  EXPECT_EQ(report["findings"][0]["subject"], "s");
}

TEST(ExamineTest, FindsATunedHostInOrderAndAnEmptyOneNot) {
  const FakeHost host;
  const Needs needs{.priority = 80, .cpus = {3}};
  EXPECT_GT(Count(Examine(host.files(), needs), Verdict::kProblem), 2);
  MakeTuned(host);
  const std::vector<Finding> findings = Examine(host.files(), needs);
  EXPECT_EQ(Count(findings, Verdict::kOk), findings.size()) << TextReport(findings);
}

TEST(ExamineTest, ReadsThisHost) {
  Needs needs;
  needs.some_loop_unpinned = true;
  const std::vector<Finding> findings = Examine(HostFiles("/"), needs);
  EXPECT_EQ(findings.size(), 11);
  for (const Finding& finding : findings) {
    EXPECT_FALSE(finding.seen.empty()) << finding.subject;
  }
}

}  // namespace
}  // namespace mwidth::doctor
