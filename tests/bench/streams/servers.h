// Four ways to bring 1000 samples a second to many subscribers.
#pragma once

#include <memory>
#include <string>

namespace mwidth::bench {

/// A server that streams the samples of a Feeder from construction to destruction.
class StreamServer {
 public:
  StreamServer() = default;
  StreamServer(const StreamServer&) = delete;
  StreamServer& operator=(const StreamServer&) = delete;
  virtual ~StreamServer() = default;

  /// HOST:PORT.
  virtual std::string address() const = 0;
  /// CPU time of the feeder, which is no part of the streaming.
  virtual double FeederCpuS() const = 0;
};

/// mwidth's: ring, drain, broadcast and services, wired as mwidthd wires them.
std::unique_ptr<StreamServer> MakeSharedServer();
/// What one would write first: gRPC's synchronous API, one thread a subscriber that waits for each tick and
/// writes a message with its one sample. Waits for slow readers.
std::unique_ptr<StreamServer> MakeNaiveServer();
/// What gRPC itself costs: one thread and one completion queue, which write the same bytes to each call and
/// do nothing else; no health service, no counts of what is lost. Runs until the process ends.
std::unique_ptr<StreamServer> MakeBareGrpcServer(std::size_t batch);
/// No gRPC at all: every `batch` ticks one send() of the same bytes, behind their length, to each connection.
std::unique_ptr<StreamServer> MakeTcpServer(std::size_t batch);

}  // namespace mwidth::bench
