#include "server/model/worst_edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "server/model/crossing_guess.h"
#include "server/model/m_width.h"

namespace mwidth::model {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Intervals this narrow, relative to their place, are points.
constexpr double kPoint = 1e-13;

// Plants on an arc of the circle. No crossing of theirs is smaller than `bound`.
struct Cell {
  Interval x;
  PlantBox box;
  std::size_t box_index = 0;
  PlantRange plant;
  double bound = 0;

  // For a queue that gives the smallest bound first.
  bool operator<(const Cell& other) const { return bound > other.bound; }
};

constexpr std::array kPlantDirections = {&PlantBox::mass, &PlantBox::damping, &PlantBox::stiffness};

// 0 for a point, up to 2.
double RelativeWidth(const Interval& a) {
  const double width = a.hi > 0 ? 2 * a.width() / (a.lo + a.hi) : 0;
  return width > kPoint ? width : 0;
}

// Where to halve: by ratio what spans more than an octave.
double Halfway(const Interval& a) {
  constexpr double kFromZero = 64;
  if (a.lo <= 0) {
    return a.hi / kFromZero;
  }
  return a.hi > 2 * a.lo ? std::sqrt(a.lo) * std::sqrt(a.hi) : a.middle();
}

// How much kappa - alpha^2 varies: must come down before anything is known of plants that may alias.
double NaturalFrequencySpread(const PlantRange& plant) { return (plant.kappa - Square(plant.alpha)).width(); }

class Search {
 public:
  Search(const Sampling& sampling, MassSign sign)
      : sampling_(sampling),
        estimator_(sampling.estimator, sampling.period_s, sampling.cutoff_hz,
                   sampling.accelerometer_bandwidth_hz),
        plant_sampling_{.period_s = sampling.period_s, .sensor_rate = estimator_.sensor_rate()},
        sign_(sign) {
    edge_.found = kInfinity;
  }

  WorstEdge Run(std::span<const PlantBox> boxes, const SearchEffort& effort);

 private:
  // Two halves of a cell, bounded, and how much was gained: what their bounds add up to.
  struct Halves {
    Cell low;
    Cell high;
    double gain = -kInfinity;
  };

  void Add(Cell cell) {
    if (Bound(cell)) {
      queue_.push(cell);
    }
  }
  // False where the cell has no crossing below the smallest edge found; raises its bound otherwise.
  bool Bound(Cell& cell);
  // Halves the best cell of the queue; false where it is but a point.
  bool Divide(const Cell& cell);
  Halves HalveArc(const Cell& cell);
  Halves HalvePlant(const Cell& cell, Interval PlantBox::*direction, double at);
  void BoundHalves(Halves& halves, double width);

  void TryCorners(const PlantBox& box, std::size_t index);
  void TryInside(const Cell& cell);
  // Lowers edge_.found to the nominal edge of a plant of a box, if it is smaller.
  void Try(LoopParameters plant, std::size_t index);

  Sampling sampling_;
  EstimatorRange estimator_;
  PlantSampling plant_sampling_;
  MassSign sign_;
  WorstEdge edge_;
  std::priority_queue<Cell> queue_;
};

WorstEdge Search::Run(std::span<const PlantBox> boxes, const SearchEffort& effort) {
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    TryCorners(boxes[i], i);
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Cell cell{
        .x = {0, 1}, .box = boxes[i], .box_index = i, .plant = Enclose(boxes[i], plant_sampling_)};
    Cell half_rate = cell;
    half_rate.x = Exactly(1);
    Add(cell);
    Add(half_rate);
    // A free mass without friction is at rest at any place: the only root that can pass z = 1.
    if (boxes[i].stiffness.hi <= 0 && boxes[i].damping.lo <= 0) {
      Cell standstill = cell;
      standstill.x = Exactly(0);
      Add(standstill);
    }
  }
  edge_.proved = edge_.found;
  while (!queue_.empty()) {
    const Cell cell = queue_.top();
    edge_.proved = std::min(cell.bound, edge_.found);
    if (cell.bound >= (1 - effort.tolerance) * edge_.found || edge_.boxes >= effort.max_boxes) {
      break;
    }
    queue_.pop();
    TryInside(cell);
    if (!Divide(cell)) {
      break;
    }
  }
  return edge_;
}

bool Search::Bound(Cell& cell) {
  constexpr int kNarrowings = 3;
  const Arc arc(cell.x);
  for (int i = 0;; ++i) {
    ++edge_.boxes;
    const LoopRange factor = LoopFactor(estimator_, arc, cell.plant, cell.box.delay_ticks);
    CrossingSizes sizes = BoundCrossings(arc, cell.plant, factor, sign_);
    sizes.lo = cell.bound = std::max(cell.bound, sizes.lo);
    sizes.hi = std::min(sizes.hi, edge_.found);
    if (sizes.none() || cell.bound >= edge_.found) {
      return false;
    }
    if (i == kNarrowings || !Narrow(cell.box, arc, cell.plant, factor, sign_, sizes)) {
      return true;
    }
    cell.plant = Enclose(cell.box, plant_sampling_);
  }
}

