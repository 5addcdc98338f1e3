#include "server/rpc/stability_service.h"

#include <string>

#include "server/gate/axis_gate.h"
#include "server/gate/stability_gate.h"
#include "server/model/margins.h"
#include "server/rpc/convert.h"
#include "server/rpc/convert_analysis.h"
#include "server/rpc/on_axis.h"

namespace mwidth::rpc {
namespace {

gate::Refusal TooManyComputations() {
  const std::string most = std::to_string(StabilityService::kMostComputations);
  return {.code = gate::RefusalCode::kResourceExhausted,
          .reason = gate::kTooManyComputations,
          .message = "This server runs " + most +
                     " sweeps and simulations at once, and does so already: ask again when one has ended.",
          .metadata = {{"most", most}}};
}

/// What GetFrequencyResponse was asked for.
struct FrequencyResponseQuery {
  model::LoopParameters loop;
  double mass = 0;
  model::FrequencyRange frequencies;
  model::ResponseModel model = model::ResponseModel::kDiscrete;
};

gate::Result<FrequencyResponseQuery> Read(const model::LoopParameters& own,
                                          const v1::GetFrequencyResponseRequest& request) {
  const auto loop = ReadLoop(own, request.loop());
  if (!loop.ok()) {
    return loop.refusal();
  }
  const auto mass = ReadMass(request.mass());
  if (!mass.ok()) {
    return mass.refusal();
  }
  const auto frequencies = ReadFrequencies(request, loop->period_s);
  if (!frequencies.ok()) {
    return frequencies.refusal();
  }
  const auto model = ReadModel(request.model(), *loop);
  if (!model.ok()) {
    return model.refusal();
  }
  return FrequencyResponseQuery{*loop, *mass, *frequencies, *model};
}

/// What GetAccuracy was asked for.
struct AccuracyQuery {
  model::LoopParameters loop;
  double mass = 0;
  model::MotionBand band;
};

gate::Result<AccuracyQuery> Read(const model::LoopParameters& own, const v1::GetAccuracyRequest& request) {
  const auto loop = ReadLoop(own, request.loop());
  if (!loop.ok()) {
    return loop.refusal();
  }
  const auto mass = ReadMass(request.mass());
  if (!mass.ok()) {
    return mass.refusal();
  }
  const auto band = ReadBand(request.band(), loop->period_s);
  if (!band.ok()) {
    return band.refusal();
  }
  return AccuracyQuery{*loop, *mass, *band};
}

}  // namespace

grpc::Status StabilityService::GetMWidth(grpc::ServerContext*, const v1::GetMWidthRequest* request,
                                         v1::GetMWidthResponse* response) {
  return OnAxis(
      "GetMWidth", axes_, request->axis(),
      [&](const Axis& axis) -> gate::Result<gate::StabilityGate> {
        gate::AxisGate& gate = axis.gate;
        if (AsksOfTheAxisItself(*request)) {
          return *gate.stability();
        }
        const auto loop = ReadLoop(gate.stability()->loop(), request->loop());
        if (!loop.ok()) {
          return loop.refusal();
        }
        const auto requirements = ReadAssumptions(gate.description().Requirements(), *loop, *request);
        if (!requirements.ok()) {
          return requirements.refusal();
        }
        return Judge(*loop, *requirements);
      },
      [&](const gate::StabilityGate& judged) {
        Convert(judged.range(), *response->mutable_m_width());
        Convert(judged.loop(), *response->mutable_loop());
      });
}

gate::Result<gate::StabilityGate> StabilityService::Judge(const model::LoopParameters& loop,
                                                          const gate::Requirements& requirements) {
  if (gate::AssumesOneLoop(loop, requirements)) {
    return gate::StabilityGate(loop, requirements);
  }
  const ComputationLimit::Place place(computations_);
  if (!place.taken()) {
    return TooManyComputations();
  }
  return AtLowPriority([&] { return gate::StabilityGate(loop, requirements, certificates_); });
}

grpc::Status StabilityService::SweepMWidth(grpc::ServerContext* context,
                                           const v1::SweepMWidthRequest* request,
                                           grpc::ServerWriter<v1::SweepMWidthResponse>* writer) {
  return Guarded("SweepMWidth", [&]() -> grpc::Status {
    const gate::Result<const Axis*> axis = axes_.Find(request->axis());
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    const gate::Result<model::Sweep> sweep = ReadSweep((*axis)->gate.stability()->loop(), *request);
    if (!sweep.ok()) {
      return ToStatus(sweep.refusal());
    }
    const ComputationLimit::Place place(computations_);
    if (!place.taken()) {
      return ToStatus(TooManyComputations());
    }
    const bool complete = model::RunSweep(*sweep, {.threads = 0, .prepare_thread = LowerPriority, .stop = {}},
                                          [&](const model::SweepRow& row) {
                                            v1::SweepMWidthResponse message;
                                            Convert(row, message);
                                            return !context->IsCancelled() && writer->Write(message);
                                          });
    return complete ? grpc::Status::OK : grpc::Status::CANCELLED;
  });
}

grpc::Status StabilityService::GetFrequencyResponse(grpc::ServerContext*,
                                                    const v1::GetFrequencyResponseRequest* request,
                                                    v1::GetFrequencyResponseResponse* response) {
  return OnAxis(
      "GetFrequencyResponse", axes_, request->axis(),
      [&](const Axis& axis) { return Read(axis.gate.stability()->loop(), *request); },
      [&](const FrequencyResponseQuery& query) {
        Convert(query.loop, *response->mutable_loop());
        Convert(model::ComputeBode(query.loop, query.mass, query.frequencies, query.model), *response);
        Convert(model::ComputeMargins(query.loop, query.mass), *response->mutable_margins());
      });
}

grpc::Status StabilityService::GetAccuracy(grpc::ServerContext*, const v1::GetAccuracyRequest* request,
                                           v1::GetAccuracyResponse* response) {
  return Guarded("GetAccuracy", [&]() -> grpc::Status {
    const gate::Result<const Axis*> axis = axes_.Find(request->axis());
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    const gate::Result<AccuracyQuery> query = Read((*axis)->gate.stability()->loop(), *request);
    if (!query.ok()) {
      return ToStatus(query.refusal());
    }
    gate::MassAccuracy accuracy = gate::PredictAccuracy(query->loop, query->mass, query->band,
                                                        (*axis)->gate.description().position_quantum,
                                                        (*axis)->gate.description().acceleration_quantum);
    if (request->simulate()) {
      const ComputationLimit::Place place(computations_);
      if (!place.taken()) {
        return ToStatus(TooManyComputations());
      }
      AtLowPriority([&] { gate::SimulateAccuracy(query->loop, query->mass, query->band, accuracy); });
    }
    Convert(query->loop, *response->mutable_loop());
    Convert(accuracy, *response->mutable_accuracy());
    return grpc::Status::OK;
  });
}

}  // namespace mwidth::rpc
