// Files that come into being together, each whole or not at all.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace mwidth::record {

/// What is asked for would harm what is there, or cannot be told in this format. what() says what to do.
class ExportRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Files are written beside their place under a temporary name, and Commit moves them there once they are on
/// the disk. Without a Commit nothing of them stays, nor of the folders that were made for them. A power cut
/// between two of the moves can leave the first files of the set, each of them whole. One thread.
class FileSet {
 public:
  /// `overwrite`: replace files that are there already.
  explicit FileSet(bool overwrite) : overwrite_(overwrite) {}
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;
  ~FileSet();

  /// The name to write `file` under until Commit; makes its folder where there is none. Throws ExportRefused
  /// where `file` exists and may not be replaced, std::filesystem::filesystem_error where the folder cannot
  /// be made.
  std::filesystem::path Add(const std::filesystem::path& file);
  /// The same for a file that was read and is written anew with more in it.
  std::filesystem::path Replace(const std::filesystem::path& file);

  /// Everything to the disk and to its place, in the order in which it was added. Throws std::system_error
  /// naming the file, or ExportRefused where somebody else has made it meanwhile.
  void Commit();

  /// Where the files are, or will be.
  std::vector<std::filesystem::path> Paths() const;

 private:
  struct Entry {
    std::filesystem::path file;
    std::filesystem::path temporary;
    bool replace = false;
    bool done = false;
  };

  std::filesystem::path Stage(const std::filesystem::path& file, bool replace);

  bool overwrite_;
  bool committed_ = false;
  std::vector<Entry> entries_;
  /// Innermost first.
  std::vector<std::filesystem::path> made_folders_;
};

/// A text file that is written from its beginning to its end. One thread.
class TextFile {
 public:
  /// Throws std::system_error naming the file; so do the others.
  explicit TextFile(std::filesystem::path file);

  void Write(std::string_view text);
  /// To be called once all is written: what a full disk lost is known only then.
  void Close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void Fail() const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// All of `text` as `file`.
void WriteText(const std::filesystem::path& file, std::string_view text);

}  // namespace mwidth::record
