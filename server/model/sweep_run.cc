#include "server/model/sweep_run.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "server/model/m_width.h"

namespace mwidth::model {
namespace {

// What a thread takes at once: long against the cost of taking it, short enough to stop soon and to share out
// a grid of a single row.
constexpr std::size_t kPiecePoints = 128;

class Run {
 public:
  Run(const Sweep& sweep, std::stop_token stop)
      : sweep_(sweep),
        row_count_(sweep.y ? sweep.y->count : 1),
        pieces_in_row_((sweep.x.count + kPiecePoints - 1) / kPiecePoints),
        stop_(std::move(stop)),
        x_(sweep.x.count),
        lower_(static_cast<std::size_t>(row_count_) * sweep.x.count),
        upper_(lower_.size()),
        pieces_left_(row_count_) {
    for (uint32_t i = 0; i < sweep.x.count; ++i) {
      x_[i] = ValueAt(sweep.x, i);
    }
    for (auto& left : pieces_left_) {
      left.store(pieces_in_row_, std::memory_order_relaxed);
    }
  }

  std::size_t piece_count() const { return row_count_ * pieces_in_row_; }

  // Takes pieces, in the order of the rows, until there are none or the sweep ends.
  void Work() {
    for (;;) {
      const std::size_t piece = next_piece_.fetch_add(1, std::memory_order_relaxed);
      if (piece >= piece_count() || ended_.load(std::memory_order_relaxed) || stop_.stop_requested()) {
        return;
      }
      const auto row = static_cast<uint32_t>(piece / pieces_in_row_);
      const std::size_t first = piece % pieces_in_row_ * kPiecePoints;
      Compute(row, first, std::min(first + kPiecePoints, x_.size()));
      if (pieces_left_[row].fetch_sub(1, std::memory_order_acq_rel) == 1) {
        // Under the mutex: the waiting thread either sees the row complete or hears of it.
        const std::lock_guard lock(mutex_);
        row_complete_.notify_one();
      }
    }
  }

  bool HandOver(const TakeRow& take) {
    for (uint32_t row = 0; row < row_count_; ++row) {
      std::unique_lock lock(mutex_);
      const bool complete = row_complete_.wait(
          lock, stop_, [&] { return pieces_left_[row].load(std::memory_order_acquire) == 0; });
      lock.unlock();
      if (!complete || stop_.stop_requested() || !take(Row(row))) {
        return false;
      }
    }
    return true;
  }

  void End() { ended_.store(true, std::memory_order_relaxed); }

 private:
  double Y(uint32_t row) const { return sweep_.y ? ValueAt(*sweep_.y, row) : 0; }

  void Compute(uint32_t row, std::size_t first, std::size_t end) {
    LoopParameters loop = sweep_.loop;
    if (sweep_.y) {
      SweptField(loop, sweep_.y->parameter) = Y(row);
    }
    double& x = SweptField(loop, sweep_.x.parameter);
    for (std::size_t i = first; i < end; ++i) {
      x = x_[i];
      const EdgeMasses edges = Validate(loop) ? EdgeMasses{} : ComputeEdgeMasses(loop);
      lower_[row * x_.size() + i] = edges.lower;
      upper_[row * x_.size() + i] = edges.upper;
    }
  }

  SweepRow Row(uint32_t row) const {
    const std::size_t first = row * x_.size();
    return {.row = row,
            .row_count = row_count_,
            .y = Y(row),
            .x = x_,
            .lower = std::span(lower_).subspan(first, x_.size()),
            .upper = std::span(upper_).subspan(first, x_.size())};
  }

  const Sweep& sweep_;
  const uint32_t row_count_;
  const std::size_t pieces_in_row_;
  const std::stop_token stop_;
  std::vector<double> x_;
  std::vector<double> lower_;
  std::vector<double> upper_;
  std::vector<std::atomic<std::size_t>> pieces_left_;
  std::atomic<std::size_t> next_piece_ = 0;
  std::atomic<bool> ended_ = false;
  std::mutex mutex_;
  std::condition_variable_any row_complete_;
};

// Ends and joins the threads, however the sweep ends.
class Workers {
 public:
  Workers(Run& run, unsigned count, const std::function<void()>& prepare) : run_(run) {
    try {
      for (unsigned i = 0; i < count; ++i) {
        threads_.emplace_back([&run, &prepare] {
          if (prepare) {
            prepare();
          }
          run.Work();
        });
      }
    } catch (...) {
      run_.End();  // the threads that did start are joined by their own destructors
      throw;
    }
  }
  ~Workers() { run_.End(); }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

 private:
  Run& run_;
  std::vector<std::jthread> threads_;
};

}  // namespace

bool RunSweep(const Sweep& sweep, const SweepOptions& options, const TakeRow& take) {
  Run run(sweep, options.stop);
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  const unsigned wanted = options.threads == 0 ? cores : std::min(options.threads, cores);
  const auto useful = static_cast<unsigned>(std::min<std::size_t>(wanted, run.piece_count()));
  const Workers workers(run, useful, options.prepare_thread);
  return run.HandOver(take);
}

}  // namespace mwidth::model
