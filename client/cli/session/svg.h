// Pictures as SVG within a page: stacked panels over one horizontal axis. Colours and strokes are the page's
// style sheet's, by class.
#pragma once

#include <string>
#include <vector>

namespace mwidth::cli::session {

struct Point {
  double x = 0;
  /// Not finite: the curve is interrupted.
  double y = 0;
};

struct Curve {
  std::string css_class;
  std::vector<Point> points;
};

/// Across a panel at `y`.
struct Level {
  std::string css_class;
  double y = 0;
  /// Written at the right end; plain text.
  std::string label;
};

struct Panel {
  std::string y_label;
  std::vector<Curve> curves{};
  std::vector<Level> levels{};
  double height = 120;
  /// Least height of what is shown, in units of y: noise must not fill a panel.
  double least_span = 0;
};

/// Down all panels at `x`.
struct Mark {
  std::string css_class;
  double x = 0;
  /// Written above; plain text.
  std::string label;
};

/// Behind all panels.
struct Band {
  std::string css_class;
  double from = 0;
  double to = 0;
  std::string label;
};

struct Picture {
  /// For those who do not see it.
  std::string title;
  std::string x_label;
  double x_min = 0;
  double x_max = 1;
  std::vector<Panel> panels{};
  std::vector<Mark> marks{};
  std::vector<Band> bands{};
  double width = 760;
};

/// An <svg> element. All text is escaped.
std::string Svg(const Picture& picture);

/// Round values from `min` to `max`, both finite and different, some `count` of them.
std::vector<double> Ticks(double min, double max, int count);

/// At most `most` pairs of points for any number of samples: of each bucket the least and the largest in
/// the order in which they came, so that no peak is lost.
std::vector<Point> Thin(const std::vector<Point>& points, std::size_t most);

}  // namespace mwidth::cli::session
