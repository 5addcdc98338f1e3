#include <grpcpp/alarm.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "mwidth/v1/telemetry.grpc.pb.h"
#include "server/record/batcher.h"
#include "server/rpc/sample_encoding.h"
#include "tests/bench/streams/feeder.h"
#include "tests/bench/streams/servers.h"

namespace mwidth::bench {
namespace {

using Service = v1::TelemetryService::WithRawMethod_StreamSamples<v1::TelemetryService::Service>;

class BareGrpcServer final : public StreamServer {
 public:
  explicit BareGrpcServer(std::size_t batch) : batcher_({.min_batch = batch, .max_batch = batch}) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    queue_ = builder.AddCompletionQueue();
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
    Await();
    // Both run until the process ends.
    std::thread([this] { Serve(); }).detach();
    feeder_ = std::make_unique<Feeder>([this](const exchange::Sample& sample) {
      batcher_.Take({&sample, 1}, [this](const record::Batch& cut) { Offer(cut); });
    });
  }

  std::string address() const override { return address_; }
  // Encodes on the feeder's thread: nothing counts but the sending.
  double FeederCpuS() const override { return feeder_->CpuS(); }

 private:
  struct Call {
    grpc::ServerContext context;
    grpc::ByteBuffer request;
    grpc::ServerAsyncWriter<grpc::ByteBuffer> writer{&context};
    // Open, and the last write is done.
    bool idle = false;
    std::function<void()> on_call;
    std::function<void()> on_written = [this] { idle = true; };
  };

  void Await() {
    Call& call = *calls_.emplace_back(std::make_unique<Call>());
    call.on_call = [this, &call] {
      call.writer.SendInitialMetadata(&call.on_written);
      Await();
    };
    service_.RequestStreamSamples(&call.context, &call.request, &call.writer, queue_.get(), queue_.get(),
                                  &call.on_call);
  }

  void Offer(const record::Batch& batch) {
    const grpc::Slice bytes(encode_(batch));
    {
      const std::lock_guard lock(mutex_);
      next_ = grpc::ByteBuffer(&bytes, 1);
    }
    // One that comes before the last one was written to all is lost: this server falls behind.
    if (!waking_.exchange(true)) {
      alarm_.Set(queue_.get(), gpr_now(GPR_CLOCK_MONOTONIC), &write_to_all_);
    }
  }

  void WriteToAll() {
    waking_ = false;
    grpc::ByteBuffer bytes;
    {
      const std::lock_guard lock(mutex_);
      bytes = next_;
    }
    for (const auto& call : calls_) {
      if (call->idle) {
        call->idle = false;
        call->writer.Write(bytes, &call->on_written);
      }
    }
  }

  void Serve() {
    void* tag = nullptr;
    bool ok = false;
    while (queue_->Next(&tag, &ok)) {
      (*static_cast<std::function<void()>*>(tag))();
    }
  }

  Service service_;
  record::Batcher batcher_;
  const record::Encode encode_ = rpc::SampleEncoding("joint");
  std::unique_ptr<grpc::ServerCompletionQueue> queue_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  std::mutex mutex_;
  grpc::ByteBuffer next_;
  std::atomic<bool> waking_ = false;
  std::function<void()> write_to_all_ = [this] { WriteToAll(); };
  grpc::Alarm alarm_;
  std::vector<std::unique_ptr<Call>> calls_;
  std::unique_ptr<Feeder> feeder_;
};

}  // namespace

std::unique_ptr<StreamServer> MakeBareGrpcServer(std::size_t batch) {
  return std::make_unique<BareGrpcServer>(batch);
}

}  // namespace mwidth::bench
