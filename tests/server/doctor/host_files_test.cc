#include "server/doctor/host_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/doctor/fake_host.h"

namespace mwidth::doctor {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(HostFilesTest, ReadsTextWithoutTheWhiteSpaceAroundIt) {
  const FakeHost host;
  host.Write("proc/version", "  two\nlines \n");
  EXPECT_EQ(host.files().Text("proc/version"), "two\nlines");
  EXPECT_FALSE(host.files().Text("proc/no-such").has_value());
  EXPECT_FALSE(host.files().Text("proc").has_value()) << "a folder";
}

TEST(HostFilesTest, ReadsOneWholeNumberAndNothingElseAsANumber) {
  const FakeHost host;
  host.Write("n", "-1");
  EXPECT_EQ(host.files().Number("n"), -1);
  for (const char* none : {"", "1 2", "0x1", "one", "1.5", "99999999999999999999"}) {
    host.Write("n", none);
    EXPECT_FALSE(host.files().Number("n").has_value()) << none;
  }
  EXPECT_FALSE(host.files().Number("no-such").has_value());
}

TEST(HostFilesTest, ListsFoldersByTheirNumbers) {
  const FakeHost host;
  for (const char* name : {"irq/10", "irq/9", "irq/100"}) {
    host.MakeFolder(name);
  }
  host.Write("irq/default_smp_affinity", "f");
  EXPECT_THAT(host.files().Folders("irq"), ElementsAre("9", "10", "100"));
  EXPECT_THAT(host.files().Folders("no-such"), IsEmpty());
}

TEST(ParseCpuListTest, ReadsTheKernelsLists) {
  EXPECT_THAT(ParseCpuList(""), IsEmpty());
  EXPECT_THAT(ParseCpuList("3"), ElementsAre(3));
  EXPECT_THAT(ParseCpuList("0-2,5,7-8"), ElementsAre(0, 1, 2, 5, 7, 8));
}

TEST(ParseCpuListTest, TakesWhatIsNoListForNoCpu) {
  for (const char* none : {"(null)", "a-b", "1-", "-3", "1,,2", "0-99999999", "2 3"}) {
    EXPECT_THAT(ParseCpuList(none), IsEmpty()) << none;
  }
}

}  // namespace
}  // namespace mwidth::doctor
