// What a StreamSamples request asks for.
#pragma once

#include "mwidth/v1/telemetry.pb.h"
#include "server/gate/refusal.h"
#include "server/record/batcher.h"

namespace mwidth::rpc {

/// How the stream is to be cut, or INVALID_ARGUMENT with what is wrong and what is allowed.
gate::Result<record::Cut> CutOf(const v1::StreamSamplesRequest& request);

}  // namespace mwidth::rpc
