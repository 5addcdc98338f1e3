#include "client/cli/session/path.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace mwidth::cli::session {

std::string Pixels(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

void Path::To(double x, double y) {
  if (!drawing_) {
    text_ += "M" + Pixels(x) + " " + Pixels(y);
    kept_ = {x, y};
    drawing_ = true;
    return;
  }
  if (skipped_.size() >= kMostSkipped || !OnTheWayTo({x, y})) {
    Keep();
  }
  skipped_.push_back({x, y});
}

void Path::Lift() {
  Keep();
  drawing_ = false;
}

const std::string& Path::text() {
  Keep();
  return text_;
}

bool Path::OnTheWayTo(const Point& end) const {
  const double dx = end.x - kept_.x;
  const double dy = end.y - kept_.y;
  const double length = dx * dx + dy * dy;
  return std::all_of(skipped_.begin(), skipped_.end(), [&](const Point& point) {
    // Between the ends, and near the line.
    const double along = (point.x - kept_.x) * dx + (point.y - kept_.y) * dy;
    const double across = (point.x - kept_.x) * dy - (point.y - kept_.y) * dx;
    return along >= 0 && along <= length && across * across <= kTolerance * kTolerance * length;
  });
}

void Path::Keep() {
  if (!skipped_.empty()) {
    kept_ = skipped_.back();
    text_ += "L" + Pixels(kept_.x) + " " + Pixels(kept_.y);
    skipped_.clear();
  }
}

}  // namespace mwidth::cli::session
