// The far end of a Modbus line that says exactly what a test wants it to say.
#pragma once

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace mwidth::device::modbus::testing {

using Bytes = std::vector<uint8_t>;
/// What is sent back, piece by piece; an empty one closes the connection.
using Pieces = std::vector<Bytes>;
using Script = std::function<Pieces(const Bytes& request)>;

/// Answers on a descriptor from a thread of its own until it goes.
class ScriptedPeer {
 public:
  ScriptedPeer(int file, Script script)
      : file_(file),
        script_(std::move(script)),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}
  ScriptedPeer(const ScriptedPeer&) = delete;
  ScriptedPeer& operator=(const ScriptedPeer&) = delete;
  ~ScriptedPeer() {
    thread_.request_stop();
    thread_.join();
    close(file_);
  }

 private:
  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      pollfd wait{.fd = file_, .events = POLLIN, .revents = 0};
      constexpr int kTurnMs = 20;
      if (poll(&wait, 1, kTurnMs) <= 0) {
        continue;
      }
      Bytes request(260);
      const ssize_t size = read(file_, request.data(), request.size());
      if (size <= 0) {
        return;
      }
      request.resize(static_cast<std::size_t>(size));
      for (const Bytes& piece : script_(request)) {
        if (piece.empty()) {
          shutdown(file_, SHUT_RDWR);
          return;
        }
        if (write(file_, piece.data(), piece.size()) < 0) {
          return;
        }
      }
    }
  }

  const int file_;
  const Script script_;
  std::jthread thread_;
};

/// A listening TCP socket on a free port of the loopback interface.
class Listener {
 public:
  Listener() : file_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    if (bind(file_, generic, size) < 0 || listen(file_, 4) < 0 || getsockname(file_, generic, &size) < 0) {
      throw std::runtime_error("no port to listen on");
    }
    port_ = ntohs(address.sin_port);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() { close(file_); }

  int file() const { return file_; }
  uint16_t port() const { return port_; }
  int Accept() const { return accept(file_, nullptr, nullptr); }

 private:
  int file_;
  uint16_t port_ = 0;
};

}  // namespace mwidth::device::modbus::testing
