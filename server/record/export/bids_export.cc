#include <algorithm>
#include <array>

#include "server/record/export/bids_dataset.h"
#include "server/record/export/bids_events.h"
#include "server/record/export/bids_labels.h"
#include "server/record/export/bids_motion.h"
#include "server/record/export/export.h"
#include "server/record/export/session_json.h"
#include "server/record/export/text.h"
#include "server/record/session/wall_time.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;

// Everything that BIDS has no field for.
std::string SourceJson(const SessionReader& reader, uint64_t exported_samples) {
  auto json = SessionJson(reader.info());
  json["wall_clock_steps"] = ToJson(reader.WallClockSteps());
  json["exported_samples"] = exported_samples;
  json["gaps"] = ToJson(reader.Gaps());
  json["damaged_blocks"] = ToJson(reader.damaged());
  return Indented(json);
}

std::string ScansJson() {
  return Indented({{"acq_time", {{"Description", "When the first sample was taken, UTC"}}},
                   {"duration", {{"Description", "Rows of motion.tsv times their period"}, {"Units", "s"}}},
                   {"operator", {{"Description", "Who ran the session"}}},
                   {"mwidth_session", {{"Description", "Name of the session in mwidth's folder"}}},
                   {"mwidth_state",
                    {{"Description", "How its recording came to its end"},
                     {"Levels",
                      {{"open", "It had not when it was exported"},
                       {"ended", "As it should"},
                       {"recovered", "The server died or lost its disk; what was written is here"}}}}}});
}

// Whether the dataset has any README: README, README.md, README.txt or README.rst.
bool HasReadme(const fs::path& dataset) {
  constexpr std::array<const char*, 4> kNames{"README", "README.md", "README.txt", "README.rst"};
  return std::any_of(kNames.begin(), kNames.end(),
                     [&dataset](const char* name) { return fs::exists(dataset / name); });
}

class BidsExport {
 public:
  BidsExport(SessionReader& reader, fs::path dataset, bool overwrite)
      : reader_(reader),
        info_(reader.info()),
        labels_(LabelsOf(info_)),
        dataset_(std::move(dataset)),
        motion_(dataset_ / labels_.Folder() / "motion" / labels_.Recording()),
        files_(overwrite) {}

  ExportReport Run() {
    WriteRecording();
    const DatasetLock lock(dataset_);
    WriteShared();
    files_.Commit();
    return {.files = files_.Paths(), .samples = extent_.samples, .damaged = reader_.damaged()};
  }

 private:
  // Next to motion.tsv.
  fs::path Beside(const std::string& suffix) const { return motion_.string() + suffix; }

  void WriteRecording() {
    const auto channels = ChannelsOf(info_.axis);
    const fs::path motion_tsv = files_.Add(Beside("_motion.tsv"));
    const fs::path motion_json = files_.Add(Beside("_motion.json"));
    const fs::path channels_tsv = files_.Add(Beside("_channels.tsv"));
    const fs::path channels_json = files_.Add(Beside("_channels.json"));
    const fs::path events_tsv = files_.Add(Beside("_events.tsv"));
    const fs::path events_json = files_.Add(Beside("_events.json"));
    const fs::path source =
        files_.Add(dataset_ / "sourcedata" / "mwidth" / (labels_.Recording() + "_session.json"));

    extent_ = WriteMotion(reader_, channels, motion_tsv);
    if (extent_.samples == 0) {
      throw ExportRefused("session " + info_.id +
                          " has no samples, and Motion-BIDS has no recording without; export it as csv");
    }
    WriteText(motion_json, MotionJson(info_, channels, extent_));
    WriteText(channels_tsv, ChannelsTsv(channels, 1 / info_.axis.period_s));
    WriteText(channels_json, ChannelsJson(info_.axis));
    // After the samples: damaged blocks are gaps, too, and are known now.
    WriteText(events_tsv,
              EventsTsv(reader_.Markers(), reader_.Events(), reader_.Gaps(), extent_, info_.axis.period_s));
    WriteText(events_json, EventsJson(info_.provenance.software_version));
    WriteText(source, SourceJson(reader_, extent_.samples));
  }

  void WriteShared() {
    const fs::path scans = dataset_ / labels_.Folder() / (labels_.Person() + "_scans.tsv");
    auto scan_table = BidsTable::Read(
        scans, {"filename", "acq_time", "duration", "operator", "mwidth_session", "mwidth_state"});
    scan_table.Set(
        {{"filename", "motion/" + labels_.Recording() + "_motion.tsv"},
         {"acq_time", UtcTime(WallTime(info_, reader_.WallClockSteps(), extent_.first_monotonic_ns))},
         {"duration", Number(static_cast<double>(extent_.rows()) * info_.axis.period_s)},
         {"operator", TsvCell(info_.labels.operator_name)},
         {"mwidth_session", TsvCell(info_.id)},
         {"mwidth_state", std::string(StateWord(info_.state))}});
    const fs::path participants = dataset_ / "participants.tsv";
    auto participant_table = BidsTable::Read(participants, {"participant_id"});
    participant_table.Set({{"participant_id", labels_.subject}});
    const fs::path description = dataset_ / "dataset_description.json";

    WriteText(files_.Replace(description),
              DatasetDescription(description, fs::absolute(dataset_).lexically_normal().filename().string()));
    if (!HasReadme(dataset_)) {
      WriteText(files_.Replace(dataset_ / "README"), DatasetReadme());
    }
    WriteText(files_.Replace(participants), participant_table.Text());
    const fs::path scans_json = fs::path(scans).replace_extension(".json");
    if (!fs::exists(scans_json)) {
      WriteText(files_.Replace(scans_json), ScansJson());
    }
    WriteText(files_.Replace(scans), scan_table.Text());
  }

  SessionReader& reader_;
  const SessionInfo& info_;
  BidsLabels labels_;
  fs::path dataset_;
  fs::path motion_;
  MotionExtent extent_;
  // Last: what it has not committed is removed first.
  FileSet files_;
};

}  // namespace

ExportReport ExportBids(SessionReader& reader, const fs::path& dataset, bool overwrite) {
  return BidsExport(reader, dataset, overwrite).Run();
}

}  // namespace mwidth::record
