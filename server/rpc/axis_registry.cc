#include "server/rpc/axis_registry.h"

#include <stdexcept>
#include <utility>

namespace mwidth::rpc {
namespace {

std::string Names(const std::vector<Axis>& axes) {
  std::string names;
  for (const Axis& axis : axes) {
    names += (names.empty() ? "" : ", ") + axis.name;
  }
  return names;
}

}  // namespace

void AxisRegistry::Add(Axis axis) {
  if (axis.name.empty()) {
    throw std::invalid_argument("an axis needs a name");
  }
  for (const Axis& other : axes_) {
    if (other.name == axis.name) {
      throw std::invalid_argument("two axes are named '" + axis.name + "'");
    }
  }
  axes_.push_back(std::move(axis));
}

gate::Result<const Axis*> AxisRegistry::Find(const std::string& name) const {
  if (name.empty() && axes_.size() == 1) {
    return &axes_.front();
  }
  for (const Axis& axis : axes_) {
    if (axis.name == name) {
      return &axis;
    }
  }
  if (name.empty() && !axes_.empty()) {
    return gate::Refusal{.code = gate::RefusalCode::kInvalidArgument,
                         .reason = gate::kAmbiguousAxis,
                         .message = "This server has several axes: name one of " + Names(axes_) + ".",
                         .metadata = {{"axes", Names(axes_)}}};
  }
  // The name is not repeated: a client may have sent anything, of any length.
  return gate::Refusal{.code = gate::RefusalCode::kNotFound,
                       .reason = gate::kUnknownAxis,
                       .message = "There is no axis of that name: ask for " + Names(axes_) + ".",
                       .metadata = {{"axes", Names(axes_)}}};
}

}  // namespace mwidth::rpc
