#include "server/model/loop_simulation.h"

#include <array>

namespace mwidth::model {
namespace {

std::variant<HybridSimulation, AccelerometerSimulation, FrictionSimulation> PlantOf(
    const LoopParameters& loop, double coulomb_friction) noexcept {
  if (coulomb_friction > 0) {
    return FrictionSimulation(loop, coulomb_friction);
  }
  if (IsAccelerometer(loop.estimator)) {
    return AccelerometerSimulation(loop);
  }
  return HybridSimulation(loop);
}

double LargestCounts(const Imperfections& imperfections) noexcept {
  // The division rounds, and may have rounded up to the next whole number.
  const double counts = std::floor(imperfections.force_limit / imperfections.force_quantum);
  return counts * imperfections.force_quantum > imperfections.force_limit ? counts - 1 : counts;
}

}  // namespace

std::optional<ParameterError> Validate(const Imperfections& imperfections) {
  struct Size {
    const char* name;
    double value;
  };
  const std::array<Size, 4> sizes{{{"position_quantum", imperfections.position_quantum},
                                   {"acceleration_quantum", imperfections.acceleration_quantum},
                                   {"force_quantum", imperfections.force_quantum},
                                   {"coulomb_friction", imperfections.coulomb_friction}}};
  for (const Size& size : sizes) {
    if (!(size.value >= 0 && size.value <= 1e6)) {
      return ParameterError{size.name, size.value, "0 to 1e6"};
    }
  }
  if (!(imperfections.force_limit >= 0)) {
    return ParameterError{"force_limit", imperfections.force_limit, "at least 0"};
  }
  return std::nullopt;
}

LoopSimulation::LoopSimulation(const LoopParameters& loop, double mass, const Imperfections& imperfections)
    : loop_(loop),
      mass_(mass),
      imperfections_(imperfections),
      ideal_motor_(imperfections.force_quantum == 0 && std::isinf(imperfections.force_limit)),
      largest_counts_(imperfections.force_quantum > 0 ? LargestCounts(imperfections) : 0),
      estimator_(loop.period_s, loop.cutoff_hz, loop.estimator),
      plant_(PlantOf(loop, imperfections.coulomb_friction)) {}

void LoopSimulation::Reset(double position, double velocity, double hand_position) noexcept {
  estimator_.Reset(Read(position));
  if (auto* smooth = std::get_if<HybridSimulation>(&plant_)) {
    smooth->Reset(position, velocity, hand_position);
  } else if (auto* sensed = std::get_if<AccelerometerSimulation>(&plant_)) {
    sensed->Reset(position, velocity, hand_position);
  } else {
    std::get_if<FrictionSimulation>(&plant_)->Reset(position, velocity, hand_position);
  }
}

}  // namespace mwidth::model
