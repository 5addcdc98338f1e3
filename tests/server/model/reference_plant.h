// Device and hand under switching forces in 50 digits: what the exact step is held against.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstddef>
#include <vector>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

using Real = boost::multiprecision::cpp_bin_float_50;

// Position, velocity, force, hand position, hand velocity; the last three stay what they are.
inline constexpr std::size_t kStates = 5;
using Matrix = std::array<std::array<Real, kStates>, kStates>;
using Vector = std::array<Real, kStates>;

inline Matrix Times(const Matrix& a, const Matrix& b) {
  Matrix product{};
  for (std::size_t i = 0; i < kStates; ++i) {
    for (std::size_t j = 0; j < kStates; ++j) {
      for (std::size_t k = 0; k < kStates; ++k) {
        product[i][j] += a[i][k] * b[k][j];
      }
    }
  }
  return product;
}

/// Eqs. 1 and 2 as one homogeneous system, plus the straight line of the hand.
inline Matrix Generator(const LoopParameters& loop) {
  const Real mass = Real(loop.device_mass) + Real(loop.hand_mass);
  Matrix a{};
  a[0][1] = 1;
  a[1][0] = -loop.hand_stiffness / mass;
  a[1][1] = -(Real(loop.device_damping) + Real(loop.hand_damping)) / mass;
  a[1][2] = -1 / mass;
  a[1][3] = loop.hand_stiffness / mass;
  a[1][4] = loop.hand_damping / mass;
  a[3][4] = 1;
  return a;
}

inline constexpr int kSquarings = 60;

/// e^(a t) by 8 terms of Taylor's series at t/2^60 and 60 squarings: 18 of the 50 digits go to the squarings.
inline Matrix Exponential(Matrix a, const Real& time_s) {
  for (auto& row : a) {
    for (Real& entry : row) {
      entry *= ldexp(time_s, -kSquarings);
    }
  }
  Matrix sum{};
  Matrix term{};
  for (std::size_t i = 0; i < kStates; ++i) {
    sum[i][i] = term[i][i] = 1;
  }
  for (int n = 1; n <= 8; ++n) {
    term = Times(term, a);
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t j = 0; j < kStates; ++j) {
        term[i][j] /= n;
        sum[i][j] += term[i][j];
      }
    }
  }
  for (int i = 0; i < kSquarings; ++i) {
    sum = Times(sum, sum);
  }
  return sum;
}

/// Time in units of the period, forces kept with the time from which they act: no queue, no split in advance.
class ReferencePlant {
 public:
  explicit ReferencePlant(const LoopParameters& loop)
      : generator_(Generator(loop)), period_s_(loop.period_s), delay_(Real(loop.delay_s) / loop.period_s) {}

  void Command(double force) { switches_.push_back({tick_ + delay_, Real(force)}); }

  void Advance(double hand_next) {
    state_[4] = (Real(hand_next) - state_[3]) / period_s_;
    Real now = tick_;
    for (const auto& [time, force] : switches_) {
      if (time > now && time < tick_ + 1) {
        Flow(time - now);
        now = time;
      }
      if (time <= now) {
        state_[2] = force;
      }
    }
    Flow(tick_ + 1 - now);
    state_[3] = hand_next;
    tick_ += 1;
  }

  const Vector& state() const { return state_; }

 private:
  struct Switch {
    Real time;
    Real force;
  };

  void Flow(const Real& periods) {
    const Matrix flow = Exponential(generator_, periods * period_s_);
    Vector next{};
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t j = 0; j < kStates; ++j) {
        next[i] += flow[i][j] * state_[j];
      }
    }
    state_ = next;
  }

  Vector state_{};
  Matrix generator_;
  Real period_s_;
  Real delay_;
  Real tick_ = 0;
  std::vector<Switch> switches_;
};

}  // namespace mwidth::model
