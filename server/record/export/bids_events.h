// events.tsv: trials, markers, events and gaps of a session on the time line of its motion.tsv.
#pragma once

#include <string>
#include <vector>

#include "server/record/event.h"
#include "server/record/export/bids_motion.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// Sorted by onset, which counts from the first sample; before it, it is negative. Columns: onset, duration,
/// trial_type, label, onset_error, message, metadata, end_label, end_metadata.
///
/// A marker of kind trial_start begins a row of trial_type "trial", the next one of kind trial_end ends it; a
/// trial without an end has no duration (n/a), and an end without a beginning is a row of its own. Other
/// markers are rows of their kind ("marker" where they have none), events of theirs, and gaps of "gap".
std::string EventsTsv(const std::vector<Marker>& markers, const std::vector<Event>& events,
                      const std::vector<Gap>& gaps, const MotionExtent& extent, double period_s);

/// What the columns mean, and the words of trial_type that are not the study's own.
std::string EventsJson(const std::string& software_version);

}  // namespace mwidth::record
