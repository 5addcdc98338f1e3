#include "tests/bench/streams/readers.h"

#include <arpa/inet.h>
#include <grpcpp/grpcpp.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <vector>

#include "client/cpp/channel_arguments.h"
#include "mwidth/v1/telemetry.grpc.pb.h"

namespace mwidth::bench {
namespace {

/// One subscriber's account.
class Account {
 public:
  void Add(const v1::SampleBatch& batch, Received& received) {
    const auto samples = static_cast<uint64_t>(batch.position_size());
    if (next_tick_ == 0) {
      ++received.subscribers;
    } else {
      received.absent_ticks += batch.first_tick() - next_tick_;
    }
    next_tick_ = batch.first_tick() + samples;
    received.samples += samples;
    ++received.messages;
  }

 private:
  uint64_t next_tick_ = 0;
};

struct Call {
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::TelemetryService::Stub> stub;
  grpc::ClientContext context;
  std::unique_ptr<grpc::ClientAsyncReader<v1::StreamSamplesResponse>> reader;
  v1::StreamSamplesResponse response;
  bool started = false;
  Account account;
};

int Connect(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &peer.sin_addr);
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  if (connect(connection, reinterpret_cast<sockaddr*>(&peer), sizeof(peer)) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot connect");
  }
  return connection;
}

struct Connection {
  int socket = -1;
  std::string unread;
  Account account;
};

// Takes what is there of one connection, which is readable.
void Take(Connection& connection, Received& received) {
  std::array<char, 65536> buffer{};
  const ssize_t size = recv(connection.socket, buffer.data(), buffer.size(), 0);
  if (size <= 0) {
    throw std::runtime_error("the server closed a connection");
  }
  connection.unread.append(buffer.data(), static_cast<std::size_t>(size));
  uint32_t length = 0;
  std::size_t used = 0;
  while (connection.unread.size() >= used + sizeof(length)) {
    std::memcpy(&length, connection.unread.data() + used, sizeof(length));
    if (connection.unread.size() < used + sizeof(length) + length) {
      break;
    }
    v1::StreamSamplesResponse response;
    response.ParseFromArray(connection.unread.data() + used + sizeof(length), static_cast<int>(length));
    connection.account.Add(response.batch(), received);
    used += sizeof(length) + length;
  }
  connection.unread.erase(0, used);
}

}  // namespace

void ReadGrpc(const std::string& address, std::size_t subscribers, std::size_t batch, Received& received,
              const std::atomic<bool>& over) {
  grpc::CompletionQueue queue;
  std::vector<std::unique_ptr<Call>> calls;
  v1::StreamSamplesRequest request;
  request.set_min_batch(static_cast<uint32_t>(batch));
  request.set_max_batch(static_cast<uint32_t>(batch));
  for (std::size_t i = 0; i < subscribers; ++i) {
    auto call = std::make_unique<Call>();
    grpc::ChannelArguments arguments = client::ChannelArguments();
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    call->channel = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
    call->stub = v1::TelemetryService::NewStub(call->channel);
    call->reader = call->stub->AsyncStreamSamples(&call->context, request, &queue, call.get());
    calls.push_back(std::move(call));
  }
  void* tag = nullptr;
  bool ok = false;
  while (!over && queue.Next(&tag, &ok)) {
    auto* call = static_cast<Call*>(tag);
    if (!ok) {
      throw std::runtime_error("the server ended a stream");
    }
    if (call->started) {
      call->account.Add(call->response.batch(), received);
    }
    call->started = true;
    call->reader->Read(&call->response, call);
  }
  // The process ends with its connections: no call needs to be finished.
  _exit(0);
}

void ReadTcp(const std::string& address, std::size_t subscribers, Received& received,
             const std::atomic<bool>& over) {
  const int events = epoll_create1(0);
  std::vector<Connection> connections(subscribers);
  for (Connection& connection : connections) {
    connection.socket = Connect(address);
    epoll_event event{.events = EPOLLIN, .data = {.ptr = &connection}};
    epoll_ctl(events, EPOLL_CTL_ADD, connection.socket, &event);
  }
  std::array<epoll_event, 64> ready{};
  while (!over) {
    const int count = epoll_wait(events, ready.data(), static_cast<int>(ready.size()), 1000);
    for (int i = 0; i < count; ++i) {
      Take(*static_cast<Connection*>(ready[static_cast<std::size_t>(i)].data.ptr), received);
    }
  }
  _exit(0);
}

}  // namespace mwidth::bench
