#include "client/cli/session/svg.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "client/cli/session/html.h"
#include "client/cli/session/path.h"

namespace mwidth::cli::session {
namespace {

constexpr double kLeft = 70;
constexpr double kRight = 14;
constexpr double kTop = 20;
constexpr double kBottom = 38;
constexpr double kBetweenPanels = 12;

// Linear, from values to pixels.
struct Scale {
  double min = 0;
  double max = 1;
  double from = 0;
  double to = 1;
  double At(double value) const { return from + (value - min) / (max - min) * (to - from); }
};

// What a panel shows, with some air around.
std::pair<double, double> RangeOf(const Panel& panel) {
  double min = HUGE_VAL;
  double max = -HUGE_VAL;
  const auto include = [&min, &max](double y) {
    if (std::isfinite(y)) {
      min = std::min(min, y);
      max = std::max(max, y);
    }
  };
  for (const Curve& curve : panel.curves) {
    for (const Point& point : curve.points) {
      include(point.y);
    }
  }
  for (const Level& level : panel.levels) {
    include(level.y);
  }
  if (min > max) {
    min = max = 0;
  }
  const double middle = (min + max) / 2;
  double half = std::max((max - min) / 2, panel.least_span / 2) * 1.08;
  if (half <= std::abs(middle) * 1e-12) {
    half = middle == 0 ? 1 : std::abs(middle) * 0.1;
  }
  return {middle - half, middle + half};
}

std::string TextAt(double x, double y, const std::string& css_class, const std::string& text,
                   const std::string& more = "") {
  return "<text class=\"" + css_class + "\" x=\"" + Pixels(x) + "\" y=\"" + Pixels(y) + "\"" + more + ">" +
         Escape(text) + "</text>";
}

std::string Line(const std::string& css_class, double x1, double y1, double x2, double y2) {
  return "<line class=\"" + css_class + "\" x1=\"" + Pixels(x1) + "\" y1=\"" + Pixels(y1) + "\" x2=\"" +
         Pixels(x2) + "\" y2=\"" + Pixels(y2) + "\"/>";
}

// As many digits as tell neighbouring ticks apart.
std::string TickText(double value, double step) {
  return Fixed(value, std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9))));
}

std::string PathOf(const Curve& curve, const Scale& x, const Scale& y) {
  Path path;
  for (const Point& point : curve.points) {
    if (std::isfinite(point.y)) {
      path.To(x.At(point.x), y.At(point.y));
    } else {
      path.Lift();
    }
  }
  return "<path class=\"" + Escape(curve.css_class) + "\" d=\"" + path.text() + "\"/>";
}

std::string PanelAt(const Panel& panel, const Scale& x, double top) {
  const auto [min, max] = RangeOf(panel);
  const Scale y{.min = min, .max = max, .from = top + panel.height, .to = top};
  std::string svg;
  const std::vector<double> ticks = Ticks(min, max, static_cast<int>(panel.height / 30));
  for (const double tick : ticks) {
    svg += Line("grid", x.from, y.At(tick), x.to, y.At(tick));
    svg += TextAt(x.from - 6, y.At(tick) + 4, "tick end",
                  TickText(tick, ticks.size() > 1 ? ticks[1] - ticks[0] : 1));
  }
  for (const Level& level : panel.levels) {
    svg += Line(level.css_class, x.from, y.At(level.y), x.to, y.At(level.y));
    svg += TextAt(x.to - 4, y.At(level.y) - 4, "note end", level.label);
  }
  for (const Curve& curve : panel.curves) {
    svg += PathOf(curve, x, y);
  }
  const std::string at = Pixels(top + panel.height / 2);
  svg += TextAt(14, top + panel.height / 2, "axis middle", panel.y_label,
                " transform=\"rotate(-90 14 " + at + ")\"");
  return svg + R"(<rect class="frame" x=")" + Pixels(x.from) + "\" y=\"" + Pixels(top) + "\" width=\"" +
         Pixels(x.to - x.from) + "\" height=\"" + Pixels(panel.height) + "\"/>\n";
}

