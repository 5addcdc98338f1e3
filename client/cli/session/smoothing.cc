#include "client/cli/session/smoothing.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace mwidth::cli::session {
namespace {

constexpr double kWindowS = 0.061;

template <typename Polynomial>
double ValueAt(const Polynomial& coefficients, double u, int derivative) {
  double value = 0;
  for (auto power = static_cast<int>(coefficients.size()) - 1; power >= derivative; --power) {
    double factor = 1;
    for (int k = 0; k < derivative; ++k) {
      factor *= power - k;
    }
    value = value * u + factor * coefficients[static_cast<std::size_t>(power)];
  }
  return value;
}

// As Python rounds: half a sample goes to the even side.
std::size_t HalfWindow(double period_s) {
  return static_cast<std::size_t>(std::nearbyint(kWindowS / period_s / 2));
}

}  // namespace

Smoothing::Smoothing(double period_s) : period_s_(period_s), half_(HalfWindow(period_s)) {
  const auto inner = [this](const Polynomial& a, const Polynomial& b) {
    double sum = 0;
    for (std::size_t i = 0; i < window(); ++i) {
      const double u = static_cast<double>(i) / static_cast<double>(half_) - 1;
      sum += ValueAt(a, u, 0) * ValueAt(b, u, 0);
    }
    return sum;
  };
  for (std::size_t degree = 0; degree < basis_.size(); ++degree) {
    Polynomial next{};
    next[degree] = 1;
    // Twice: what rounding left of the lower ones after the first time is gone after the second.
    for (std::size_t k = 0; k < 2 * degree; ++k) {
      const Polynomial& lower = basis_[k % degree];
      const double share = inner(next, lower);
      for (std::size_t power = 0; power < next.size(); ++power) {
        next[power] -= share * lower[power];
      }
    }
    const double size = std::sqrt(inner(next, next));
    for (double& coefficient : next) {
      coefficient /= size;
    }
    basis_[degree] = next;
  }
}

std::vector<double> Smoothing::Weights(double offset, int derivative) const {
  const auto half = static_cast<double>(half_);
  const double scale = std::pow(half * period_s_, -derivative);
  std::vector<double> weights(window());
  for (const Polynomial& polynomial : basis_) {
    const double here = scale * ValueAt(polynomial, offset / half, derivative);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] += here * ValueAt(polynomial, static_cast<double>(i) / half - 1, 0);
    }
  }
  return weights;
}

std::vector<double> Smoothing::Apply(const std::vector<double>& x, int derivative) const {
  if (x.size() < window()) {
    throw std::invalid_argument(std::to_string(x.size()) + " samples are fewer than the filter's window of " +
                                std::to_string(window()));
  }
  const auto sum_from = [&x](const std::vector<double>& weights, std::size_t first) {
    double sum = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      sum += weights[i] * x[first + i];
    }
    return sum;
  };
  std::vector<double> smooth(x.size());
  const std::vector<double> middle = Weights(0, derivative);
  for (std::size_t first = 0; first + window() <= x.size(); ++first) {
    smooth[first + half_] = sum_from(middle, first);
  }
  for (std::size_t k = 0; k < half_; ++k) {
    const double offset = static_cast<double>(k) - static_cast<double>(half_);
    smooth[k] = sum_from(Weights(offset, derivative), 0);
    smooth[x.size() - 1 - k] = sum_from(Weights(-offset, derivative), x.size() - window());
  }
  return smooth;
}

}  // namespace mwidth::cli::session
