// The channels of a Motion-BIDS recording: what the columns of motion.tsv are.
#pragma once

#include <string>
#include <vector>

#include "server/record/export/columns.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// One column of motion.tsv and one row of channels.tsv, in BIDS's terms.
struct BidsChannel {
  std::string name;
  std::string component;
  std::string type;
  std::string tracked_point;
  std::string units;
  std::string reference_frame;
  std::string description;
  /// None: the latency since the first sample.
  Value (*of)(const exchange::Sample&) = nullptr;
  /// From the sample's unit to that of the channel: 180/pi for angles. Of doubles alone.
  double scale = 1;
};

/// LATENCY; position (JNTANG in deg, POS in m), velocity, acceleration, force and mass; then every other
/// column of SampleColumns as MISC.
std::vector<BidsChannel> ChannelsOf(const SessionAxis& axis);

/// channels.tsv, and channels.json with its reference frame.
std::string ChannelsTsv(const std::vector<BidsChannel>& channels, double sampling_frequency_hz);
std::string ChannelsJson(const SessionAxis& axis);

/// The cell of `sample`: "n/a" for what is no number.
void AppendCell(std::string& out, const BidsChannel& channel, const exchange::Sample& sample,
                int64_t first_monotonic_ns);

}  // namespace mwidth::record
