#include "client/cpp/sample_stream.h"

#include <utility>

namespace mwidth::client {

SampleStream::SampleStream(std::shared_ptr<v1::TelemetryService::StubInterface> stub,
                           const v1::StreamSamplesRequest& request)
    : stub_(std::move(stub)), reader_(stub_->StreamSamples(&context_, request)) {}

SampleStream::~SampleStream() {
  if (!finished_) {
    context_.TryCancel();
    // What was sent before the cancellation must be read before the call can be finished.
    v1::StreamSamplesResponse unread;
    while (reader_->Read(&unread)) {
    }
    reader_->Finish();
  }
}

std::optional<v1::SampleBatch> SampleStream::Next() {
  v1::StreamSamplesResponse response;
  while (!finished_ && !cancelled_) {
    if (reader_->Read(&response)) {
      // A cancelled stream may still hold batches; none of them is returned, as promised.
      if (cancelled_) {
        continue;
      }
      gaps_.missed_ticks += response.batch().missed_ticks_before();
      gaps_.dropped_ticks += response.batch().dropped_ticks_before();
      return std::move(*response.mutable_batch());
    }
    finished_ = true;
    const auto status = reader_->Finish();
    if (cancelled_) {
      break;
    }
    // A stream of samples has no end of its own.
    throw status.ok() ? Error({grpc::StatusCode::UNAVAILABLE, "the server ended the stream"})
                      : CallError(status);
  }
  return std::nullopt;
}

void SampleStream::Cancel() {
  cancelled_ = true;
  context_.TryCancel();
}

}  // namespace mwidth::client
