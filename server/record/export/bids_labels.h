// Where a session lies in a BIDS dataset.
#pragma once

#include <filesystem>
#include <string>

#include "server/record/session/session_info.h"

namespace mwidth::record {

/// As the tracking system is called in names of files.
inline constexpr const char* kTrackingSystem = "mwidth";

/// The entities of one recording.
struct BidsLabels {
  /// "sub-01".
  std::string subject;
  /// "ses-1", or empty.
  std::string visit;
  std::string task;
  /// "02"; two digits at least, so that files sort.
  std::string run;

  /// "sub-01/ses-1", from the dataset's folder.
  std::filesystem::path Folder() const;
  /// "sub-01_ses-1".
  std::string Person() const;
  /// "sub-01_ses-1_task-reach_tracksys-mwidth_run-02".
  std::string Recording() const;
};

/// Throws ExportRefused where a label is none: BIDS has letters and digits only, at least one.
BidsLabels LabelsOf(const SessionInfo& info);

}  // namespace mwidth::record
