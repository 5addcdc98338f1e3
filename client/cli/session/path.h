// Curves as the paths of SVG, in no more points than anybody sees.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/cli/session/svg.h"

namespace mwidth::cli::session {

/// To a tenth of a pixel: finer than any screen.
std::string Pixels(double value);

/// Collects points in pixels, and leaves out those that lie within a tenth of a pixel of the straight line
/// between their neighbours.
class Path {
 public:
  void To(double x, double y);
  /// The next point begins a new piece.
  void Lift();
  /// What belongs into the attribute d.
  const std::string& text();

 private:
  // Bounds the time that a straight line takes.
  static constexpr std::size_t kMostSkipped = 100;
  static constexpr double kTolerance = 0.1;

  bool OnTheWayTo(const Point& end) const;
  void Keep();

  std::string text_;
  Point kept_;
  std::vector<Point> skipped_;
  bool drawing_ = false;
};

}  // namespace mwidth::cli::session
