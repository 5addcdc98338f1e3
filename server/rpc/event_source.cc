#include "server/rpc/event_source.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "server/record/event_log.h"
#include "server/rpc/convert_record.h"
#include "server/rpc/status.h"
#include "server/rpc/stream_refusals.h"

namespace mwidth::rpc {
namespace {

class EventSource final : public StreamSource {
 public:
  EventSource(std::string axis, std::unique_ptr<record::EventSubscription> subscription)
      : axis_(std::move(axis)), subscription_(std::move(subscription)) {}

  bool Pull(grpc::ByteBuffer& message, std::optional<grpc::Status>& end) override {
    if (const auto delivery = subscription_->Take()) {
      v1::StreamEventsResponse response;
      Convert(axis_, delivery->event, *response.mutable_event());
      response.set_lost_before(delivery->lost_before);
      message = BytesOf(response);
      return true;
    }
    if (subscription_->ended()) {
      end = ShuttingDown();
    }
    return false;
  }

 private:
  const std::string axis_;
  const std::unique_ptr<record::EventSubscription> subscription_;
};

}  // namespace

std::unique_ptr<StreamSource> OpenEvents(const AxisRegistry& axes, const v1::StreamEventsRequest& request,
                                         std::function<void()> wake, grpc::Status& refusal) {
  const gate::Result<const Axis*> axis = axes.Find(request.axis());
  if (!axis.ok()) {
    refusal = ToStatus(axis.refusal());
    return nullptr;
  }
  record::EventLog& events = (*axis)->events;
  const uint64_t after = request.has_after_number() ? request.after_number() : events.newest();
  auto subscription = events.Subscribe(after, kMaxEventStreams, std::move(wake));
  if (subscription == nullptr) {
    refusal = TooManyStreams((*axis)->name, kMaxEventStreams);
    return nullptr;
  }
  return std::make_unique<EventSource>((*axis)->name, std::move(subscription));
}

}  // namespace mwidth::rpc
