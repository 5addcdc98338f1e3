// Derivatives of sampled positions without lag: what a recorded motion really was, as far as its encoder
// told.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace mwidth::cli::session {

/// Savitzky-Golay: at each sample a polynomial of fifth order is fitted to the window of 61 ms around it, at
/// the ends of the row to the first and the last whole window. Symmetric, hence of zero phase inside: a
/// derivative with a lag would mix damping into the mass. The same as scipy.signal.savgol_filter, and as the
/// Python package's mwidth.reaches, whose figures this must give. Any thread.
class Smoothing {
 public:
  /// `period_s` above 0, at most 0.01.
  explicit Smoothing(double period_s);

  /// In samples; odd.
  std::size_t window() const noexcept { return 2 * half_ + 1; }

  /// `x` (one sample a period), or its first or second derivative per second. Throws std::invalid_argument
  /// where `x` has fewer samples than the window.
  std::vector<double> Apply(const std::vector<double>& x, int derivative) const;

 private:
  static constexpr int kOrder = 5;
  using Polynomial = std::array<double, kOrder + 1>;

  // What the samples of a window weigh in the derivative at `offset` samples from its middle.
  std::vector<double> Weights(double offset, int derivative) const;

  double period_s_;
  std::size_t half_;
  // Orthonormal over the window's samples at u = -1 .. 1.
  std::array<Polynomial, kOrder + 1> basis_{};
};

}  // namespace mwidth::cli::session
