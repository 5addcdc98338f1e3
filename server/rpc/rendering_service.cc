#include "server/rpc/rendering_service.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include "server/gate/axis_gate.h"
#include "server/rpc/command_events.h"
#include "server/rpc/convert.h"
#include "server/rpc/convert_analysis.h"
#include "server/rpc/describe_state.h"
#include "server/rpc/on_axis.h"

namespace mwidth::rpc {
namespace {

using exchange::LoopStatus;

constexpr std::size_t kMaxReasonBytes = 200;

/// On one line of the log, whatever a client sent.
std::string Printable(std::string text) {
  text.resize(std::min(text.size(), kMaxReasonBytes));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char byte) { return byte < ' ' || byte == 0x7f; }, ' ');
  return text;
}

/// Every axis that stopped, or a refusal that tells which did not and which did.
grpc::Status TellStops(const AxisRegistry& axes, const std::vector<gate::Result<LoopStatus>>& answers,
                       v1::EmergencyStopResponse& response) {
  const gate::Refusal* refusal = nullptr;
  std::string silent;
  std::string stopped;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& name = axes.axes()[i].name;
    if (answers[i].ok()) {
      response.add_axes(name);
      response.add_states(Convert(answers[i]->state));
    } else {
      refusal = &answers[i].refusal();
    }
    std::string& list = answers[i].ok() ? stopped : silent;
    list += (list.empty() ? "" : ", ") + name;
  }
  if (refusal == nullptr) {
    return grpc::Status::OK;
  }
  gate::Refusal told = *refusal;
  told.message = "Not known to have stopped: " + silent +
                 ". Stopped: " + (stopped.empty() ? "none" : stopped) + ". " + told.message;
  told.metadata["silent_axes"] = silent;
  told.metadata["stopped_axes"] = stopped;
  return ToStatus(told);
}

}  // namespace

RenderingService::RenderingService(const AxisRegistry& axes, std::string server_version)
    : axes_(axes), server_version_(std::move(server_version)) {}

gate::Result<std::vector<const Axis*>> RenderingService::FindOneOrAll(const std::string& name) const {
  std::vector<const Axis*> found;
  if (name.empty()) {
    for (const Axis& axis : axes_.axes()) {
      found.push_back(&axis);
    }
    return found;
  }
  const gate::Result<const Axis*> axis = axes_.Find(name);
  if (!axis.ok()) {
    return axis.refusal();
  }
  found.push_back(*axis);
  return found;
}

grpc::Status RenderingService::GetState(grpc::ServerContext*, const v1::GetStateRequest* request,
                                        v1::GetStateResponse* response) {
  return Guarded("GetState", [&] {
    const auto axes = FindOneOrAll(request->axis());
    if (!axes.ok()) {
      return ToStatus(axes.refusal());
    }
    for (const Axis* axis : *axes) {
      Describe(axis->gate, *response->add_axes());
    }
    response->set_server_version(server_version_);
    return grpc::Status::OK;
  });
}

grpc::Status RenderingService::AcquireControl(grpc::ServerContext*, const v1::AcquireControlRequest* request,
                                              v1::AcquireControlResponse* response) {
  const double ttl_s = request->has_ttl() ? Seconds(request->ttl()) : gate::kDefaultLeaseTtlS;
  return OnAxis(
      "AcquireControl", axes_, request->axis(),
      [&](const Axis& axis) {
        auto lease = axis.gate.AcquireControl(request->client_name(), ttl_s);
        TellControl(axis, lease);
        return lease;
      },
      [&](const gate::Lease& lease) { Convert(lease, *response->mutable_lease()); });
}

grpc::Status RenderingService::RenewControl(grpc::ServerContext*, const v1::RenewControlRequest* request,
                                            v1::RenewControlResponse* response) {
  return OnAxis(
      "RenewControl", axes_, request->axis(),
      [&](const Axis& axis) { return axis.gate.RenewControl(request->lease_id()); },
      [&](const gate::Lease& lease) { Convert(lease, *response->mutable_lease()); });
}

grpc::Status RenderingService::ReleaseControl(grpc::ServerContext*, const v1::ReleaseControlRequest* request,
                                              v1::ReleaseControlResponse*) {
  return OnAxis(
      "ReleaseControl", axes_, request->axis(),
      [&](const Axis& axis) {
        const std::string holder = axis.gate.Controller();
        auto released = axis.gate.ReleaseControl(request->lease_id());
        // A silent loop does not hold the lease back.
        if (released.ok() || released.refusal().reason == gate::kLoopSilent) {
          TellRelease(axis, holder);
        }
        return released;
      },
      [](const LoopStatus&) {});
}

