// An HDF5 file as an export writes it: groups, attributes, tables and columns that grow. No HDF5 in this
// header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/record/export/columns.h"

namespace mwidth::record {

/// Paths are absolute within the file ("/samples/position"); a group is made before what is in it. Strings
/// are of variable length in UTF-8, a null character in them becomes a space. Everything throws
/// std::runtime_error with the name of the file and what HDF5 says of it. One thread of the process at a
/// time.
class Hdf5File {
 public:
  /// Replaces `path`. `name`: as which messages name it.
  Hdf5File(const std::filesystem::path& path, std::string name);
  Hdf5File(Hdf5File&&) noexcept;
  ~Hdf5File();

  void Group(const std::string& path);

  /// Of the group or dataset at `object`.
  void Attribute(const std::string& object, const std::string& name, std::string_view value);
  void Attribute(const std::string& object, const std::string& name, double value);
  void Attribute(const std::string& object, const std::string& name, int64_t value);
  void Attribute(const std::string& object, const std::string& name, uint64_t value);

  /// One text.
  void Text(const std::string& path, std::string_view text);
  /// Whole columns.
  void Texts(const std::string& path, std::span<const std::string> texts);
  void Numbers(const std::string& path, std::span<const int64_t> numbers);
  void Numbers(const std::string& path, std::span<const uint64_t> numbers);

  /// A column that grows: chunks of 16384 values, shuffled, compressed (gzip), with a checksum. Its type is
  /// that of `example`: booleans and Coded are bytes without sign. Returns its number for Append.
  size_t Series(const std::string& path, const Value& example);
  /// `value` has the type of the column's example. Written out chunk by chunk: memory stays bounded.
  void Append(size_t series, const Value& value);

  /// Writes what is left. To be called once all is in: what a full disk lost is known only then.
  void Close();

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace mwidth::record
