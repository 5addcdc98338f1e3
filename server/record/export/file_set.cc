#include "server/record/export/file_set.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void ThrowErrno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// Of a file its content, of a folder its names.
void Sync(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    ThrowErrno("cannot open " + path.string());
  }
  const int failed = ::fsync(descriptor) < 0 ? errno : 0;
  ::close(descriptor);
  // EINVAL: a file system that cannot sync this kind of file, and needs not.
  if (failed != 0 && failed != EINVAL) {
    errno = failed;
    ThrowErrno("cannot write " + path.string());
  }
}

[[noreturn]] void RefuseExisting(const fs::path& file) {
  throw ExportRefused(file.string() + " exists already; --force replaces it");
}

void Move(const fs::path& from, const fs::path& to, bool replace) {
  // Atomic: what another process made in the meantime is not overwritten.
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), replace ? 0 : RENAME_NOREPLACE) == 0) {
    return;
  }
  if (errno == EEXIST) {
    RefuseExisting(to);
  }
  // File systems without this flag: network shares, for one.
  if (errno != EINVAL && errno != ENOSYS) {
    ThrowErrno("cannot write " + to.string());
  }
  if (!replace && fs::exists(to)) {
    RefuseExisting(to);
  }
  if (::rename(from.c_str(), to.c_str()) != 0) {
    ThrowErrno("cannot write " + to.string());
  }
}

}  // namespace

FileSet::~FileSet() {
  if (committed_) {
    return;
  }
  std::error_code ignored;
  for (const Entry& entry : entries_) {
    if (!entry.done) {
      fs::remove(entry.temporary, ignored);
    }
  }
  // One that is not empty stays.
  for (const fs::path& folder : made_folders_) {
    ::rmdir(folder.c_str());
  }
}

fs::path FileSet::Add(const fs::path& file) {
  if (!overwrite_ && fs::exists(fs::symlink_status(file))) {
    RefuseExisting(file);
  }
  return Stage(file, overwrite_);
}

fs::path FileSet::Replace(const fs::path& file) { return Stage(file, true); }

fs::path FileSet::Stage(const fs::path& file, bool replace) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::vector<fs::path> missing;
  for (fs::path above = folder; !above.empty() && !fs::exists(above); above = above.parent_path()) {
    missing.insert(missing.begin(), above);
  }
  for (const fs::path& made : missing) {
    if (fs::create_directory(made)) {
      made_folders_.insert(made_folders_.begin(), made);
    }
  }
  // A name that no tool takes for data, and no other process for its own.
  entries_.push_back({file,
                      folder / ("." + file.filename().string() + "." + std::to_string(::getpid()) + ".part"),
                      replace, false});
  return entries_.back().temporary;
}

void FileSet::Commit() {
  for (const Entry& entry : entries_) {
    Sync(entry.temporary);
  }
  for (Entry& entry : entries_) {
    Move(entry.temporary, entry.file, entry.replace);
    entry.done = true;
  }
  committed_ = true;
  for (const Entry& entry : entries_) {
    Sync(entry.temporary.parent_path());
  }
}

std::vector<fs::path> FileSet::Paths() const {
  std::vector<fs::path> paths;
  for (const Entry& entry : entries_) {
    paths.push_back(entry.file);
  }
  return paths;
}

TextFile::TextFile(fs::path file) : path_(std::move(file)), file_(std::fopen(path_.c_str(), "wbe")) {
  if (!file_) {
    Fail();
  }
  // Fewer, larger writes; where there is no memory for it, the usual ones.
  static_cast<void>(std::setvbuf(file_.get(), nullptr, _IOFBF, size_t{1} << 18));
}

void TextFile::Write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) {
    Fail();
  }
}

void TextFile::Close() {
  if (std::fclose(file_.release()) != 0) {
    Fail();
  }
}

void TextFile::Fail() const { ThrowErrno("cannot write " + path_.string()); }

void WriteText(const fs::path& file, std::string_view text) {
  TextFile out(file);
  out.Write(text);
  out.Close();
}

}  // namespace mwidth::record