grpc::Status RenderingService::StartRendering(grpc::ServerContext*, const v1::StartRenderingRequest* request,
                                              v1::StartRenderingResponse* response) {
  return OnAxis(
      "StartRendering", axes_, request->axis(),
      [&](const Axis& axis) { return axis.gate.StartRendering(request->lease_id()); },
      [&](const LoopStatus& status) {
        response->set_state(Convert(status.state));
        response->set_tick(status.tick);
      });
}

grpc::Status RenderingService::StopRendering(grpc::ServerContext*, const v1::StopRenderingRequest* request,
                                             v1::StopRenderingResponse* response) {
  return OnAxis(
      "StopRendering", axes_, request->axis(),
      [&](const Axis& axis) { return axis.gate.StopRendering(request->lease_id()); },
      [&](const LoopStatus& status) {
        response->set_state(Convert(status.state));
        response->set_tick(status.tick);
      });
}

grpc::Status RenderingService::SetMass(grpc::ServerContext*, const v1::SetMassRequest* request,
                                       v1::SetMassResponse* response) {
  const gate::MassRequest mass{
      .mass = request->mass(),
      .validate_only = request->validate_only(),
      .ramp_s = request->has_ramp() ? Seconds(request->ramp()) : gate::kDefaultRampS};
  return OnAxis(
      "SetMass", axes_, request->axis(),
      [&](const Axis& axis) {
        auto answer = axis.gate.SetMass(request->lease_id(), mass);
        TellMass(axis, mass, answer);
        return answer;
      },
      [&](const gate::MassGrant& grant) {
        response->set_mass(grant.mass);
        Convert(grant.stability, *response->mutable_stability());
        Convert(grant.accuracy, *response->mutable_accuracy());
        response->set_tick(grant.tick);
      });
}

grpc::Status RenderingService::SetFilter(grpc::ServerContext*, const v1::SetFilterRequest* request,
                                         v1::SetFilterResponse* response) {
  return OnAxis(
      "SetFilter", axes_, request->axis(),
      [&](const Axis& axis) -> gate::Result<gate::FilterGrant> {
        if (auto refusal = CheckEstimator(request->estimator())) {
          return *std::move(refusal);
        }
        const model::EstimatorKind running = axis.gate.stability()->loop().estimator;
        auto answer = axis.gate.SetFilter(request->lease_id(),
                                          {.estimator = Estimator(request->estimator()).value_or(running),
                                           .cutoff_hz = request->cutoff_hz(),
                                           .validate_only = request->validate_only()});
        TellFilter(axis, request->validate_only(), answer);
        return answer;
      },
      [&](const gate::FilterGrant& grant) {
        Convert(grant.loop, *response->mutable_loop());
        Convert(grant.stability, *response->mutable_stability());
        response->set_tick(grant.tick);
      });
}

grpc::Status RenderingService::EmergencyStop(grpc::ServerContext* context,
                                             const v1::EmergencyStopRequest* request,
                                             v1::EmergencyStopResponse* response) {
  return Guarded("EmergencyStop", [&] {
    // Whatever the request names, every axis; and every one is told before any is waited for.
    std::vector<gate::Posted> posted;
    for (const Axis& axis : axes_.axes()) {
      posted.push_back(axis.gate.PostEmergencyStop());
    }
    const std::string by = context->peer() + ", axis '" + Printable(request->axis()) + "'";
    const std::string reason = Printable(request->reason());
    std::cerr << "mwidthd: emergency stop by " << by << ": " << reason << std::endl;
    for (const Axis& axis : axes_.axes()) {
      TellEmergencyStop(axis, by, reason);
    }
    std::vector<gate::Result<LoopStatus>> answers;
    for (std::size_t i = 0; i < posted.size(); ++i) {
      answers.push_back(axes_.axes()[i].gate.AwaitEmergencyStop(posted[i]));
    }
    return TellStops(axes_, answers, *response);
  });
}

grpc::Status RenderingService::ClearFault(grpc::ServerContext*, const v1::ClearFaultRequest* request,
                                          v1::ClearFaultResponse* response) {
  return OnAxis(
      "ClearFault", axes_, request->axis(),
      [&](const Axis& axis) { return axis.gate.ClearFault(request->lease_id()); },
      [&](const LoopStatus& status) { response->set_state(Convert(status.state)); });
}

}  // namespace mwidth::rpc
