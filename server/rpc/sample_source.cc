#include "server/rpc/sample_source.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/status.h"
#include "server/rpc/stream_refusals.h"
#include "server/rpc/stream_request.h"

namespace mwidth::rpc {
namespace {

class SampleSource final : public StreamSource {
 public:
  explicit SampleSource(std::unique_ptr<record::Subscription> subscription)
      : subscription_(std::move(subscription)) {}

  bool Pull(grpc::ByteBuffer& message, std::optional<grpc::Status>& end) override {
    if (subscription_->Take(delivery_)) {
      message = Assemble(delivery_);
      return true;
    }
    if (subscription_->ended()) {
      end = ShuttingDown();
    }
    return false;
  }

 private:
  const std::unique_ptr<record::Subscription> subscription_;
  record::Delivery delivery_;
};

}  // namespace

std::unique_ptr<StreamSource> OpenSamples(const AxisRegistry& axes, const v1::StreamSamplesRequest& request,
                                          std::function<void()> wake, grpc::Status& refusal) {
  const gate::Result<record::Cut> cut = CutOf(request);
  if (!cut.ok()) {
    refusal = ToStatus(cut.refusal());
    return nullptr;
  }
  const gate::Result<const Axis*> axis = axes.Find(request.axis());
  if (!axis.ok()) {
    refusal = ToStatus(axis.refusal());
    return nullptr;
  }
  // The ring still holds ticks that ran before: to a client that began to render, they would read as an end.
  const uint64_t first_tick = (*axis)->gate.Status().tick + 1;
  record::Broadcast& broadcast = (*axis)->broadcast;
  auto subscription = broadcast.Subscribe(*cut, first_tick, std::move(wake));
  if (subscription == nullptr) {
    refusal = TooManyStreams((*axis)->name, broadcast.limits().max_subscribers);
    return nullptr;
  }
  return std::make_unique<SampleSource>(std::move(subscription));
}

}  // namespace mwidth::rpc
