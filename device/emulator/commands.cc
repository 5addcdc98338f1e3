#include "device/emulator/commands.h"

#include <unistd.h>

#include <boost/asio/read_until.hpp>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <limits>
#include <sstream>

namespace mwidth::device::emulator {
namespace {

// Pauses longer than this would only seem to be silence.
constexpr double kLongestPauseS = 10;

bool ReadPause(std::istringstream& words, std::atomic<int64_t>& pause_ns) {
  double seconds = -1;
  words >> seconds;
  if (!words || !(seconds >= 0 && seconds <= kLongestPauseS)) {
    return false;
  }
  pause_ns = static_cast<int64_t>(seconds * 1e9);
  return true;
}

void BeWell(LinkFaults& faults, Joint& joint) {
  faults.silent = false;
  faults.exceptions = false;
  faults.heartbeat_lost = false;
  faults.wrong_order = false;
  faults.delay_ns = 0;
  faults.dribble_ns = 0;
  joint.SetEncoderFault(EncoderFault::kNone);
}

bool ReadCode(std::istringstream& words, Link& link) {
  unsigned code = 0;
  words >> std::hex >> code;
  if (!words || !(words >> std::ws).eof() || code == 0 || code > std::numeric_limits<uint16_t>::max()) {
    return false;
  }
  link.Fail(static_cast<uint16_t>(code));
  return true;
}

std::string Describe(const Joint& joint) {
  std::ostringstream text;
  text << (joint.enabled() ? "enabled" : "disabled") << ", force " << joint.force_counts()
       << " counts, watchdog fired " << joint.trips().count << " times";
  return text.str();
}

// False where the line says nothing that is known.
bool SetFault(const std::string& word, std::istringstream& words, LinkFaults& faults, Joint& joint,
              Link& link) {
  if (!link.Has(word)) {
    return false;
  }
  if (word == "silence") {
    faults.silent = true;
  } else if (word == "exceptions" || word == "abort") {
    faults.exceptions = true;
  } else if (word == "heartbeat-loss") {
    faults.heartbeat_lost = true;
  } else if (word == "emcy") {
    return ReadCode(words, link);
  } else if (word == "wrong-order") {
    faults.wrong_order = true;
  } else if (word == "delay") {
    return ReadPause(words, faults.delay_ns);
  } else if (word == "dribble") {
    return ReadPause(words, faults.dribble_ns);
  } else if (word == "freeze") {
    joint.SetEncoderFault(EncoderFault::kFrozen);
  } else if (word == "jump") {
    int64_t counts = 0;
    words >> counts;
    if (!words) {
      return false;
    }
    joint.JumpEncoder(counts);
  } else if (word == "well") {
    BeWell(faults, joint);
  } else {
    return false;
  }
  return true;
}

}  // namespace

std::string Obey(const std::string& line, LinkFaults& faults, Joint& joint, Link& link) {
  std::istringstream words(line);
  std::string word;
  words >> word;
  if (word == "state") {
    return Describe(joint);
  }
  return SetFault(word, words, faults, joint, link)
             ? "ok"
             : "not understood on this link; --help lists the commands";
}

Commands::Commands(boost::asio::io_context& context, LinkFaults& faults, Joint& joint, Link& link)
    : input_(context, dup(STDIN_FILENO)), faults_(faults), joint_(joint), link_(link) {
  ReadLine();
}

void Commands::ReadLine() {
  boost::asio::async_read_until(input_, buffer_, '\n', [this](auto error, std::size_t) {
    if (error) {
      return;
    }
    std::istream lines(&buffer_);
    std::string line;
    std::getline(lines, line);
    std::cout << Obey(line, faults_, joint_, link_) << std::endl;
    ReadLine();
  });
}

}  // namespace mwidth::device::emulator
