// Both edges of an M-width from physical parameters, discretization included, against eigenvalues.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "server/model/m_width.h"
#include "tests/bench/closed_loop_matrix.h"
#include "tests/bench/rendering_loops.h"

namespace mwidth::bench {
namespace {

using model::ComputeEdgeMasses;
using model::ComputeMWidth;
using model::EdgeMasses;
using model::LoopParameters;
using model::MWidth;

/// Calls `function` with the delayed paper loop's matrix, whose order is known only now.
template <typename Function>
void WithLoopMatrix(const LoopParameters& loop, const Function& function) {
  switch (LoopOrder(loop)) {
    case 4:
      return function(LoopMatrix<4>(loop));
    case 5:
      return function(LoopMatrix<5>(loop));
    case 6:
      return function(LoopMatrix<6>(loop));
    default:
      return function(LoopMatrix<7>(loop));
  }
}

LoopParameters LoopOf(const benchmark::State& state) {
  return PaperLoop(static_cast<double>(state.range(0)) / 4);
}

void BothEdges(benchmark::State& state) {
  LoopParameters loop = LoopOf(state);
  EdgeMasses edges;
  for (auto _ : state) {
    benchmark::DoNotOptimize(loop);
    edges = ComputeEdgeMasses(loop);
    benchmark::DoNotOptimize(edges);
  }
  // For those who compare with tools outside of this process.
  state.counters["lower"] = edges.lower;
  state.counters["upper"] = edges.upper;
}
BENCHMARK(BothEdges)->ArgName("quarter_ticks")->Arg(0)->Arg(2)->Arg(4)->Arg(6)->Arg(8)->Arg(10)->Arg(12);

void EdgesAndFrequencies(benchmark::State& state) {
  LoopParameters loop = PaperLoop();
  for (auto _ : state) {
    benchmark::DoNotOptimize(loop);
    MWidth m_width = ComputeMWidth(loop);
    benchmark::DoNotOptimize(m_width);
  }
}
BENCHMARK(EdgesAndFrequencies);

void EigenSolve(benchmark::State& state) {
  const LoopParameters loop = LoopOf(state);
  const double edge = ComputeMWidth(loop).upper.mass;
  WithLoopMatrix(loop, [&]<int N>(const LoopMatrix<N>& matrix) {
    if (std::abs(SpectralRadius<N>(matrix.Closed(edge)) - 1) > 1e-9) {
      return state.SkipWithError("the matrix and the closed form are not of the same loop");
    }
    auto closed = matrix.Closed(0.5 * edge);
    for (auto _ : state) {
      benchmark::DoNotOptimize(closed);
      const Eigen::EigenSolver<typename LoopMatrix<N>::Matrix> solver(closed, false);
      benchmark::DoNotOptimize(solver.eigenvalues().data());
    }
  });
}
BENCHMARK(EigenSolve)->ArgName("quarter_ticks")->Arg(0)->Arg(2)->Arg(4)->Arg(6)->Arg(8)->Arg(10)->Arg(12);

void BothEdgesByBisection(benchmark::State& state) {
  LoopParameters loop = PaperLoop();
  double lower = 0;
  double upper = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(loop);
    const LoopMatrix<4> matrix(loop);
    lower = EdgeByBisection(matrix, -loop.device_mass);
    upper = EdgeByBisection(matrix, loop.device_mass);
    benchmark::DoNotOptimize(lower);
    benchmark::DoNotOptimize(upper);
  }
  const MWidth exact = ComputeMWidth(loop);
  if (std::abs(lower / exact.lower.mass - 1) > 1e-9 || std::abs(upper / exact.upper.mass - 1) > 1e-9) {
    state.SkipWithError("bisection and the closed form disagree");
  }
}
BENCHMARK(BothEdgesByBisection)->Unit(benchmark::kMicrosecond);

// A new loop each time: no branch is learnt by heart.
constexpr int kBoxLoops = 1024;

void BothEdgesOverTheBox(benchmark::State& state) {
  const std::vector<LoopParameters> loops = BoxLoops(kBoxLoops);
  std::size_t i = 0;
  for (auto _ : state) {
    EdgeMasses edges = ComputeEdgeMasses(loops[i++ % kBoxLoops]);
    benchmark::DoNotOptimize(edges);
  }
}
BENCHMARK(BothEdgesOverTheBox);

void EigenSolveOverTheBox(benchmark::State& state) {
  std::vector<LoopMatrix<4>::Matrix> matrices;
  for (const LoopParameters& loop : BoxLoops(kBoxLoops)) {
    matrices.push_back(LoopMatrix<4>(loop).Closed(0.5 * ComputeMWidth(loop).upper.mass));
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const Eigen::EigenSolver<LoopMatrix<4>::Matrix> solver(matrices[i++ % kBoxLoops], false);
    benchmark::DoNotOptimize(solver.eigenvalues().data());
  }
}
BENCHMARK(EigenSolveOverTheBox);

}  // namespace
}  // namespace mwidth::bench
