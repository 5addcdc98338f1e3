// How batches of samples look on the wire.
#pragma once

#include <string>

#include <grpcpp/support/byte_buffer.h>

#include "mwidth/v1/telemetry.pb.h"
#include "server/record/batcher.h"
#include "server/record/subscriber_queue.h"

namespace mwidth::rpc {

/// Fills an empty message with the samples of `batch` as columns. Any thread.
void Convert(const std::string& axis, const record::Batch& batch, v1::SampleBatch& message);

/// What makes serialized StreamSamplesResponses of an axis's batches. Bytes, not messages, so that one
/// encoding can be written to every stream that sends the same batch. Any thread.
record::Encode SampleEncoding(const std::string& axis);

/// The message that says what `delivery` says, around the bytes of its batches, which are not copied.
///
/// Concatenated messages are one message to a protobuf parser, in which repeated fields are concatenated and
/// of other fields the last one stands. So several batches are sent as one, and what a single subscriber lost
/// is told to it, by a few bytes behind them that repeat those fields. Precondition: `delivery` has batches.
grpc::ByteBuffer Assemble(const record::Delivery& delivery);

}  // namespace mwidth::rpc
