// HDF5's handles, types and errors, for hdf5_file.cc.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/record/export/columns.h"

namespace mwidth::record {

/// Closes what HDF5 has opened.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) {
      close_(id_);
    }
  }
  hid_t get() const { return id_; }
  /// Leaves it open.
  void Abandon() { id_ = -1; }
  herr_t Close() { return close_(std::exchange(id_, -1)); }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// As which values are written: booleans and Coded as bytes without sign.
hid_t TypeOf(const Value& value);
void AppendBytes(std::vector<std::byte>& bytes, const Value& value);

/// `text` with spaces for null characters, at which HDF5 ends strings.
std::string Terminated(std::string_view text);

/// What went wrong at the bottom of HDF5's error stack.
std::string InnermostError();

}  // namespace mwidth::record