std::string Bands(const Picture& picture, const Scale& x, double bottom) {
  std::string svg;
  for (const Band& band : picture.bands) {
    const double from = x.At(std::clamp(band.from, x.min, x.max));
    const double to = x.At(std::clamp(band.to, x.min, x.max));
    svg += "<rect class=\"" + band.css_class + "\" x=\"" + Pixels(from) + "\" y=\"" + Pixels(kTop) +
           "\" width=\"" + Pixels(std::max(to - from, 0.5)) + "\" height=\"" + Pixels(bottom - kTop) +
           "\"><title>" + Escape(band.label) + "</title></rect>";
  }
  return svg;
}

std::string Marks(const Picture& picture, const Scale& x, double bottom) {
  std::string svg;
  double free_from = 0;
  for (const Mark& mark : picture.marks) {
    if (mark.x < x.min || mark.x > x.max) {
      continue;
    }
    const double at = x.At(mark.x);
    svg += Line(mark.css_class, at, kTop, at, bottom);
    // A label that would lie over the one before is left out; the line stays.
    const double half_width = 3.2 * static_cast<double>(mark.label.size());
    if (!mark.label.empty() && at - half_width > free_from) {
      svg += TextAt(at, kTop - 5, "note middle", mark.label);
      free_from = at + half_width;
    }
  }
  return svg;
}

}  // namespace

std::vector<double> Ticks(double min, double max, int count) {
  const double rough = (max - min) / std::max(1, count);
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1 - 1e-9)) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> ticks;
  const auto first = static_cast<int64_t>(std::ceil(min / step - 1e-9));
  const auto last = static_cast<int64_t>(std::floor(max / step + 1e-9));
  for (int64_t k = first; k <= last; ++k) {
    ticks.push_back(static_cast<double>(k) * step);
  }
  return ticks;
}

std::vector<Point> Thin(const std::vector<Point>& points, std::size_t most) {
  if (points.size() <= 2 * most) {
    return points;
  }
  std::vector<Point> thin;
  thin.reserve(2 * most);
  for (std::size_t bucket = 0; bucket < most; ++bucket) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(bucket * points.size() / most);
    const auto end = points.begin() + static_cast<std::ptrdiff_t>((bucket + 1) * points.size() / most);
    const auto [low, high] =
        std::minmax_element(begin, end, [](const Point& a, const Point& b) { return a.y < b.y; });
    thin.push_back(low < high ? *low : *high);
    thin.push_back(low < high ? *high : *low);
  }
  return thin;
}

std::string Svg(const Picture& picture) {
  double bottom = kTop;
  for (const Panel& panel : picture.panels) {
    bottom += panel.height + kBetweenPanels;
  }
  bottom -= kBetweenPanels;
  const double height = bottom + kBottom;
  const Scale x{.min = picture.x_min, .max = picture.x_max, .from = kLeft, .to = picture.width - kRight};
  std::string svg = R"(<svg role="img" viewBox="0 0 )" + Pixels(picture.width) + " " + Pixels(height) +
                    "\" width=\"" + Pixels(picture.width) + "\" height=\"" + Pixels(height) + "\"><title>" +
                    Escape(picture.title) + "</title>\n" + Bands(picture, x, bottom);
  const std::vector<double> ticks = Ticks(picture.x_min, picture.x_max, 8);
  for (const double tick : ticks) {
    svg += Line("grid", x.At(tick), kTop, x.At(tick), bottom);
    svg += TextAt(x.At(tick), bottom + 15, "tick middle",
                  TickText(tick, ticks.size() > 1 ? ticks[1] - ticks[0] : 1));
  }
  svg += Marks(picture, x, bottom) + "\n";
  double top = kTop;
  for (const Panel& panel : picture.panels) {
    svg += PanelAt(panel, x, top);
    top += panel.height + kBetweenPanels;
  }
  return svg + TextAt((x.from + x.to) / 2, bottom + 32, "axis middle", picture.x_label) + "</svg>\n";
}

}  // namespace mwidth::cli::session
