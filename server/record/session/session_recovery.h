// Closes the file of a session whose server died.
#pragma once

#include <filesystem>

namespace mwidth::record {

/// As SessionStore::Recover, for a session that is open and that nobody writes. Throws SessionFileError and
/// StorageError.
void RecoverSession(const std::filesystem::path& file);

}  // namespace mwidth::record
