#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/fake_server.h"
#include "tests/client/subprocess.h"

namespace mwidth::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ExampleTest, RendersStreamsAndShowsARefusal) {
  const FakeServer server;
  const auto outcome = RunProgram(EXAMPLE_PROGRAM, {server.address()}, server.address());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("rendering 0.175617, gain margin"), HasSubstr(" 0.905 s  position"),
                    HasSubstr("refused (UNSTABLE_MASS)"), HasSubstr("nearest admitted mass: 0.351235")));
  EXPECT_EQ(server.Calls().back(), "ReleaseControl");
}

TEST(ExampleTest, SaysThatNobodyAnswers) {
  const auto outcome = RunProgram(EXAMPLE_PROGRAM, {"127.0.0.1:1"}, "");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no server answers at 127.0.0.1:1"));
}

}  // namespace
}  // namespace mwidth::testing