void Search::BoundHalves(Halves& halves, double width) {
  halves.gain = 1e-9 * width;  // where nothing is gained anywhere, the widest
  for (Cell* half : {&halves.low, &halves.high}) {
    if (!Bound(*half)) {
      half->bound = kInfinity;
    }
    halves.gain += std::min(half->bound, edge_.found) / edge_.found;
  }
}

Search::Halves Search::HalveArc(const Cell& cell) {
  Halves halves{.low = cell, .high = cell};
  halves.low.x.hi = halves.high.x.lo = Halfway(cell.x);
  BoundHalves(halves, RelativeWidth(cell.x));
  return halves;
}

Search::Halves Search::HalvePlant(const Cell& cell, Interval PlantBox::*direction, double at) {
  Halves halves{.low = cell, .high = cell};
  (halves.low.box.*direction).hi = at;
  (halves.high.box.*direction).lo = at;
  halves.low.plant = Enclose(halves.low.box, plant_sampling_);
  halves.high.plant = Enclose(halves.high.box, plant_sampling_);
  BoundHalves(halves, RelativeWidth(cell.box.*direction));
  if (cell.plant.knowledge == PlantKnowledge::kUnbounded) {
    halves.gain = -NaturalFrequencySpread(halves.low.plant) - NaturalFrequencySpread(halves.high.plant);
  }
  return halves;
}

bool Search::Divide(const Cell& cell) {
  Halves best;
  const auto keep_better = [&best](const Halves& halves) {
    if (halves.gain > best.gain) {
      best = halves;
    }
  };
  const bool bounded = cell.plant.knowledge != PlantKnowledge::kUnbounded;
  if (bounded && RelativeWidth(cell.x) > 0) {
    keep_better(HalveArc(cell));
  }
  if (bounded && cell.box.fraction.width() > kPoint) {
    keep_better(HalvePlant(cell, &PlantBox::fraction, cell.box.fraction.middle()));
  }
  for (Interval PlantBox::*direction : kPlantDirections) {
    const Interval& range = cell.box.*direction;
    if (RelativeWidth(range) > 0) {
      keep_better(HalvePlant(cell, direction, Halfway(range)));
    }
  }
  for (const Cell* half : {&best.low, &best.high}) {
    if (best.gain > -kInfinity && half->bound < kInfinity) {
      queue_.push(*half);
    }
  }
  return best.gain > -kInfinity;
}

void Search::TryCorners(const PlantBox& box, std::size_t index) {
  constexpr unsigned kCorners = 16;
  for (unsigned corner = 0; corner < kCorners; ++corner) {
    const auto end = [corner](const Interval& range, unsigned bit) {
      return (corner >> bit & 1U) != 0 ? range.hi : range.lo;
    };
    Try({.device_mass = end(box.mass, 0),
         .device_damping = end(box.damping, 1),
         .hand_stiffness = end(box.stiffness, 2),
         .delay_s = (box.delay_ticks + end(box.fraction, 3)) * sampling_.period_s},
        index);
  }
}

void Search::TryInside(const Cell& cell) {
  const double x = cell.x.middle();
  if (x <= 0 || cell.plant.knowledge == PlantKnowledge::kUnbounded) {
    return;
  }
  if (const auto plant = GuessWorstPlant(x, cell.box, cell.plant, estimator_, sign_, sampling_.period_s)) {
    Try(*plant, cell.box_index);
  }
}

void Search::Try(LoopParameters plant, std::size_t index) {
  plant.period_s = sampling_.period_s;
  plant.cutoff_hz = sampling_.cutoff_hz;
  plant.estimator = sampling_.estimator;
  plant.accelerometer_bandwidth_hz = sampling_.accelerometer_bandwidth_hz;
  ++edge_.nominal_queries;
  const EdgeMasses edges = ComputeEdgeMasses(plant);
  const double size = sign_ == MassSign::kPositive ? edges.upper : -edges.lower;
  // False where there is no edge.
  if (size < edge_.found) {
    edge_.found = size;
    edge_.binding = plant;
    edge_.binding_box = index;
  }
}

}  // namespace

WorstEdge FindWorstEdge(std::span<const PlantBox> boxes, const Sampling& sampling, MassSign sign,
                        const SearchEffort& effort) {
  return Search(sampling, sign).Run(boxes, effort);
}

}  // namespace mwidth::model
