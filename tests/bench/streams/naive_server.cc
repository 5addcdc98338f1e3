#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "mwidth/v1/telemetry.grpc.pb.h"
#include "server/rpc/sample_encoding.h"
#include "tests/bench/streams/feeder.h"
#include "tests/bench/streams/servers.h"

namespace mwidth::bench {
namespace {

/// The newest samples, for handlers that wait for the next one.
class Newest {
 public:
  void Put(const exchange::Sample& sample) {
    {
      const std::lock_guard lock(mutex_);
      samples_[sample.tick % samples_.size()] = sample;
      tick_ = sample.tick;
    }
    changed_.notify_all();
  }

  uint64_t tick() {
    const std::lock_guard lock(mutex_);
    return tick_;
  }

  /// The sample of `tick`, or the oldest that is still there.
  exchange::Sample Await(uint64_t tick) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return tick_ >= tick; });
    const uint64_t oldest = tick_ < samples_.size() ? 1 : tick_ - samples_.size() + 1;
    return samples_[std::max(tick, oldest) % samples_.size()];
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::array<exchange::Sample, 16384> samples_{};
  uint64_t tick_ = 0;
};

class NaiveService final : public v1::TelemetryService::Service {
 public:
  explicit NaiveService(Newest& newest) : newest_(newest) {}

  grpc::Status StreamSamples(grpc::ServerContext* context, const v1::StreamSamplesRequest* /*request*/,
                             grpc::ServerWriter<v1::StreamSamplesResponse>* writer) override {
    record::Batch batch;
    uint64_t tick = newest_.tick() + 1;
    while (!context->IsCancelled()) {
      batch.samples.assign(1, newest_.Await(tick));
      batch.first_tick = batch.samples[0].tick;
      batch.dropped_ticks_before = batch.first_tick - tick;
      tick = batch.first_tick + 1;
      v1::StreamSamplesResponse response;
      rpc::Convert("joint", batch, *response.mutable_batch());
      if (!writer->Write(response)) {
        break;
      }
    }
    return grpc::Status::OK;
  }

 private:
  Newest& newest_;
};

class NaiveServer final : public StreamServer {
 public:
  NaiveServer() : feeder_([this](const exchange::Sample& sample) { newest_->Put(sample); }) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
  }
  ~NaiveServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  std::string address() const override { return "127.0.0.1:" + std::to_string(port_); }
  double FeederCpuS() const override { return feeder_.CpuS(); }

 private:
  const std::unique_ptr<Newest> newest_ = std::make_unique<Newest>();
  NaiveService service_{*newest_};
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
  // Last: a handler that waits goes on with the next sample.
  Feeder feeder_;
};

}  // namespace

std::unique_ptr<StreamServer> MakeNaiveServer() { return std::make_unique<NaiveServer>(); }

}  // namespace mwidth::bench
