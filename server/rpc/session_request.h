// Labels and markers as clients send them, checked.
#pragma once

#include <optional>
#include <string>

#include "mwidth/v1/session.pb.h"
#include "server/gate/refusal.h"
#include "server/record/session/session_info.h"

namespace mwidth::rpc {

/// INVALID_ARGUMENT (INVALID_TEXT, INVALID_NUMBER) with the field and what is allowed. "sub-01" and "01" are
/// the same subject, "ses-1" and "1" the same visit.
gate::Result<record::SessionLabels> ReadLabels(const v1::SessionLabels& labels);

/// A marker that arrives at `arrival_ns` of the axis's clock; not numbered.
gate::Result<record::Marker> ReadMarker(const v1::AddMarkerRequest& request, int64_t arrival_ns);

}  // namespace mwidth::rpc
