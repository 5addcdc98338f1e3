// What a streaming method sends, without how gRPC sends it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <grpcpp/completion_queue.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/async_stream.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

namespace mwidth::rpc {

/// The messages of one call. On the thread of StreamThread, which made it and destroys it.
class StreamSource {
 public:
  StreamSource() = default;
  StreamSource(const StreamSource&) = delete;
  StreamSource& operator=(const StreamSource&) = delete;
  virtual ~StreamSource() = default;

  /// Replaces `message` by the next one. False where there is none now; if none will follow either, `end` is
  /// then what the call ends with.
  virtual bool Pull(grpc::ByteBuffer& message, std::optional<grpc::Status>& end) = 0;
};

using StreamWriter = grpc::ServerAsyncWriter<grpc::ByteBuffer>;

/// One method of a service whose messages are raw bytes: an encoding can then be shared between calls.
struct StreamMethod {
  /// For the log.
  const char* name;
  /// Asks gRPC for the next call, whose coming `tag` tells.
  std::function<void(grpc::ServerContext& context, grpc::ByteBuffer& request, StreamWriter& writer,
                     grpc::ServerCompletionQueue& queue, void* tag)>
      request_call;
  /// The source of a call, or nullptr and why not. `wake` has the thread pull again, soon; it may be called
  /// by any thread, early or late, until the source is destroyed.
  std::function<std::unique_ptr<StreamSource>(grpc::ByteBuffer& request, std::function<void()> wake,
                                              grpc::Status& refusal)>
      open;
};

/// The method of `service`, which outlives it, whose calls `request_call` asks for, as gRPC generated it;
/// `open` gets the request parsed. Bytes that are no `Request` are refused as gRPC refuses those of its own
/// methods.
template <typename Request, typename Service, typename RequestCall, typename Open>
StreamMethod MethodOf(const char* name, Service& service, RequestCall request_call, Open open) {
  return {.name = name,
          .request_call =
              [&service, request_call](auto& context, auto& request, auto& writer, auto& queue, void* tag) {
                (service.*request_call)(&context, &request, &writer, &queue, &queue, tag);
              },
          .open = [open = std::move(open)](grpc::ByteBuffer& bytes, std::function<void()> wake,
                                           grpc::Status& refusal) -> std::unique_ptr<StreamSource> {
            Request request;
            refusal = grpc::SerializationTraits<Request>::Deserialize(&bytes, &request);
            return refusal.ok() ? open(request, std::move(wake), refusal) : nullptr;
          }};
}

/// A message as bytes.
template <typename Message>
grpc::ByteBuffer BytesOf(const Message& message) {
  const grpc::Slice slice(message.SerializeAsString());
  return {&slice, 1};
}

}  // namespace mwidth::rpc
