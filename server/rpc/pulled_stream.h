// An open streaming call whose messages are pulled from a source that says when there are some.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>

namespace mwidth::rpc {

/// Writes message after message to one client, and deletes itself when the call is over. No thread of its
/// own: it moves when the source calls Advance and when gRPC has taken the message before, and whichever
/// comes first sends what is there. One write is under way at a time, so a client that does not read stops
/// its own stream.
///
/// A subclass subscribes, calls Advance, and unsubscribes in its destructor.
template <typename Message>
class PulledStream : public grpc::ServerWriteReactor<Message> {
 public:
  // Called by gRPC, from any of its threads.
  void OnWriteDone(bool ok) final {
    {
      const std::lock_guard lock(mutex_);
      phase_ = Phase::kWaiting;
      if (!ok && !verdict_) {
        verdict_ = grpc::Status::CANCELLED;
      }
    }
    Advance();
  }
  void OnCancel() final { End(grpc::Status::CANCELLED); }
  void OnDone() final {
    delete this;  // NOLINT(cppcoreguidelines-owning-memory): gRPC's reactors own themselves until here
  }

 protected:
  ~PulledStream() override = default;

  /// Replaces `message` by the next one; false when there is none now, or the status to end with when there
  /// will be none. One thread at a time.
  virtual bool Pull(Message& message, std::optional<grpc::Status>& end) = 0;

  /// Sends the next message, or finishes the call, if there is reason to and nothing is being written. Any
  /// thread.
  void Advance() {
    std::optional<grpc::Status> last;
    {
      const std::lock_guard lock(mutex_);
      if (phase_ != Phase::kWaiting) {
        return;
      }
      if (!verdict_ && !Pull(message_, verdict_) && !verdict_) {
        return;
      }
      phase_ = verdict_ ? Phase::kFinished : Phase::kWriting;
      last = verdict_;
    }
    // Without the lock, because gRPC may call back at once. Nothing of this object is touched after Finish or
    // StartWrite: OnDone may have deleted it.
    if (last) {
      this->Finish(*std::move(last));
    } else {
      this->StartWrite(&message_);
    }
  }

  /// Finishes as soon as nothing is being written: Finish must not overlap a write.
  void End(grpc::Status status) {
    {
      const std::lock_guard lock(mutex_);
      if (!verdict_) {
        verdict_ = std::move(status);
      }
    }
    Advance();
  }

  /// Held while Pull runs: what a notification finds half made waits for it.
  std::mutex& mutex() { return mutex_; }

 private:
  enum class Phase : uint8_t { kWaiting, kWriting, kFinished };

  std::mutex mutex_;
  Phase phase_ = Phase::kWaiting;
  std::optional<grpc::Status> verdict_;
  // Owned by whoever moved the phase to kWriting, until OnWriteDone.
  Message message_;
};

/// A call that was refused: finishes at once.
template <typename Message>
class RefusedStream final : public grpc::ServerWriteReactor<Message> {
 public:
  explicit RefusedStream(grpc::Status status) { this->Finish(std::move(status)); }
  void OnDone() override { delete this; }  // NOLINT(cppcoreguidelines-owning-memory): reactors own themselves
};

}  // namespace mwidth::rpc
