// How a batch of samples looks on the wire.
#pragma once

#include <string>

#include <grpcpp/support/byte_buffer.h>

#include "server/record/batcher.h"

namespace mwidth::rpc {

/// A serialized StreamSamplesResponse with the samples of `batch` as columns. Bytes, not a message, so that
/// one encoding can be written to every stream that sends the same batch: copies of a ByteBuffer share their
/// memory. Precondition: `batch` has samples. Any thread.
grpc::ByteBuffer Encode(const std::string& axis, const record::Batch& batch);

}  // namespace mwidth::rpc
