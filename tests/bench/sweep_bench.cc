// Grids of M-widths, on one thread and on several.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>

#include "server/model/m_width.h"
#include "server/model/sweep_run.h"
#include "tests/bench/rendering_loops.h"

namespace mwidth::bench {
namespace {

using model::LoopParameters;
using model::RunSweep;
using model::Sweep;
using model::SweepParameter;
using model::SweepRow;

/// The paper's loop with hands from slack to stiff, `side` values of each parameter.
Sweep HandMap(uint32_t side) {
  return {.loop = PaperLoop(),
          .x = {.parameter = SweepParameter::kHandDamping,
                .min = 0.5,
                .max = 50,
                .count = side,
                .logarithmic = true},
          .y = model::SweepRange{.parameter = SweepParameter::kHandStiffness,
                                 .min = 70,
                                 .max = 7000,
                                 .count = side,
                                 .logarithmic = true}};
}

/// Rows, and of the last one the point in the middle, must be those of single loops.
bool IsOf(const Sweep& sweep, const SweepRow& row) {
  LoopParameters loop = sweep.loop;
  loop.hand_stiffness = row.y;
  loop.hand_damping = row.x[row.x.size() / 2];
  return model::ComputeMWidth(loop).upper.mass == row.upper[row.x.size() / 2];
}

void RunMap(benchmark::State& state, uint32_t side, unsigned threads) {
  const Sweep sweep = HandMap(side);
  double sum = 0;
  bool right = true;
  for (auto _ : state) {  // NOLINT(clang-analyzer-deadcode.DeadStores): the loop is the measurement
    RunSweep(sweep, {.threads = threads, .prepare_thread = {}, .stop = {}}, [&](const SweepRow& row) {
      sum += row.upper[0];
      right = right && (row.row + 1 < row.row_count || IsOf(sweep, row));
      return true;
    });
    benchmark::DoNotOptimize(sum);
  }
  if (!right) {
    state.SkipWithError("the map is not that of single loops");
  }
  state.SetItemsProcessed(state.iterations() * side * side);
}

// All threads' CPU time, their start included.
void HandMap33(benchmark::State& state) { RunMap(state, 33, 1); }
BENCHMARK(HandMap33)->MeasureProcessCPUTime()->Unit(benchmark::kMicrosecond);

void HandMap1000(benchmark::State& state) { RunMap(state, 1000, static_cast<unsigned>(state.range(0))); }
BENCHMARK(HandMap1000)
    ->ArgName("sweep_threads")
    ->Arg(1)
    ->Arg(2)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mwidth::bench
