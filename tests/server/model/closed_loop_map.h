// Proves whether a simulated loop decays or grows, however slowly.
#pragma once

#include <algorithm>
#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/model/hybrid_simulation.h"
#include "server/model/loop_parameters.h"

namespace mwidth::model {

enum class Verdict : uint8_t { kDecays, kGrows, kOpen };

/// The map of the loop's whole state from one tick to the next, taken from the simulation by pushing each of
/// its states, and raised to powers of two in 50 digits: millions of years of a slow loop in a hundred
/// products.
class ClosedLoopMap {
 public:
  ClosedLoopMap(const LoopParameters& loop, double mass);

  /// Decay is proven by a power of norm below 1, growth by one whose trace, the sum of the eigenvalues'
  /// powers, exceeds their number. `ticks` becomes the power that proved it.
  Verdict Prove(uint64_t& ticks) const;

 private:
  using Real = boost::multiprecision::cpp_bin_float_50;
  using Matrix = std::vector<std::vector<Real>>;
  enum State : std::size_t { kX, kV, kLastX, kLastRate, kEstimate, kForces };
  static constexpr std::size_t kPastForces = 4;
  static constexpr std::size_t kStates = kForces + kPastForces;

  static Matrix Squared(const Matrix& a);

  Matrix map_ = Matrix(kStates, std::vector<Real>(kStates));
};

inline ClosedLoopMap::ClosedLoopMap(const LoopParameters& loop, double mass) {
  HybridSimulation simulation(loop);
  // The position's column from a displaced hand: its small change would drown in a position of 1.
  simulation.Reset(0, 0, -1);
  simulation.Advance(-1);
  map_[kX][kX] = 1 + Real(simulation.position());
  map_[kV][kX] = simulation.velocity();
  simulation.Reset(0, 1, 0);
  simulation.Advance(0);
  map_[kX][kV] = simulation.position();
  map_[kV][kV] = simulation.velocity();

  // What a force of this tick and of past ticks adds in one tick, from one pulse that travels through the
  // delay.
  std::array<std::array<Real, 2>, kPastForces + 1> pulse;
  simulation.Reset(0, 0, 0);
  simulation.Command(1);
  for (auto& [x, v] : pulse) {
    const Real x_before = simulation.position();
    const Real v_before = simulation.velocity();
    simulation.Advance(0);
    simulation.Command(0);
    x = simulation.position() - map_[kX][kX] * x_before - map_[kX][kV] * v_before;
    v = simulation.velocity() - map_[kV][kX] * x_before - map_[kV][kV] * v_before;
  }

  // Eqs. 3 and 4: rate = (x - last x)/T, estimate = a last estimate + (1 - a)(rate - last rate)/T; eq. 5: M
  // estimate.
  const Real period_s = loop.period_s;
  const Real pole = exp(-2 * boost::math::constants::pi<Real>() * loop.cutoff_hz * period_s);
  map_[kLastX][kX] = 1;
  map_[kLastRate][kX] = 1 / period_s;
  map_[kLastRate][kLastX] = -1 / period_s;
  map_[kEstimate][kX] = (1 - pole) / (period_s * period_s);
  map_[kEstimate][kLastX] = -map_[kEstimate][kX];
  map_[kEstimate][kLastRate] = -(1 - pole) / period_s;
  map_[kEstimate][kEstimate] = pole;
  for (std::size_t i = 0; i < kStates; ++i) {
    const Real force = mass * map_[kEstimate][i];
    map_[kX][i] += pulse[0][0] * force;
    map_[kV][i] += pulse[0][1] * force;
    map_[kForces][i] = force;
  }
  for (std::size_t i = 0; i < kPastForces; ++i) {
    map_[kX][kForces + i] += pulse[i + 1][0];
    map_[kV][kForces + i] += pulse[i + 1][1];
    if (i > 0) {
      map_[kForces + i][kForces + i - 1] = 1;
    }
  }
}

inline ClosedLoopMap::Matrix ClosedLoopMap::Squared(const Matrix& a) {
  Matrix square(kStates, std::vector<Real>(kStates));
  for (std::size_t i = 0; i < kStates; ++i) {
    for (std::size_t k = 0; k < kStates; ++k) {
      for (std::size_t j = 0; j < kStates && a[i][k] != 0; ++j) {
        square[i][j] += a[i][k] * a[k][j];
      }
    }
  }
  return square;
}

inline Verdict ClosedLoopMap::Prove(uint64_t& ticks) const {
  constexpr int kMaxSquarings = 60;
  Matrix power = map_;
  ticks = 1;
  for (int i = 0; i < kMaxSquarings; ++i) {
    power = Squared(power);
    ticks *= 2;
    Real norm = 0;
    Real trace = 0;
    for (std::size_t row = 0; row < kStates; ++row) {
      Real sum = 0;
      for (const Real& entry : power[row]) {
        sum += abs(entry);
      }
      norm = std::max(norm, sum);
      trace += power[row][row];
    }
    if (norm < 1) {
      return Verdict::kDecays;
    }
    if (abs(trace) > kStates) {
      return Verdict::kGrows;
    }
  }
  return Verdict::kOpen;
}

}  // namespace mwidth::model
