// M-widths over a grid, on all cores.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>

#include "server/model/sweep.h"

namespace mwidth::model {

/// One row of the grid; the spans are valid during the call that hands it over.
struct SweepRow {
  uint32_t row = 0;
  uint32_t row_count = 0;
  /// 0 without `Sweep::y`.
  double y = 0;
  std::span<const double> x;
  /// Edges of the M-width of each loop, equal to those of ComputeMWidth; NaN where it is empty or the loop is
  /// out of the model's range.
  std::span<const double> lower;
  std::span<const double> upper;
};

struct SweepOptions {
  /// Threads that compute; 0 for as many as there are cores, which is also the most.
  unsigned threads = 0;
  /// Called once by each of them before its first point, for instance to lower its priority; may be empty;
  /// must not throw.
  std::function<void()> prepare_thread;
  /// Ends the sweep from outside.
  std::stop_token stop;
};

/// Takes one row; false ends the sweep.
using TakeRow = std::function<bool(const SweepRow&)>;

/// Computes the grid on threads of its own and hands row after row to `take`, in order and from the calling
/// thread, as soon as each is complete. Returns true when all rows were taken, false when `take` or
/// `options.stop` ended it; then, and where `take` throws, the threads finish the piece of some 100 points
/// that they are at. Takes 16 bytes a point: rows that are not taken yet do not hold the threads up.
///
/// Precondition: Validate(sweep) is empty. Throws std::system_error where no thread can be had. Blocks.
bool RunSweep(const Sweep& sweep, const SweepOptions& options, const TakeRow& take);

}  // namespace mwidth::model
