#include "server/record/export/hdf5_file.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "server/record/export/hdf5_handle.h"

namespace mwidth::record {
namespace {

// Above some 10,000 values a chunk compresses no better; 16384 doubles are 128 KiB, well within HDF5's cache.
constexpr hsize_t kChunk = 16384;
// The level beyond which gzip costs much and gains little.
constexpr unsigned kGzipLevel = 4;

}  // namespace

class Hdf5File::Parts {
 public:
  Parts(const std::filesystem::path& path, std::string name)
      : name_(std::move(name)), file_(Create(path), H5Fclose), string_(StringType()) {}
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() {
    // HDF5 1.10 crashes when it is to close what it could not write: that stays open until the process ends.
    if (failed_) {
      file_.Abandon();
      for (GrowingColumn& column : series_) {
        column.dataset.Abandon();
      }
    }
  }

  void Group(const std::string& path) {
    const Handle group(Check(H5Gcreate2(file_.get(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                       H5Gclose);
  }

  void Attribute(const std::string& object, const std::string& name, hid_t type, const void* value) {
    const Handle space(Check(H5Screate(H5S_SCALAR)), H5Sclose);
    const Handle attribute(Check(H5Acreate_by_name(file_.get(), object.c_str(), name.c_str(), type,
                                                   space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)),
                           H5Aclose);
    Check(H5Awrite(attribute.get(), type, value));
  }

  // `count` values; one without dimensions where there is none.
  void Dataset(const std::string& path, hid_t type, const hsize_t* count, const void* values) {
    const Handle space(Check(count == nullptr ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, count, nullptr)),
                       H5Sclose);
    const Handle dataset(Check(H5Dcreate2(file_.get(), path.c_str(), type, space.get(), H5P_DEFAULT,
                                          H5P_DEFAULT, H5P_DEFAULT)),
                         H5Dclose);
    if (count == nullptr || *count > 0) {
      Check(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
    }
  }

  size_t Series(const std::string& path, hid_t type) {
    const hsize_t none = 0;
    const hsize_t unlimited = H5S_UNLIMITED;
    const Handle space(Check(H5Screate_simple(1, &none, &unlimited)), H5Sclose);
    const Handle layout(Check(H5Pcreate(H5P_DATASET_CREATE)), H5Pclose);
    Check(H5Pset_chunk(layout.get(), 1, &kChunk));
    Check(H5Pset_shuffle(layout.get()));
    Check(H5Pset_deflate(layout.get(), kGzipLevel));
    Check(H5Pset_fletcher32(layout.get()));
    series_.push_back({Handle(Check(H5Dcreate2(file_.get(), path.c_str(), type, space.get(), H5P_DEFAULT,
                                               layout.get(), H5P_DEFAULT)),
                              H5Dclose),
                       type,
                       0,
                       0,
                       {}});
    return series_.size() - 1;
  }

  void Append(size_t number, const Value& value) {
    GrowingColumn& column = series_[number];
    AppendBytes(column.waiting, value);
    if (++column.waiting_count == kChunk) {
      Write(column);
    }
  }

  void Close() {
    for (GrowingColumn& column : series_) {
      Write(column);
      Check(column.dataset.Close());
    }
    Check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL));
    Check(file_.Close());
  }

  hid_t string() const { return string_.get(); }

 private:
  struct GrowingColumn {
    Handle dataset;
    hid_t type;
    hsize_t written;
    hsize_t waiting_count;
    std::vector<std::byte> waiting;
  };

  template <typename Result>
  Result Check(Result result) {
    if (result < 0) {
      failed_ = true;
      throw std::runtime_error("cannot write " + name_ + ": " + InnermostError());
    }
    return result;
  }

  hid_t Create(const std::filesystem::path& path) {
    // Nor may it try again when the process ends.
    H5dont_atexit();
    // Errors come as exceptions; the library would print them, too.
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    return Check(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  }

  Handle StringType() {
    Handle type(Check(H5Tcopy(H5T_C_S1)), H5Tclose);
    Check(H5Tset_size(type.get(), H5T_VARIABLE));
    Check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
    return type;
  }

  void Write(GrowingColumn& column) {
    if (column.waiting_count == 0) {
      return;
    }
    const hsize_t end = column.written + column.waiting_count;
    Check(H5Dset_extent(column.dataset.get(), &end));
    const Handle file_space(Check(H5Dget_space(column.dataset.get())), H5Sclose);
    Check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, &column.written, nullptr,
                              &column.waiting_count, nullptr));
    const Handle memory_space(Check(H5Screate_simple(1, &column.waiting_count, nullptr)), H5Sclose);
    Check(H5Dwrite(column.dataset.get(), column.type, memory_space.get(), file_space.get(), H5P_DEFAULT,
                   column.waiting.data()));
    column.written = end;
    column.waiting_count = 0;
    column.waiting.clear();
  }

  std::string name_;
  bool failed_ = false;
  Handle file_;
  Handle string_;
  std::vector<GrowingColumn> series_;
};

Hdf5File::Hdf5File(const std::filesystem::path& path, std::string name)
    : parts_(std::make_unique<Parts>(path, std::move(name))) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

void Hdf5File::Group(const std::string& path) { parts_->Group(path); }

void Hdf5File::Attribute(const std::string& object, const std::string& name, std::string_view value) {
  const std::string text = Terminated(value);
  const char* const pointer = text.c_str();
  parts_->Attribute(object, name, parts_->string(), &pointer);
}
void Hdf5File::Attribute(const std::string& object, const std::string& name, double value) {
  parts_->Attribute(object, name, H5T_NATIVE_DOUBLE, &value);
}
void Hdf5File::Attribute(const std::string& object, const std::string& name, int64_t value) {
  parts_->Attribute(object, name, H5T_NATIVE_INT64, &value);
}
void Hdf5File::Attribute(const std::string& object, const std::string& name, uint64_t value) {
  parts_->Attribute(object, name, H5T_NATIVE_UINT64, &value);
}

void Hdf5File::Text(const std::string& path, std::string_view text) {
  const std::string terminated = Terminated(text);
  const char* const pointer = terminated.c_str();
  parts_->Dataset(path, parts_->string(), nullptr, &pointer);
}
void Hdf5File::Texts(const std::string& path, std::span<const std::string> texts) {
  std::vector<std::string> terminated;
  std::transform(texts.begin(), texts.end(), std::back_inserter(terminated), Terminated);
  std::vector<const char*> pointers;
  std::transform(terminated.begin(), terminated.end(), std::back_inserter(pointers),
                 [](const std::string& text) { return text.c_str(); });
  const hsize_t count = pointers.size();
  parts_->Dataset(path, parts_->string(), &count, pointers.data());
}
void Hdf5File::Numbers(const std::string& path, std::span<const int64_t> numbers) {
  const hsize_t count = numbers.size();
  parts_->Dataset(path, H5T_NATIVE_INT64, &count, numbers.data());
}
void Hdf5File::Numbers(const std::string& path, std::span<const uint64_t> numbers) {
  const hsize_t count = numbers.size();
  parts_->Dataset(path, H5T_NATIVE_UINT64, &count, numbers.data());
}

size_t Hdf5File::Series(const std::string& path, const Value& example) {
  return parts_->Series(path, TypeOf(example));
}
void Hdf5File::Append(size_t series, const Value& value) { parts_->Append(series, value); }

void Hdf5File::Close() { parts_->Close(); }

}  // namespace mwidth::record
