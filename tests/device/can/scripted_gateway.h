// The far end of a socketcand connection that says exactly what a test wants it to say.
#pragma once

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

namespace mwidth::device::can::testing {

/// A socketcand gateway on a free port of the loopback interface, driven by the test's own thread.
class ScriptedGateway {
 public:
  ScriptedGateway() : listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    if (bind(listener_, generic, size) < 0 || listen(listener_, 4) < 0 ||
        getsockname(listener_, generic, &size) < 0) {
      throw std::runtime_error("no port to listen on");
    }
    port_ = ntohs(address.sin_port);
  }
  ScriptedGateway(const ScriptedGateway&) = delete;
  ScriptedGateway& operator=(const ScriptedGateway&) = delete;
  ~ScriptedGateway() {
    HangUp();
    close(listener_);
  }

  uint16_t port() const { return port_; }
  void Accept() { peer_ = accept(listener_, nullptr, nullptr); }
  /// Accepts and speaks as socketcand does until it is in raw mode; what it was asked for is in `asked`.
  void AcceptIntoRawMode() {
    Accept();
    Say("< hi >");
    asked = Hear("< open can0 >");
    Say("< ok >");
    asked += Hear("< rawmode >");
    Say("< ok >");
  }
  void Say(std::string_view text) const { send(peer_, text.data(), text.size(), MSG_NOSIGNAL); }
  /// What comes, up to and with `last`, or until nothing comes any more.
  std::string Hear(std::string_view last) const {
    std::string heard;
    while (!heard.ends_with(last)) {
      pollfd wait{.fd = peer_, .events = POLLIN, .revents = 0};
      constexpr int kPatienceMs = 2000;
      char byte = 0;
      if (poll(&wait, 1, kPatienceMs) <= 0 || read(peer_, &byte, 1) <= 0) {
        break;
      }
      heard += byte;
    }
    return heard;
  }
  void HangUp() {
    if (peer_ >= 0) {
      close(peer_);
      peer_ = -1;
    }
  }

  std::string asked;

 private:
  int listener_;
  int peer_ = -1;
  uint16_t port_ = 0;
};

}  // namespace mwidth::device::can::testing
