#include "server/model/robust_interval.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "server/model/interval.h"
#include "server/model/plant_range.h"
#include "server/model/worst_edge.h"

namespace mwidth::model {
namespace {

constexpr SearchEffort kEffort{.tolerance = 5e-3, .max_boxes = 100'000};
// What an accelerometer sees varies more with the hand.
constexpr SearchEffort kAccelerometerEffort{.tolerance = 5e-3, .max_boxes = 200'000};
// One loop needs only its frequencies divided: a proof is cheap at any tolerance.
constexpr SearchEffort kPointEffort{.tolerance = 1e-6, .max_boxes = 100'000};

// A box of hands with the device's, in the parameters that the loop's equation knows.
struct Hands {
  ParameterRange stiffness;
  ParameterRange damping;
  ParameterRange mass;
};

Interval Range(const ParameterRange& range) { return {range.min, range.max}; }

Interval Sum(const ParameterRange& a, const ParameterRange& b) {
  if (b.min == 0 && b.max == 0) {
    return Range(a);
  }
  const Interval sum = Range(a) + Range(b);
  return {std::max(sum.lo, 0.0), sum.hi};
}

std::vector<Hands> HandsOf(const HandEnvelope& hand) {
  std::vector<Hands> hands{{hand.hand_stiffness, hand.hand_damping, hand.hand_mass}};
  if (hand.include_released_hand) {
    hands.push_back({.stiffness = {}, .damping = {}, .mass = {0, hand.hand_mass.max}});
  }
  return hands;
}

// One box for each tick of delay begun. A bound of whole ticks that rounding made a little more begins one
// more.
void AddDelays(std::vector<PlantBox>& boxes, std::vector<std::size_t>& hand_of_box, PlantBox box,
               std::size_t hand, const LoopEnvelope& envelope) {
  const double ticks = envelope.delay_bound_s > 0 ? Above(envelope.delay_bound_s / envelope.period_s) : 0;
  for (int tick = 0; tick == 0 || tick < ticks; ++tick) {
    box.delay_ticks = tick;
    box.fraction = {0, std::min(1.0, Above(ticks - tick))};
    if (ticks == 0) {
      box.fraction.hi = 0;
    }
    boxes.push_back(box);
    hand_of_box.push_back(hand);
  }
}

// Where `value` lies in `sum`, as the same part of the way from min to max in one summand.
double Share(const ParameterRange& summand, const Interval& sum, double value) {
  const double way = sum.width() > 0 ? std::clamp((value - sum.lo) / sum.width(), 0.0, 1.0) : 0;
  return way >= 1 ? summand.max : summand.min + way * (summand.max - summand.min);
}

RobustEdge MakeEdge(const LoopEnvelope& envelope, const Hands& hands, const WorstEdge& worst, MassSign sign) {
  const ParameterRange& mass = envelope.device.device_mass;
  const ParameterRange& damping = envelope.device.device_damping;
  const Interval masses = Sum(mass, hands.mass);
  const Interval dampings = Sum(damping, hands.damping);
  RobustEdge edge;
  edge.mass = sign == MassSign::kPositive ? worst.proved : -worst.proved;
  edge.binding = worst.binding;
  edge.binding.device_mass = Share(mass, masses, worst.binding.device_mass);
  edge.binding.hand_mass = Share(hands.mass, masses, worst.binding.device_mass);
  edge.binding.device_damping = Share(damping, dampings, worst.binding.device_damping);
  edge.binding.hand_damping = Share(hands.damping, dampings, worst.binding.device_damping);
  edge.binding.delay_s = std::min(worst.binding.delay_s, envelope.delay_bound_s);
  const MWidth width = ComputeMWidth(edge.binding);
  edge.binding_edge = sign == MassSign::kPositive ? width.upper : width.lower;
  return edge;
}

bool IsPoint(const ParameterRange& range) { return range.min == range.max; }

bool IsPoint(const LoopEnvelope& envelope) {
  return !envelope.hand.include_released_hand && envelope.delay_bound_s == 0 &&
         IsPoint(envelope.hand.hand_stiffness) && IsPoint(envelope.hand.hand_damping) &&
         IsPoint(envelope.hand.hand_mass) && IsPoint(envelope.device.device_mass) &&
         IsPoint(envelope.device.device_damping);
}

std::string Number(double value) {
  std::array<char, 32> text{};
  if (std::snprintf(text.data(), text.size(), "%.4g", value) < 0) {
    return "?";
  }
  return text.data();
}

}  // namespace

RobustCertificate CertifyRobustInterval(const LoopEnvelope& envelope) {
  RobustCertificate certificate;
  certificate.assumed = envelope;
  if (envelope.hand.hand_stiffness.max > 0 && envelope.device.device_damping.min == 0 &&
      envelope.hand.hand_damping.min == 0) {
    certificate.empty_reason =
        "the envelope holds loops without damping (device_damping.min and hand_damping.min are 0) but with a "
        "hand's spring: there the mass swings for ever, whatever mass is rendered";
    return certificate;
  }
  const std::vector<Hands> hands = HandsOf(envelope.hand);
  std::vector<PlantBox> boxes;
  std::vector<std::size_t> hand_of_box;
  for (std::size_t i = 0; i < hands.size(); ++i) {
    PlantBox box;
    box.mass = Sum(envelope.device.device_mass, hands[i].mass);
    box.damping = Sum(envelope.device.device_damping, hands[i].damping);
    box.stiffness = Range(hands[i].stiffness);
    AddDelays(boxes, hand_of_box, box, i, envelope);
  }
  const Sampling sampling{.period_s = envelope.period_s,
                          .cutoff_hz = envelope.cutoff_hz,
                          .estimator = envelope.estimator,
                          .accelerometer_bandwidth_hz = envelope.accelerometer_bandwidth_hz};
  const SearchEffort& effort = IsPoint(envelope)                     ? kPointEffort
                               : IsAccelerometer(envelope.estimator) ? kAccelerometerEffort
                                                                     : kEffort;
  for (const MassSign sign : {MassSign::kNegative, MassSign::kPositive}) {
    const WorstEdge worst = FindWorstEdge(boxes, sampling, sign, effort);
    (sign == MassSign::kPositive ? certificate.upper : certificate.lower) =
        MakeEdge(envelope, hands[hand_of_box[worst.binding_box]], worst, sign);
    certificate.boxes += worst.boxes;
    certificate.nominal_queries += worst.nominal_queries;
  }
  return certificate;
}

std::string DescribeBinding(const RobustCertificate& certificate, const RobustEdge& edge) {
  const LoopEnvelope& assumed = certificate.assumed;
  const LoopParameters& at = edge.binding;
  const bool released = assumed.hand.include_released_hand && at.hand_stiffness == 0 && at.hand_damping == 0;
  std::string text = released ? "the released hand" : "";
  const auto add = [&text](const char* name, const ParameterRange& range, double value) {
    if (IsPoint(range)) {
      return;
    }
    const char* place = value <= range.min   ? " at its least ("
                        : value >= range.max ? " at its greatest ("
                                             : " inside its range (";
    text += (text.empty() ? "" : ", ") + std::string(name) + place + Number(value) + ")";
  };
  if (!released) {
    add("hand_stiffness", assumed.hand.hand_stiffness, at.hand_stiffness);
    add("hand_damping", assumed.hand.hand_damping, at.hand_damping);
  }
  const double least_hand_mass = released ? 0 : assumed.hand.hand_mass.min;
  add("hand_mass", {least_hand_mass, assumed.hand.hand_mass.max}, at.hand_mass);
  add("device_mass", assumed.device.device_mass, at.device_mass);
  add("device_damping", assumed.device.device_damping, at.device_damping);
  add("delay_s", {0, assumed.delay_bound_s}, at.delay_s);
  return text.empty() ? "the only loop of the envelope" : text;
}

}  // namespace mwidth::model
