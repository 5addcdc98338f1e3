#include "tests/bench/links/answering_peer.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <system_error>

namespace mwidth::bench {
namespace {

constexpr std::size_t kHeaderBytes = 7;
constexpr uint8_t kReadRegisters = 3;
constexpr uint8_t kWriteRegisters = 16;

using Frame = std::array<uint8_t, 260>;

// Turns a request into its answer; returns the answer's size.
std::size_t AnswerTo(Frame& frame) {
  const uint8_t function = frame[kHeaderBytes];
  std::size_t pdu = 5;  // function 16 echoes function, address and count
  if (function != kWriteRegisters) {
    // Function 23 has the count where function 3 has it.
    const uint8_t bytes = static_cast<uint8_t>(2 * frame[kHeaderBytes + 4]);
    frame[kHeaderBytes + 1] = bytes;
    for (std::size_t i = 0; i < bytes; ++i) {
      frame[kHeaderBytes + 2 + i] = 0;
    }
    pdu = 2U + bytes;
  }
  frame[5] = static_cast<uint8_t>(pdu + 1);
  return kHeaderBytes + pdu;
}

}  // namespace

void PinTo(int cpu) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  pthread_setaffinity_np(pthread_self(), sizeof(cpus), &cpus);
}

AnsweringPeer::AnsweringPeer() : listening_(socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* name = reinterpret_cast<sockaddr*>(&address);
  if (listening_ < 0 || bind(listening_, name, size) != 0 || listen(listening_, 1) != 0 ||
      getsockname(listening_, name, &size) != 0) {
    throw std::system_error(errno, std::generic_category(), "the peer cannot listen");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { Answer(); });
}

AnsweringPeer::~AnsweringPeer() {
  thread_.join();
  close(listening_);
}

void AnsweringPeer::Answer() const {
  PinTo(1);
  const int connection = accept(listening_, nullptr, nullptr);
  constexpr int kOn = 1;
  setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &kOn, sizeof(kOn));
  Frame frame{};
  // A request comes in one piece: it is small, and the next one waits for its answer.
  while (recv(connection, frame.data(), frame.size(), 0) > 0) {
    send(connection, frame.data(), AnswerTo(frame), MSG_NOSIGNAL);
  }
  close(connection);
}

}  // namespace mwidth::bench
