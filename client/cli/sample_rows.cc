#include "client/cli/sample_rows.h"

#include <algorithm>
#include <iomanip>
#include <string>
#include <utility>

#include "client/cli/numbers.h"
#include "client/cli/report.h"

namespace mwidth::cli {
namespace {

class Csv : public SampleRows {
 public:
  Csv(std::ostream& out, const Units& units, bool extremes) : out_(out), units_(units), extremes_(extremes) {}

  void Write(const v1::SampleBatch& batch, int index) override {
    if (!head_written_) {
      out_ << "tick,monotonic_ns,position_" << units_.position.suffix << ",velocity_"
           << units_.velocity.suffix << ",acceleration_" << units_.acceleration.suffix << ",force_"
           << units_.force.suffix << ",mass_" << units_.mass.suffix
           << ",state,saturated,position_counts,force_counts,acceleration_counts";
      if (extremes_) {
        WriteExtremesHead();
      }
      out_ << '\n';
      head_written_ = true;
    }
    out_ << TickOf(batch, index) << ',' << batch.monotonic_ns(index) << ',' << Exact(batch.position(index))
         << ',' << Exact(batch.velocity(index)) << ',' << Exact(batch.acceleration(index)) << ','
         << Exact(batch.force(index)) << ',' << Exact(batch.mass(index)) << ','
         << StateName(batch.state(index)) << ',' << (batch.saturated(index) ? 1 : 0) << ','
         << batch.position_counts(index) << ',' << batch.force_counts(index)
         << ','
         // A server from before accelerometers sends none.
         << (index < batch.acceleration_counts_size() ? batch.acceleration_counts(index) : 0);
    if (extremes_) {
      for (const auto* column :
           {&batch.position_min(), &batch.position_max(), &batch.velocity_min(), &batch.velocity_max(),
            &batch.acceleration_min(), &batch.acceleration_max(), &batch.force_min(), &batch.force_max()}) {
        // A server from before reductions sends none.
        out_ << ',' << (index < column->size() ? Exact(column->Get(index)) : "");
      }
    }
    out_ << '\n';
  }

 private:
  void WriteExtremesHead() {
    for (const auto& [name, unit] : {std::pair{"position", &units_.position},
                                     {"velocity", &units_.velocity},
                                     {"acceleration", &units_.acceleration},
                                     {"force", &units_.force}}) {
      out_ << ',' << name << "_min_" << unit->suffix << ',' << name << "_max_" << unit->suffix;
    }
  }

  std::ostream& out_;
  const Units& units_;
  const bool extremes_;
  bool head_written_ = false;
};

class Table : public SampleRows {
 public:
  Table(std::ostream& out, const Units& units) : out_(out), units_(units) {}

  void Write(const v1::SampleBatch& batch, int index) override {
    if (rows_ == 0) {
      first_ns_ = batch.monotonic_ns(index);
    }
    if (rows_++ % 20 == 0) {
      WriteHead();
    }
    const double time_s = 1e-9 * static_cast<double>(batch.monotonic_ns(index) - first_ns_);
    Cell(Rounded(time_s), 9);
    Cell(Rounded(batch.position(index)));
    Cell(Rounded(batch.velocity(index)));
    Cell(Rounded(batch.acceleration(index), 5));
    Cell(Rounded(batch.force(index), 5));
    Cell(Rounded(batch.mass(index)));
    out_ << "  " << StateName(batch.state(index)) << (batch.saturated(index) ? ", force limited" : "")
         << "\n";
  }

 private:
  void Cell(const std::string& text, int width = 14) {
    // setw counts bytes; every byte of a character but its first is 10xxxxxx.
    const auto hidden = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) == 0x80; });
    out_ << std::right << std::setw(width + static_cast<int>(hidden)) << text;
  }
  void WriteHead() {
    Cell("time", 9);
    for (const char* name : {"position", "velocity", "accel.", "force", "mass"}) {
      Cell(name);
    }
    out_ << "  state\n";
    Cell("s", 9);
    for (const auto& unit :
         {units_.position, units_.velocity, units_.acceleration, units_.force, units_.mass}) {
      Cell(unit.text);
    }
    out_ << "\n";
  }

  std::ostream& out_;
  const Units& units_;
  uint64_t rows_ = 0;
  int64_t first_ns_ = 0;
};

}  // namespace

std::unique_ptr<SampleRows> CsvRows(std::ostream& out, const Units& units, bool extremes) {
  return std::make_unique<Csv>(out, units, extremes);
}

std::unique_ptr<SampleRows> TableRows(std::ostream& out, const Units& units) {
  return std::make_unique<Table>(out, units);
}

uint64_t TickOf(const v1::SampleBatch& batch, int index) {
  // A server that left the decimation unset sent every tick.
  return batch.first_tick() + static_cast<uint64_t>(index) * std::max<uint64_t>(1, batch.decimation());
}

}  // namespace mwidth::cli
