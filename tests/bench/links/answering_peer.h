// The far end of a Modbus TCP connection that costs as little as a peer can.
#pragma once

#include <cstdint>
#include <thread>

namespace mwidth::bench {

/// Keeps the calling thread on one CPU, where there is such a one.
void PinTo(int cpu);

/// A thread, on CPU 1, that answers each request on its one connection at once, with bare recv and send: what
/// it reads back is zeros, and the transaction is the request's. Ends when the connection does.
class AnsweringPeer {
 public:
  /// Listens on the loopback interface. Throws std::system_error.
  AnsweringPeer();
  AnsweringPeer(const AnsweringPeer&) = delete;
  AnsweringPeer& operator=(const AnsweringPeer&) = delete;
  /// Precondition: whoever connected has closed the connection.
  ~AnsweringPeer();

  uint16_t port() const { return port_; }

 private:
  void Answer() const;

  int listening_ = -1;
  uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace mwidth::bench
