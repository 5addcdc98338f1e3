#include "server/record/export/hdf5_handle.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <variant>

namespace mwidth::record {

hid_t TypeOf(const Value& value) {
  return std::visit(
      [](const auto& v) -> hid_t {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, double>) {
          return H5T_NATIVE_DOUBLE;
        } else if constexpr (std::is_same_v<T, uint64_t>) {
          return H5T_NATIVE_UINT64;
        } else if constexpr (std::is_same_v<T, int64_t>) {
          return H5T_NATIVE_INT64;
        } else if constexpr (std::is_same_v<T, int32_t>) {
          return H5T_NATIVE_INT32;
        } else {
          return H5T_NATIVE_UINT8;
        }
      },
      value);
}

void AppendBytes(std::vector<std::byte>& bytes, const Value& value) {
  const auto append = [&bytes](const auto& number) {
    const size_t end = bytes.size();
    bytes.resize(end + sizeof number);
    std::memcpy(bytes.data() + end, &number, sizeof number);
  };
  std::visit(
      [&append](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, bool>) {
          append(static_cast<uint8_t>(v));
        } else if constexpr (std::is_same_v<T, Coded>) {
          append(v.code);
        } else {
          append(v);
        }
      },
      value);
}

std::string Terminated(std::string_view text) {
  std::string copy(text);
  std::replace(copy.begin(), copy.end(), '\0', ' ');
  return copy;
}

std::string InnermostError() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned number, const H5E_error2_t* error, void* out) -> herr_t {
        if (number == 0 && error->desc != nullptr) {
          *static_cast<std::string*>(out) = error->desc;
        }
        return 0;
      },
      &text);
  return text.empty() ? "HDF5 does not say why" : text;
}

}  // namespace mwidth::record
