#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "server/rpc/sample_encoding.h"
#include "tests/bench/streams/feeder.h"
#include "tests/bench/streams/servers.h"

namespace mwidth::bench {
namespace {

class TcpServer final : public StreamServer {
 public:
  explicit TcpServer(std::size_t batch)
      : batcher_({.min_batch = batch, .max_batch = batch}), listening_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* name = reinterpret_cast<sockaddr*>(&address);
    if (listening_ < 0 || bind(listening_, name, size) != 0 || listen(listening_, 4096) != 0 ||
        getsockname(listening_, name, &size) != 0) {
      throw std::system_error(errno, std::generic_category(), "cannot listen");
    }
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    accepting_ = std::thread([this] { Accept(); });
    feeder_ = std::make_unique<Feeder>([this](const exchange::Sample& sample) {
      batcher_.Take({&sample, 1}, [this](const record::Batch& cut) { Send(cut); });
    });
  }
  ~TcpServer() override {
    feeder_.reset();
    shutdown(listening_, SHUT_RDWR);
    accepting_.join();
    close(listening_);
    for (const int connection : connections_) {
      close(connection);
    }
  }

  std::string address() const override { return address_; }
  // Sends from the feeder's thread, of which nothing but the sending counts.
  double FeederCpuS() const override { return feeder_->CpuS() - sending_s_; }

 private:
  void Accept() {
    for (int connection = 0; (connection = accept(listening_, nullptr, nullptr)) >= 0;) {
      constexpr int kOn = 1;
      setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &kOn, sizeof(kOn));
      const std::lock_guard lock(mutex_);
      connections_.push_back(connection);
    }
  }

  void Send(const record::Batch& batch) {
    const std::string bytes = encode_(batch);
    const auto length = static_cast<uint32_t>(bytes.size());
    std::string framed(reinterpret_cast<const char*>(&length), sizeof(length));
    framed += bytes;
    const double begin_s = feeder_->CpuS();
    {
      const std::lock_guard lock(mutex_);
      for (const int connection : connections_) {
        send(connection, framed.data(), framed.size(), MSG_NOSIGNAL);
      }
    }
    sending_s_ = sending_s_ + feeder_->CpuS() - begin_s;
  }

  record::Batcher batcher_;
  const record::Encode encode_ = rpc::SampleEncoding("joint");
  int listening_;
  std::string address_;
  std::mutex mutex_;
  std::vector<int> connections_;
  std::thread accepting_;
  std::atomic<double> sending_s_ = 0;
  std::unique_ptr<Feeder> feeder_;
};

}  // namespace

std::unique_ptr<StreamServer> MakeTcpServer(std::size_t batch) { return std::make_unique<TcpServer>(batch); }

}  // namespace mwidth::bench
