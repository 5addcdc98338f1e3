// Faults on demand: a word a line on standard input.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/streambuf.hpp>
#include <string>

#include "device/emulator/faults.h"
#include "device/emulator/joint.h"
#include "device/emulator/link.h"

namespace mwidth::device::emulator {

/// For --help.
inline constexpr const char* kCommandsHelp =
    "On standard input, one a line:\n"
    "  silence          answer and send nothing\n"
    "  exceptions       Modbus: answer every request with an exception\n"
    "  abort            CANopen: answer every SDO with an abort\n"
    "  wrong-order      exchange the halves of 32-bit numbers\n"
    "  delay SECONDS    answer late\n"
    "  dribble SECONDS  answer byte by byte, this far apart; not on SocketCAN\n"
    "  heartbeat-loss   CANopen: send no heartbeats\n"
    "  emcy CODE        CANopen: an error of the drive's own, in hexadecimal digits: FAULT, and an EMCY\n"
    "  freeze           show the same position for ever\n"
    "  jump COUNTS      add to every position from now on\n"
    "  well             none of these any more, but for jumps and FAULT\n"
    "  state            tell whether the motor is enabled, its force, and how often the watchdog fired";

/// Does what one line says, and returns what is to be said about it: "ok", the state, or that the line says
/// nothing that is known on this link.
std::string Obey(const std::string& line, LinkFaults& faults, Joint& joint, Link& link);

/// Reads lines until the input ends, and answers each.
class Commands {
 public:
  /// All references outlive it.
  Commands(boost::asio::io_context& context, LinkFaults& faults, Joint& joint, Link& link);

 private:
  void ReadLine();

  boost::asio::posix::stream_descriptor input_;
  boost::asio::streambuf buffer_;
  LinkFaults& faults_;
  Joint& joint_;
  Link& link_;
};

}  // namespace mwidth::device::emulator
