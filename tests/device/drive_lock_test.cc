#include "device/drive_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace mwidth::device {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Of this test run alone: others may run at the same time.
std::string Identity(const std::string& name) { return "test:" + std::to_string(getpid()) + ":" + name; }

std::string RefusalOf(const std::string& identity) {
  try {
    const DriveLock lock(identity);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "locked";
}

// Another process that holds a drive until it is killed.
class Holder {
 public:
  explicit Holder(const std::string& identity) {
    std::array<int, 2> ready{};
    EXPECT_EQ(pipe(ready.data()), 0);
    child_ = fork();
    if (child_ == 0) {
      const DriveLock lock(identity);
      if (write(ready[1], "x", 1) != 1) {
        _exit(1);
      }
      while (true) {
        pause();
      }
    }
    char byte = 0;
    EXPECT_EQ(read(ready[0], &byte, 1), 1);
    close(ready[0]);
    close(ready[1]);
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;
  ~Holder() { Kill(); }
  void Kill() {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
      child_ = -1;
    }
  }

 private:
  pid_t child_ = -1;
};

TEST(DriveLockTest, RefusesASecondHolderAndSaysWhatToDo) {
  const std::string identity = Identity("modbus:/dev/ttyUSB0:3");
  const DriveLock lock(identity);
  EXPECT_THAT(RefusalOf(identity),
              AllOf(HasSubstr(identity), HasSubstr("another server"), HasSubstr("ss -xap")));
}

TEST(DriveLockTest, LetsGoWithTheObject) {
  const std::string identity = Identity("a");
  { const DriveLock lock(identity); }
  EXPECT_EQ(RefusalOf(identity), "locked");
}

TEST(DriveLockTest, TellsDrivesApartAlsoWhereOneNameBeginsTheOther) {
  const DriveLock lock(Identity("can0:1"));
  EXPECT_EQ(RefusalOf(Identity("can0:11")), "locked");
  EXPECT_EQ(RefusalOf(Identity("can0:")), "locked");
}

TEST(DriveLockTest, HoldsAcrossProcessesUntilTheHolderIsKilled) {
  const std::string identity = Identity("shared");
  Holder holder(identity);
  EXPECT_THAT(RefusalOf(identity), HasSubstr("another server"));
  holder.Kill();
  EXPECT_EQ(RefusalOf(identity), "locked");
}

TEST(DriveLockTest, DoesNotPassToAProgramThatIsStarted) {
  const std::string identity = Identity("not inherited");
  pid_t child = -1;
  {
    const DriveLock lock(identity);
    child = fork();
    if (child == 0) {
      execlp("sleep", "sleep", "60", nullptr);
      _exit(1);
    }
    // The program runs, and has closed what it was not to inherit, once its name is its own.
    std::string name;
    while (name != "sleep\n") {
      std::ifstream comm("/proc/" + std::to_string(child) + "/comm");
      name.assign(std::istreambuf_iterator<char>(comm), {});
    }
  }
  EXPECT_EQ(RefusalOf(identity), "locked");
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST(DriveLockTest, RefusesANameThatIsNone) {
  EXPECT_THROW(DriveLock(""), std::invalid_argument);
  EXPECT_THROW(DriveLock(std::string(DriveLock::kLongestIdentity + 1, 'x')), std::invalid_argument);
  const DriveLock longest(Identity("") + std::string(DriveLock::kLongestIdentity - Identity("").size(), 'x'));
}

}  // namespace
}  // namespace mwidth::device
