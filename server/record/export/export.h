// What every export takes and tells.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "server/record/export/file_set.h"
#include "server/record/session/session_reader.h"

namespace mwidth::record {

struct ExportReport {
  /// What was written, the samples first.
  std::vector<std::filesystem::path> files;
  uint64_t samples = 0;
  /// Blocks that could not be trusted; the export has everything else, and tells them as gaps.
  std::vector<DamagedBlock> damaged;
};

/// samples.csv (names as `mwidth stream --csv` has them, then what that leaves out), events.csv, markers.csv,
/// gaps.csv and session.json in `folder`. RFC 4180, lines end in a line feed; numbers are the shortest that
/// read back to the same double. Memory: one block, and the events, markers and gaps.
///
/// Reads `reader` from its beginning. Throws ExportRefused, SessionFileError, or a std::runtime_error naming
/// the file that cannot be written; nothing is left behind then. One thread. So do the others.
ExportReport ExportCsv(SessionReader& reader, const std::filesystem::path& folder, bool overwrite);

/// All of it in one HDF5 file (hdf5_export.cc and the README say how it is laid out). HDF5's library is used
/// from one thread of the process at a time.
ExportReport ExportHdf5(SessionReader& reader, const std::filesystem::path& file, bool overwrite);

/// Adds the session to the Motion-BIDS dataset in `dataset`, which is made where there is none. Tables that
/// sessions share (participants.tsv, scans.tsv, dataset_description.json) keep what they have; no other file
/// that is there already is touched unless `overwrite`, and then only those of this session.
ExportReport ExportBids(SessionReader& reader, const std::filesystem::path& dataset, bool overwrite);

}  // namespace mwidth::record
