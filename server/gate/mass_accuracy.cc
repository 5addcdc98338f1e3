#include "server/gate/mass_accuracy.h"

#include "server/model/force_noise.h"
#include "server/model/m_width.h"

namespace mwidth::gate {
namespace {

std::string WhyMissing(const model::LoopParameters& loop, const model::PerceivedMass& perceived) {
  switch (perceived.perception) {
    case model::Perception::kKnown:
      return perceived.error ? ""
                             : "device mass and virtual mass add up to 0, of which no error is a fraction";
    case model::Perception::kNotMoved:
      return "the hand holds with neither stiffness nor damping: it moves nothing and feels no mass";
    case model::Perception::kUnresolved:
      return "damping holds the device so much faster than a sample period that its mass is not seen";
    case model::Perception::kUnstable:
      break;
  }
  const model::MWidth m_width = model::ComputeMWidth(loop);
  return m_width.empty() ? m_width.empty_reason
                         : "the mass is outside of the M-width: the loop is unstable, and the hand feels an "
                           "oscillation that grows";
}

}  // namespace

MassAccuracy PredictAccuracy(const model::LoopParameters& loop, double mass, const model::MotionBand& band,
                             double position_quantum, double acceleration_quantum) {
  const model::PerceivedMass perceived = model::PredictPerceivedMass(loop, mass, band);
  MassAccuracy accuracy{.ideal_mass = loop.device_mass + mass,
                        .force_noise = {},
                        .unavailable_reason = WhyMissing(loop, perceived)};
  if (!model::IsAccelerometer(loop.estimator) || acceleration_quantum > 0) {
    accuracy.force_noise = model::ForceNoise(loop, mass, position_quantum, acceleration_quantum);
  } else if (accuracy.unavailable_reason.empty()) {
    accuracy.unavailable_reason =
        "this axis has no accelerometer, so its counts, and their noise, are not known";
  }
  if (perceived.perception == model::Perception::kKnown) {
    accuracy.perceived_mass = perceived.mass;
    accuracy.error = perceived.error;
  }
  return accuracy;
}

void SimulateAccuracy(const model::LoopParameters& loop, double mass, const model::MotionBand& band,
                      MassAccuracy& accuracy) {
  const model::PerceivedMass perceived = model::MeasurePerceivedMass(loop, mass, band);
  if (perceived.perception == model::Perception::kKnown) {
    accuracy.simulated_perceived_mass = perceived.mass;
    accuracy.simulated_error = perceived.error;
  }
}

}  // namespace mwidth::gate
