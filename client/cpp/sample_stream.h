// The samples of an axis, batch by batch.
#pragma once

#include <grpcpp/client_context.h>
#include <mwidth/v1/telemetry.grpc.pb.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "client/cpp/failure.h"

namespace mwidth::client {

/// Ticks without a sample among the batches read so far.
struct StreamGaps {
  /// Never ran: the loop missed their deadline.
  uint64_t missed_ticks = 0;
  /// Ran, but were not delivered here: this reader was too slow.
  uint64_t dropped_ticks = 0;

  uint64_t Total() const { return missed_ticks + dropped_ticks; }
};

/// A running stream of samples. Next is for one thread at a time; Cancel may come from any other. The
/// destructor cancels what is still running.
class SampleStream {
 public:
  /// Sends the request; Client::Stream calls this. Sizes and reduction as in StreamSamplesRequest.
  SampleStream(std::shared_ptr<v1::TelemetryService::StubInterface> stub,
               const v1::StreamSamplesRequest& request);
  SampleStream(const SampleStream&) = delete;
  SampleStream& operator=(const SampleStream&) = delete;
  ~SampleStream();

  /// Blocks for the next batch. None after Cancel. Throws Error when the server ended the stream or is gone.
  std::optional<v1::SampleBatch> Next();
  /// Makes a blocked and every later Next return none. Does not block. Any thread.
  void Cancel();
  /// Sum over all batches that Next has returned. On the thread that calls Next.
  const StreamGaps& gaps() const { return gaps_; }

 private:
  std::shared_ptr<v1::TelemetryService::StubInterface> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderInterface<v1::StreamSamplesResponse>> reader_;
  std::atomic<bool> cancelled_ = false;
  bool finished_ = false;
  StreamGaps gaps_;
};

}  // namespace mwidth::client
