// Every exchange ends in time, whatever the far end does.
#include "device/modbus/link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <poll.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/device/modbus/scripted_peer.h"

namespace mwidth::device::modbus {
namespace {

using modbus::testing::Bytes;
using modbus::testing::Listener;
using modbus::testing::Pieces;
using modbus::testing::Script;
using modbus::testing::ScriptedPeer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Generous, so that a slow host does not look like a silent drive; what is silent costs this long.
constexpr int64_t kPatienceNs = 300'000'000;

int64_t Deadline(int64_t in_ns = kPatienceNs) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000L + now.tv_nsec + in_ns;
}

class LinkTest : public ::testing::Test {
 protected:
  void Connect(Script script) {
    link.Connect();
    peer.emplace(listener.Accept(), std::move(script));
  }
  Outcome Ask() { return link.Exchange(ReadRegisters(0, 1), values, Deadline()); }

  // The answer of a drive whose register holds `value`, with what a test breaks in it.
  static Bytes Answer(const Bytes& request, uint8_t value, int transaction_offset = 0, uint8_t unit = 1) {
    return {request[0], static_cast<uint8_t>(request[1] + transaction_offset), 0, 0, 0, 5, unit, 3, 2, 0,
            value};
  }

  Listener listener;
  Link link{{.peer = TcpAddress{.host = "127.0.0.1", .port = listener.port()}, .unit = 1}};
  std::optional<ScriptedPeer> peer;
  std::array<uint16_t, 1> values{};
};

TEST_F(LinkTest, BringsTheAnswer) {
  Connect([](const Bytes& request) { return Pieces{Answer(request, 42)}; });
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_THAT(values, ElementsAre(42));
}

TEST_F(LinkTest, TakesAnAnswerInPieces) {
  Connect([](const Bytes& request) {
    std::vector<Bytes> pieces;
    for (const uint8_t byte : Answer(request, 42)) {
      pieces.push_back({byte});
    }
    return pieces;
  });
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_THAT(values, ElementsAre(42));
}

TEST_F(LinkTest, PassesOverWhatBelongsToAnotherRequestOrUnit) {
  Connect([](const Bytes& request) {
    return Pieces{Answer(request, 1, -1), Answer(request, 2, 0, 7), Answer(request, 42)};
  });
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_THAT(values, ElementsAre(42));
  EXPECT_EQ(link.counters().other_transaction, 1);
  EXPECT_EQ(link.counters().other_unit, 1);
}

TEST_F(LinkTest, ADuplicateDoesNotAnswerTheNextRequest) {
  Connect([sent = 0](const Bytes& request) mutable {
    ++sent;
    return sent == 1 ? Pieces{Answer(request, 1), Answer(request, 1)} : Pieces{Answer(request, 2)};
  });
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_THAT(values, ElementsAre(2));
}

TEST_F(LinkTest, SilenceEndsAtTheDeadlineAndTheLinkGoesOn) {
  Connect([sent = 0](const Bytes& request) mutable {
    return ++sent == 1 ? Pieces{} : Pieces{Answer(request, 42)};
  });
  EXPECT_EQ(Ask(), Outcome::kSilent);
  EXPECT_EQ(link.counters().silent, 1);
  EXPECT_EQ(Ask(), Outcome::kAnswered);
}

TEST_F(LinkTest, AReplyThatStopsHalfWayIsSilence) {
  Connect([](const Bytes& request) {
    const Bytes answer = Answer(request, 42);
    return Pieces{{answer[0]}, {answer[1]}, {answer.begin() + 2, answer.end() - 1}};
  });
  EXPECT_EQ(Ask(), Outcome::kSilent);
  EXPECT_TRUE(link.connected());
}

TEST_F(LinkTest, ADeadlineThatHasPassedIsSilence) {
  Connect([](const Bytes& request) { return Pieces{Answer(request, 42)}; });
  EXPECT_EQ(link.Exchange(ReadRegisters(0, 1), values, Deadline(-1)), Outcome::kSilent);
}

TEST_F(LinkTest, AnExceptionIsTold) {
  Connect([](const Bytes& request) { return Pieces{{request[0], request[1], 0, 0, 0, 3, 1, 0x83, 2}}; });
  EXPECT_EQ(Ask(), Outcome::kException);
  EXPECT_EQ(link.counters().exceptions, 1);
}

TEST_F(LinkTest, LyingLengthsAreMalformedAndTheNextExchangeIsClean) {
  Connect([sent = 0](const Bytes& request) mutable {
    Bytes answer = Answer(request, 9);
    switch (++sent) {
      case 1:
        answer[5] = 200;  // The header promises more than the function does.
        return Pieces{answer};
      case 2:
        answer[8] = 255;  // More registers than were asked for, and more than follow.
        answer.resize(300, 0);
        return Pieces{answer};
      case 3:
        answer[7] = 4;  // Another function.
        return Pieces{answer};
      default:
        return Pieces{Answer(request, 42)};
    }
  });
  EXPECT_EQ(Ask(), Outcome::kMalformed);
  EXPECT_EQ(Ask(), Outcome::kMalformed);
  EXPECT_EQ(Ask(), Outcome::kMalformed);
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_THAT(values, ElementsAre(42));
}

TEST_F(LinkTest, AConnectionThatEndsIsToldAndCanBeHadAgain) {
  Connect([](const Bytes& /*request*/) { return Pieces{{}}; });
  EXPECT_EQ(Ask(), Outcome::kDisconnected);
  EXPECT_FALSE(link.connected());
  EXPECT_EQ(Ask(), Outcome::kDisconnected);
  EXPECT_EQ(link.counters().disconnects, 1);
  peer.reset();
  Connect([](const Bytes& request) { return Pieces{Answer(request, 42)}; });
  EXPECT_EQ(Ask(), Outcome::kAnswered);
}

TEST(Link, ThatCannotBeHadSaysWhatToDo) {
  uint16_t port = 0;
  {
    const Listener closed;
    port = closed.port();
  }
  Link link({.peer = TcpAddress{.host = "127.0.0.1", .port = port}});
  try {
    link.Connect();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("127.0.0.1:" + std::to_string(port)));
    EXPECT_THAT(error.what(), HasSubstr("check that the drive is on"));
  }
}

