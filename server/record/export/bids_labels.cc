#include "server/record/export/bids_labels.h"

#include <algorithm>

#include "server/record/export/file_set.h"

namespace mwidth::record {
namespace {

bool IsLabel(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
  });
}

const std::string& Checked(const SessionInfo& info, const char* entity, const std::string& text) {
  if (!IsLabel(text)) {
    throw ExportRefused("session " + info.id + ": its " + entity + " \"" + text +
                        "\" is no BIDS label, which has letters and digits only; export it as csv or hdf5");
  }
  return text;
}

}  // namespace

std::filesystem::path BidsLabels::Folder() const {
  const std::filesystem::path folder = subject;
  return visit.empty() ? folder : folder / visit;
}

std::string BidsLabels::Person() const { return visit.empty() ? subject : subject + "_" + visit; }

std::string BidsLabels::Recording() const {
  return Person() + "_task-" + task + "_tracksys-" + kTrackingSystem + "_run-" + run;
}

BidsLabels LabelsOf(const SessionInfo& info) {
  const SessionLabels& labels = info.labels;
  if (labels.run < 1) {
    throw ExportRefused("session " + info.id + ": run " + std::to_string(labels.run) +
                        " is none that BIDS can name; export it as csv or hdf5");
  }
  return {.subject = "sub-" + Checked(info, "subject", labels.subject),
          .visit = labels.visit.empty() ? "" : "ses-" + Checked(info, "visit", labels.visit),
          .task = Checked(info, "task", labels.task),
          .run = (labels.run < 10 ? "0" : "") + std::to_string(labels.run)};
}

}  // namespace mwidth::record
