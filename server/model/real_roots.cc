#include "server/model/real_roots.h"

#include <algorithm>
#include <cstddef>

namespace mwidth::model {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// A polynomial on [low, low + width] by its Bernstein coefficients there.
struct Piece {
  std::array<double, kMaxRootDegree + 1> coefficients;
  int degree;
  double low;
  double width;
};

struct SignChanges {
  int count = 0;
  bool first_rising = false;
  // Where the control polygon first crosses zero, as a fraction of the piece: the first guess for its root.
  double crossing = 0.5;
};

SignChanges CountSignChanges(const Piece& piece) noexcept {
  SignChanges changes;
  int last = -1;  // index of the last coefficient that is not zero
  for (int i = 0; i <= piece.degree; ++i) {
    const double value = piece.coefficients[static_cast<size_t>(i)];
    if (value == 0) {
      continue;
    }
    const double before = last < 0 ? value : piece.coefficients[static_cast<size_t>(last)];
    if ((value < 0) != (before < 0)) {
      if (changes.count == 0) {
        changes.first_rising = before < 0;
        changes.crossing = (last + (i - last) * before / (before - value)) / piece.degree;
      }
      ++changes.count;
    }
    last = i;
  }
  return changes;
}

// De Casteljau: on return `piece` is its left half; the right half is the result.
Piece SplitOffRight(Piece& piece) noexcept {
  Piece right = piece;
  const auto n = static_cast<size_t>(piece.degree);
  for (size_t level = 1; level <= n; ++level) {
    for (size_t i = 0; i + level <= n; ++i) {
      right.coefficients[i] = 0.5 * (right.coefficients[i] + right.coefficients[i + 1]);
    }
    piece.coefficients[level] = right.coefficients[0];
  }
  piece.width *= 0.5;
  right.width = piece.width;
  right.low = piece.low + piece.width;
  return right;
}

void Add(RootBrackets& found, const RootBracket& bracket) noexcept {
  if (found.count < kMaxRootDegree) {
    found.brackets[static_cast<size_t>(found.count++)] = bracket;
  }
}

void Isolate(Piece& piece, RootBrackets& found) noexcept {
  const SignChanges changes = CountSignChanges(piece);
  const double high = piece.low + piece.width;
  if (changes.count == 0) {
    return;
  }
  if (changes.count == 1) {
    Add(found, {.low = piece.low,
                .high = high,
                .rising = changes.first_rising,
                .guess = piece.low + changes.crossing * piece.width});
    return;
  }
  if (piece.width <= 4 * kEpsilon * piece.low || piece.width < 1e-60) {
    const double middle = piece.low + piece.width / 2;
    Add(found, {.low = middle, .high = middle, .rising = false, .guess = middle});
    return;
  }
  Piece right = SplitOffRight(piece);
  const double middle = right.low;
  Isolate(piece, found);
  if (right.coefficients[0] == 0) {
    Add(found, {.low = middle, .high = middle, .rising = false, .guess = middle});
  }
  Isolate(right, found);
}

}  // namespace

RootBrackets IsolateRoots(std::span<const double> bernstein) noexcept {
  Piece piece{.coefficients = {}, .degree = static_cast<int>(bernstein.size()) - 1, .low = 0, .width = 1};
  std::copy(bernstein.begin(), bernstein.end(), piece.coefficients.begin());
  RootBrackets found;
  Isolate(piece, found);
  return found;
}

}  // namespace mwidth::model
