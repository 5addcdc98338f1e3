// The robust interval: virtual masses that are stable with every hand, device and delay of an envelope.
#pragma once

#include <string>

#include "server/model/envelope.h"
#include "server/model/loop_parameters.h"
#include "server/model/m_width.h"

namespace mwidth::model {

/// One end of a robust interval.
struct RobustEdge {
  /// No mass between 0 and this is unstable with any loop of the envelope: proved, rounding included. A size
  /// of at least 1 - tightness of the true worst case's, which `binding` bounds from the other side.
  double mass = 0;
  /// The loop of the envelope with the smallest nominal edge that was found, and that edge.
  LoopParameters binding;
  Edge binding_edge;

  /// How far the proof stays below the worst loop found, relative to it: at most this much is given away.
  double gap() const { return 1 - mass / binding_edge.mass; }
};

/// What is vouched for, and under which assumptions. Immutable once made.
struct RobustCertificate {
  /// The assumptions: hands, devices, delays, sample period; the estimator with its cut-off.
  LoopEnvelope assumed;
  RobustEdge lower;
  RobustEdge upper;
  /// Not empty where some loop of the envelope is not even stable at M = 0: then the edges mean nothing.
  std::string empty_reason;
  /// What the proof took: boxes of frequencies and plants that were bounded, and loops whose nominal edges
  /// were computed.
  int boxes = 0;
  int nominal_queries = 0;

  bool empty() const { return !empty_reason.empty(); }
  /// True when `mass` is strictly inside.
  bool Contains(double mass) const { return !empty() && lower.mass < mass && mass < upper.mass; }
};

/// Proves the intersection of the M-widths of all loops of `envelope`. Tightness: the gap of each edge is at
/// most 0.5 %, or 1e-6 where the envelope is a single loop, unless the effort runs out first; what is proved
/// then is sound too, and gap() tells how tight. That happens where the natural frequency of a light device
/// held stiffly comes near half the sample rate in a wide envelope.
///
/// Precondition: Validate(envelope) is empty. Depends on nothing but its argument. Typically some
/// milliseconds, at most about a second, with an accelerometer up to about three: not for the loop's thread.
/// Any thread.
RobustCertificate CertifyRobustInterval(const LoopEnvelope& envelope);

/// Which parameters hold an edge of `certificate` where it is, for a person: "hand_damping at its least
/// (0.5), hand_stiffness at its greatest (300), delay_s inside its range (0.0007)". Parameters without a
/// range are left out; "the released hand" comes first where it binds.
std::string DescribeBinding(const RobustCertificate& certificate, const RobustEdge& edge);

}  // namespace mwidth::model