// libmodbus would write beyond the set of its select, or be ended by the C library, before it was connected.
TEST(Link, BeyondTheDescriptorsOfSelectDoesNotEvenConnect) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  const rlimit before = limit;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 2 * FD_SETSIZE);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  const Listener listener;
  Link link({.peer = TcpAddress{.host = "127.0.0.1", .port = listener.port()}});
  std::vector<int> files;
  do {
    files.push_back(dup(listener.file()));
  } while (files.back() >= 0 && files.back() < FD_SETSIZE);
  const bool full = files.back() >= FD_SETSIZE;
  std::string refusal;
  try {
    link.Connect();
  } catch (const std::runtime_error& error) {
    refusal = error.what();
  }
  std::for_each(files.begin(), files.end(), close);
  setrlimit(RLIMIT_NOFILE, &before);
  ASSERT_TRUE(full) << "the host allows too few open files";
  EXPECT_THAT(refusal, HasSubstr("too many files open"));
  pollfd waiting{.fd = listener.file(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&waiting, 1, 0), 0);
}

TEST(LinkLock, IsOfTheUnitOnTcp) {
  const TcpAddress address{.host = "10.0.0.7", .port = 502};
  EXPECT_EQ(LockNameOf({.peer = address, .unit = 1}), "modbus:10.0.0.7:502 unit 1");
  EXPECT_EQ(LockNameOf({.peer = address, .unit = 2}), "modbus:10.0.0.7:502 unit 2");
}

TEST(LinkLock, IsOfTheWholeSerialLine) {
  const SerialLine line{.device = "/dev/ttyNOTHERE"};
  EXPECT_EQ(LockNameOf({.peer = line, .unit = 1}), "modbus:/dev/ttyNOTHERE");
  EXPECT_EQ(LockNameOf({.peer = line, .unit = 2}), "modbus:/dev/ttyNOTHERE");
}

TEST(LinkLock, IsTheSameByEveryNameOfTheSerialLine) {
  const std::filesystem::path name =
      std::filesystem::path(::testing::TempDir()) / ("tty" + std::to_string(getpid()));
  std::filesystem::create_symlink("/dev/null", name);
  const std::string lock = LockNameOf({.peer = SerialLine{.device = name}});
  std::filesystem::remove(name);
  EXPECT_EQ(lock, "modbus:/dev/null");
}

/// Modbus RTU over a pseudo-terminal.
class SerialLinkTest : public ::testing::Test {
 protected:
  void Connect(Script script) {
    int master = -1;
    int slave = -1;
    std::array<char, 64> name{};
    ASSERT_EQ(openpty(&master, &slave, name.data(), nullptr, nullptr), 0);
    link = std::make_unique<Link>(LinkConfig{.peer = SerialLine{.device = name.data()}, .unit = 1});
    link->Connect();
    close(slave);
    peer.emplace(master, std::move(script));
  }
  Outcome Ask() { return link->Exchange(ReadRegisters(0, 1), values, Deadline()); }

  std::unique_ptr<Link> link;
  std::optional<ScriptedPeer> peer;
  std::array<uint16_t, 1> values{};
};

// Unit 1, one register with the value 42; checksum by the specification's example algorithm (CRC-16/MODBUS).
const Bytes kSerialAnswer{0x01, 0x03, 0x02, 0x00, 0x2A, 0x39, 0x9B};

TEST_F(SerialLinkTest, AsksWithAChecksumAndBringsTheAnswer) {
  Bytes asked;
  Connect([&asked](const Bytes& request) {
    asked = request;
    return Pieces{kSerialAnswer};
  });
  EXPECT_EQ(Ask(), Outcome::kAnswered);
  EXPECT_THAT(values, ElementsAre(42));
  EXPECT_THAT(asked, ElementsAre(0x01, 0x03, 0x00, 0x00, 0x00, 0x01, 0x84, 0x0A));
}

TEST_F(SerialLinkTest, AWrongChecksumIsMalformedAndTheNextExchangeOnlyListens) {
  Connect([sent = 0](const Bytes& /*request*/) mutable {
    Bytes answer = kSerialAnswer;
    answer[4] ^= static_cast<uint8_t>(++sent == 1 ? 1 : 0);
    return Pieces{answer};
  });
  EXPECT_EQ(Ask(), Outcome::kMalformed);
  EXPECT_EQ(Ask(), Outcome::kSilent);
  EXPECT_EQ(Ask(), Outcome::kAnswered);
}

}  // namespace
}  // namespace mwidth::device::modbus
