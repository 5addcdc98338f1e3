#include "server/rpc/stability_service.h"

#include "server/gate/figures.h"
#include "server/gate/stability_gate.h"
#include "server/rpc/convert.h"
#include "server/rpc/on_axis.h"

namespace mwidth::rpc {
namespace {

gate::Result<gate::StabilityGate> Judge(const model::LoopParameters& loop, double required_gain_margin_db) {
  if (const auto error = model::Validate(loop)) {
    return gate::Refusal{
        .code = gate::RefusalCode::kInvalidArgument,
        .reason = gate::kInvalidNumber,
        .message = error->Message(),
        .metadata = {
            {"field", error->parameter}, {"value", gate::Figure(error->value)}, {"allowed", error->allowed}}};
  }
  return gate::StabilityGate(loop, required_gain_margin_db);
}

}  // namespace

grpc::Status StabilityService::GetMWidth(grpc::ServerContext*, const v1::GetMWidthRequest* request,
                                         v1::GetMWidthResponse* response) {
  return OnAxis(
      "GetMWidth", axes_, request->axis(),
      [&](gate::AxisGate& gate) {
        const gate::AxisDescription& axis = gate.description();
        return Judge(Override(axis.loop, request->loop()), axis.required_gain_margin_db);
      },
      [&](const gate::StabilityGate& judged) {
        Convert(judged.range(), *response->mutable_m_width());
        Convert(judged.loop(), *response->mutable_loop());
      });
}

}  // namespace mwidth::rpc
