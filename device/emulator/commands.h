// Faults on demand: a word a line on standard input.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/streambuf.hpp>
#include <string>

#include "device/emulator/faults.h"
#include "device/emulator/joint.h"

namespace mwidth::device::emulator {

/// For --help.
inline constexpr const char* kCommandsHelp =
    "On standard input, one a line:\n"
    "  silence          answer nothing\n"
    "  exceptions       answer every request with an exception\n"
    "  wrong-order      exchange the registers of 32-bit numbers\n"
    "  delay SECONDS    answer late\n"
    "  dribble SECONDS  answer byte by byte, this far apart\n"
    "  freeze           show the same position for ever\n"
    "  jump COUNTS      add to every position from now on\n"
    "  well             none of these any more, but for jumps\n"
    "  state            tell whether the motor is enabled, its force, and how often the watchdog fired";

/// Does what one line says, and returns what is to be said about it: "ok", the state, or that the line says
/// nothing that is known.
std::string Obey(const std::string& line, LinkFaults& faults, Joint& joint);

/// Reads lines until the input ends, and answers each.
class Commands {
 public:
  /// All references outlive it.
  Commands(boost::asio::io_context& context, LinkFaults& faults, Joint& joint);

 private:
  void ReadLine();

  boost::asio::posix::stream_descriptor input_;
  boost::asio::streambuf buffer_;
  LinkFaults& faults_;
  Joint& joint_;
};

}  // namespace mwidth::device::emulator
