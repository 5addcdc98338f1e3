// The axes that the services serve, by name.
#pragma once

#include <string>
#include <vector>

#include "server/gate/refusal.h"

namespace mwidth::gate {
class AxisGate;
}
namespace mwidth::exchange {
class Clock;
}
namespace mwidth::record {
class Broadcast;
class EventLog;
class SessionRecorder;
}  // namespace mwidth::record

namespace mwidth::rpc {

/// What the services need of one axis; all of it outlives the server.
struct Axis {
  std::string name;
  gate::AxisGate& gate;
  record::Broadcast& broadcast;
  record::EventLog& events;
  const exchange::Clock& clock;
  /// nullptr: nothing is recorded here.
  record::SessionRecorder* recorder = nullptr;
};

/// Filled before the server starts, then only read: any thread.
class AxisRegistry {
 public:
  /// Throws std::invalid_argument for an empty name or one that is there already.
  void Add(Axis axis);

  /// The axis of that name, or with an empty name the only one. NOT_FOUND (UNKNOWN_AXIS) or, for an empty
  /// name where there are several, INVALID_ARGUMENT (AMBIGUOUS_AXIS). The pointer is never null and stays
  /// valid as long as the registry.
  gate::Result<const Axis*> Find(const std::string& name) const;

  /// In the order of Add.
  const std::vector<Axis>& axes() const { return axes_; }

 private:
  std::vector<Axis> axes_;
};

}  // namespace mwidth::rpc
