// Between what the stability service computes and the messages of the API. Each Convert fills an empty
// message; each Read takes a request, sets what is unset in it to its default, and refuses what the model
// does not allow with INVALID_ARGUMENT (INVALID_NUMBER).
#pragma once

#include <optional>

#include "mwidth/v1/stability.pb.h"
#include "server/gate/mass_accuracy.h"
#include "server/gate/refusal.h"
#include "server/gate/requirements.h"
#include "server/model/accuracy.h"
#include "server/model/bode.h"
#include "server/model/loop_parameters.h"
#include "server/model/sweep.h"
#include "server/model/sweep_run.h"

namespace mwidth::rpc {

/// Why an estimator is none, if so; unspecified is fine.
std::optional<gate::Refusal> CheckEstimator(v1::EstimatorKind estimator);

/// `own` with the overrides of a request.
gate::Result<model::LoopParameters> ReadLoop(const model::LoopParameters& own,
                                             const v1::LoopParameters& overrides);

/// True where the request overrides nothing.
bool AsksOfTheAxisItself(const v1::GetMWidthRequest& request);

/// `own` with the hands and devices of a request that overrides something: those of its envelope and
/// tolerance, or exactly those of `loop`.
gate::Result<gate::Requirements> ReadAssumptions(gate::Requirements own, const model::LoopParameters& loop,
                                                 const v1::GetMWidthRequest& request);

/// -1e6 to 1e6.
gate::Result<double> ReadMass(double mass);

/// The sweep's grid; `own` as for ReadLoop.
gate::Result<model::Sweep> ReadSweep(const model::LoopParameters& own, const v1::SweepMWidthRequest& request);
gate::Result<model::MotionBand> ReadBand(const v1::MotionBand& band, double period_s);
gate::Result<model::FrequencyRange> ReadFrequencies(const v1::GetFrequencyResponseRequest& request,
                                                    double period_s);
/// The continuous model has the paper's estimator alone.
gate::Result<model::ResponseModel> ReadModel(v1::ResponseModel model, const model::LoopParameters& loop);

void Convert(const model::SweepRow& row, v1::SweepMWidthResponse& message);
void Convert(const model::Bode& bode, v1::GetFrequencyResponseResponse& message);
void Convert(const gate::MassAccuracy& accuracy, v1::Accuracy& message);

}  // namespace mwidth::rpc
