// A session's samples.csv and `mwidth stream --csv` are read by the same programs: their columns have the
// same names.
#include "client/cli/sample_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <utility>

#include "client/cli/report.h"
#include "server/record/export/columns.h"

namespace mwidth::cli {
namespace {

using ::testing::StartsWith;

std::string StreamedHead(v1::AxisKind kind) {
  v1::SampleBatch batch;
  batch.add_monotonic_ns(0);
  batch.add_position(0);
  batch.add_velocity(0);
  batch.add_acceleration(0);
  batch.add_force(0);
  batch.add_mass(0);
  batch.add_state(v1::STATE_READY);
  batch.add_saturated(false);
  batch.add_position_counts(0);
  batch.add_force_counts(0);
  batch.add_acceleration_counts(0);
  std::ostringstream out;
  CsvRows(out, UnitsOf(kind))->Write(batch, 0);
  return out.str().substr(0, out.str().find('\n'));
}

std::string ExportedHead(bool rotary) {
  std::string head;
  for (const auto& column : record::SampleColumns(rotary)) {
    head += (head.empty() ? "" : ",") + column.csv_name;
  }
  return head;
}

TEST(SampleRowsTest, ExportedColumnsBeginAsStreamedOnesDo) {
  EXPECT_THAT(ExportedHead(true), StartsWith(StreamedHead(v1::AXIS_KIND_ROTARY) + ","));
  EXPECT_THAT(ExportedHead(false), StartsWith(StreamedHead(v1::AXIS_KIND_LINEAR) + ","));
}

TEST(SampleRowsTest, StatesHaveTheSameWords) {
  for (const auto& [state, word] : {std::pair{exchange::State::kIdle, v1::STATE_IDLE},
                                    std::pair{exchange::State::kReady, v1::STATE_READY},
                                    std::pair{exchange::State::kRendering, v1::STATE_RENDERING},
                                    std::pair{exchange::State::kFault, v1::STATE_FAULT}}) {
    EXPECT_EQ(record::StateWord(state), StateName(word));
  }
}

}  // namespace
}  // namespace mwidth::cli
