// Answers as a drive that is ill sends them: late, or byte by byte.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "device/emulator/faults.h"

namespace mwidth::device::emulator {

/// Writes one answer after the other to a stream of Boost.Asio. Lives on the stream's only thread.
template <typename Stream>
class AnswerWriter {
 public:
  /// Both outlive it.
  AnswerWriter(Stream& stream, const LinkFaults& faults)
      : stream_(stream), faults_(faults), timer_(stream.get_executor()) {}

  /// Writes `answer` and calls `done`, unless the stream fails. What `done` holds lives as long. Not before
  /// the last one's `done`.
  void Write(std::vector<uint8_t> answer, std::function<void()> done) {
    answer_ = std::move(answer);
    Later(std::chrono::nanoseconds(faults_.delay_ns), 0, std::move(done));
  }

 private:
  // Writes the answer from `sent` on after a pause.
  void Later(std::chrono::nanoseconds pause, std::size_t sent, std::function<void()> done) {
    if (pause.count() == 0) {
      Write(sent, std::move(done));
      return;
    }
    timer_.expires_after(pause);
    timer_.async_wait([this, sent, done = std::move(done)](auto error) {
      if (!error) {
        Write(sent, done);
      }
    });
  }

  void Write(std::size_t sent, std::function<void()> done) {
    const std::chrono::nanoseconds dribble(faults_.dribble_ns);
    const auto left = std::span<const uint8_t>(answer_).subspan(sent);
    const std::size_t size = dribble.count() > 0 ? 1 : left.size();
    boost::asio::async_write(
        stream_, boost::asio::buffer(left.data(), size),
        [this, sent = sent + size, dribble, done = std::move(done)](auto error, std::size_t) {
          if (error) {
            return;
          }
          if (sent < answer_.size()) {
            Later(dribble, sent, done);
          } else {
            done();
          }
        });
  }

  Stream& stream_;
  const LinkFaults& faults_;
  boost::asio::steady_timer timer_;
  std::vector<uint8_t> answer_;
};

}  // namespace mwidth::device::emulator
