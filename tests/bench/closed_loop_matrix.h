// The closed loop as a matrix, and its M-width by eigenvalues: what the closed form is raced against.
//
//   states, time in ticks: x, v T, s_1, s_2, y(k-1), y(k-2), ...       y = T^2 a_hat, F_a = M y / T^2
//   estimator (eqs. 3, 4)  y = (1-a) x + s_1,  s_1(k+1) = s_2 - 2 (1-a) x + a y,  s_2(k+1) = (1-a) x
//   device and hand        by the responses of plant_response.h; past y as far as the delay reaches
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "server/model/loop_parameters.h"
#include "server/model/plant_response.h"

namespace mwidth::bench {

/// Order of the loop: 4, and one for each tick of delay, whole or begun.
inline int LoopOrder(const model::LoopParameters& loop) {
  return 4 + static_cast<int>(std::ceil(loop.delay_s / loop.period_s));
}

/// A loop of order N, opened: closed by Closed(M) for any virtual mass M.
template <int N>
class LoopMatrix {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Precondition: LoopOrder(loop) == N.
  explicit LoopMatrix(const model::LoopParameters& loop);

  Matrix Closed(double mass) const {
    Matrix closed = open_;
    closed.template topRows<2>() += mass * force_;
    return closed;
  }

 private:
  Matrix open_ = Matrix::Zero();
  /// What a virtual mass of 1 adds to x and v T.
  Eigen::Matrix<double, 2, N> force_;
};

template <int N>
LoopMatrix<N>::LoopMatrix(const model::LoopParameters& loop) {
  const double period = loop.period_s;
  const double mass = loop.device_mass + loop.hand_mass;
  const double damping_rate = (loop.device_damping + loop.hand_damping) / mass;
  const double stiffness_rate = loop.hand_stiffness / mass;
  const double fraction = std::ceil(loop.delay_s / period) - loop.delay_s / period;
  const model::PlantResponse whole = model::RespondAfter(period, damping_rate, stiffness_rate);
  // Without delay the newest force acts all along; otherwise the begun tick's, for the share that is left.
  const double newer_s = N == 4 ? period : fraction * period;
  const model::PlantResponse newer = model::RespondAfter(newer_s, damping_rate, stiffness_rate);
  const double a = std::exp(-2 * std::numbers::pi * loop.cutoff_hz * period);

  open_(0, 0) = 1 - stiffness_rate * whole.step;
  open_(0, 1) = whole.impulse / period;
  open_(1, 0) = -stiffness_rate * whole.impulse * period;
  open_(1, 1) = 1 - whole.velocity_loss;
  Vector estimate = Vector::Zero();
  estimate(0) = 1 - a;
  estimate(2) = 1;
  open_.row(2) = a * estimate.transpose();
  open_(2, 0) -= 2 * (1 - a);
  open_(2, 3) = 1;
  open_(3, 0) = 1 - a;
  if constexpr (N > 4) {
    open_.row(4) = estimate.transpose();
    for (int i = 5; i < N; ++i) {
      open_(i, i - 1) = 1;
    }
  }

  const double scale = -1 / (mass * period * period);
  const Eigen::Vector2d by_newer = scale * Eigen::Vector2d(newer.step, newer.impulse * period);
  const Eigen::Vector2d by_both = scale * Eigen::Vector2d(whole.step, whole.impulse * period);
  // y(k - n) as a row: the estimate now, or a state. n = N - 4 reaches furthest back.
  const auto past = [&](int n) -> Vector { return n == 0 ? estimate : Vector(Vector::Unit(3 + n)); };
  force_ = (by_both - by_newer) * past(N - 4).transpose();
  force_ += by_newer * past(N == 4 ? 0 : N - 5).transpose();
}

/// One nonsymmetric eigenvalue solve, without eigenvectors.
template <int N>
double SpectralRadius(const Eigen::Matrix<double, N, N>& matrix) {
  const Eigen::EigenSolver<Eigen::Matrix<double, N, N>> solver(matrix, false);
  return solver.eigenvalues().cwiseAbs().maxCoeff();
}

/// The edge on the side of `step`, by doubling it until the loop is unstable, then halving the bracket to a
/// relative width of 1e-13, the accuracy that is asked of the closed form.
template <int N>
double EdgeByBisection(const LoopMatrix<N>& loop, double step) {
  const auto stable = [&](double mass) { return SpectralRadius<N>(loop.Closed(mass)) < 1; };
  double inside = 0;
  double outside = step;
  while (stable(outside)) {
    inside = outside;
    outside *= 2;
  }
  while (std::abs(outside - inside) > 1e-13 * std::abs(outside)) {
    const double middle = inside + (outside - inside) / 2;
    (stable(middle) ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace mwidth::bench
