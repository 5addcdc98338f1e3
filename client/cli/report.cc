#include "client/cli/report.h"

#include <iomanip>
#include <sstream>

#include "client/cli/numbers.h"

namespace mwidth::cli {
namespace {

std::string Quantity(double value, const Unit& unit) { return Rounded(value) + " " + unit.text; }

std::string LowerCase(std::string text, char separator) {
  for (auto& c : text) {
    c = c == '_' ? separator : (c >= 'A' && c <= 'Z') ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return text;
}

// "STATE_READY" without its prefix, as words.
std::string EnumWords(const std::string& name, const std::string& prefix) {
  return LowerCase(name.substr(name.starts_with(prefix) ? prefix.size() : 0), ' ');
}

class Table {
 public:
  void Row(const std::string& name, const std::string& value) {
    out_ << "  " << std::left << std::setw(17) << name << value << "\n";
  }
  std::ostringstream& out() { return out_; }
  std::string Text() const { return out_.str(); }

 private:
  std::ostringstream out_;
};

void AppendAxis(const v1::AxisState& axis, Table& table) {
  const auto& units = UnitsOf(axis.info().kind());
  table.out() << axis.info().name() << " (" << KindName(axis.info().kind())
              << (axis.info().simulated() ? ", simulated)\n" : ")\n");
  table.Row("state", StateName(axis.state()));
  if (axis.has_fault()) {
    table.Row("fault", EnumWords(v1::FaultKind_Name(axis.fault().kind()), "FAULT_KIND_") + " at tick " +
                           std::to_string(axis.fault().tick()) + ": " + axis.fault().message());
  }
  table.Row("controlled by", axis.controller().empty() ? "nobody" : axis.controller());
  table.Row("mass", Quantity(axis.mass(), units.mass) +
                        (axis.mass() == axis.target_mass()
                             ? ""
                             : ", on its way to " + Quantity(axis.target_mass(), units.mass)));
  table.Row("admitted masses", IntervalText(axis.m_width().admitted(), units));
  table.Row("position", Quantity(axis.position(), units.position));
  table.Row("velocity", Quantity(axis.velocity(), units.velocity));
  table.Row("force", Quantity(axis.force(), units.force) + " (limit " +
                         Quantity(axis.info().force_limit(), units.force) + ")");
  table.Row("tick", std::to_string(axis.tick()));
  table.Row("missed ticks", std::to_string(axis.missed_ticks()));
  table.Row("dropped samples", std::to_string(axis.dropped_samples()));
  table.Row("real time", std::string(axis.realtime() ? "yes" : "no") +
                             (axis.realtime_message().empty() ? "" : "; " + axis.realtime_message()));
}

std::string LoopText(const v1::LoopParameters& loop, const Units& units) {
  const bool rotary = &units == &UnitsOf(v1::AXIS_KIND_ROTARY);
  const std::string damping = rotary ? " N m s/rad" : " N s/m";
  const std::string stiffness = rotary ? " N m/rad" : " N/m";
  std::ostringstream out;
  out << "device " << Quantity(loop.device_mass(), units.mass) << ", " << Rounded(loop.device_damping())
      << damping << "; hand " << Quantity(loop.hand_mass(), units.mass) << ", "
      << Rounded(loop.hand_damping()) << damping << ", " << Rounded(loop.hand_stiffness()) << stiffness
      << "; " << Rounded(1 / loop.period_s()) << " Hz, cut-off " << Rounded(loop.cutoff_hz()) << " Hz, delay "
      << Rounded(1e3 * loop.delay_s()) << " ms";
  return out.str();
}

// `format`: Rounded for what is computed, RoundedTowardZero for what may be asked for.
void AppendInterval(const std::string& name, const v1::Interval& interval, double device_mass,
                    std::string (*format)(double, int), Table& table) {
  auto& out = table.out();
  out << "  " << std::left << std::setw(10) << name;
  if (interval.empty()) {
    out << "none: " << interval.empty_reason() << "\n";
    return;
  }
  out << std::right;
  for (const auto edge :
       {interval.min(), interval.max(), interval.min() / device_mass, interval.max() / device_mass}) {
    out << std::setw(15) << format(edge, 9);
  }
  out << "\n";
}

// The three ways in which a mass can miss the admitted range.
std::string WhyRefused(const v1::StabilityReport& report) {
  const auto required = report.m_width().required_gain_margin_db();
  if (report.gain_margin_db() < 0) {
    return "would make the loop unstable";
  }
  if (report.gain_margin_db() < required) {
    return "would leave a gain margin of " + Rounded(report.gain_margin_db(), 3) + " dB, and " +
           Rounded(required, 3) + " dB are required";
  }
  return "would not be stable for every hand and device that the axis allows for";
}

}  // namespace

std::string StateName(v1::State state) { return EnumWords(v1::State_Name(state), "STATE_"); }

std::string KindName(v1::AxisKind kind) { return EnumWords(v1::AxisKind_Name(kind), "AXIS_KIND_"); }

std::string IntervalText(const v1::Interval& interval, const Units& units) {
  if (interval.empty()) {
    return "none: " + interval.empty_reason();
  }
  return "from " + RoundedTowardZero(interval.min()) + " to " + RoundedTowardZero(interval.max()) + " " +
         units.mass.text;
}

std::string StateReport(const v1::GetStateResponse& response) {
  Table table;
  table.out() << "mwidthd " << response.server_version() << "\n";
  for (const auto& axis : response.axes()) {
    table.out() << "\n";
    AppendAxis(axis, table);
  }
  return table.Text();
}

std::string MWidthReport(const v1::GetMWidthResponse& response, const v1::AxisInfo& axis) {
  const auto& units = UnitsOf(axis.kind());
  const auto& m_width = response.m_width();
  Table table;
  auto& out = table.out();
  out << axis.name() << ": " << LoopText(response.loop(), units) << "\n\n";
  // The field widths count bytes, and the superscript has two.
  const std::string mass_unit = units.mass.text;
  const auto superscripts = static_cast<int>(mass_unit.find("²") == std::string::npos ? 0 : 1);
  out << std::left << std::setw(12) << "" << std::right << std::setw(15 + superscripts)
      << "M min, " + mass_unit << std::setw(15 + superscripts) << "M max, " + mass_unit << std::setw(15)
      << "M/m min" << std::setw(15) << "M/m max"
      << "\n";
  AppendInterval("nominal", m_width.nominal(), response.loop().device_mass(), Rounded, table);
  AppendInterval("robust", m_width.robust(), response.loop().device_mass(), Rounded, table);
  AppendInterval("admitted", m_width.admitted(), response.loop().device_mass(), RoundedTowardZero, table);
  if (!m_width.nominal().empty()) {
    out << "\nAt its nominal edges the loop oscillates at " << Rounded(m_width.min_critical_hz())
        << " Hz (lower) and " << Rounded(m_width.max_critical_hz()) << " Hz (upper).\n";
  }
  out << "Admitted masses keep a gain margin of " << Rounded(m_width.required_gain_margin_db()) << " dB.\n";
  return table.Text();
}

std::string AdmissionReport(const v1::SetMassResponse& response, const v1::AxisInfo& axis,
                            bool validate_only) {
  const auto& units = UnitsOf(axis.kind());
  const auto& stability = response.stability();
  std::ostringstream out;
  out << (validate_only ? "Would render " : "Rendering ") << Quantity(response.mass(), units.mass) << " on "
      << axis.name() << ": gain margin " << Rounded(stability.gain_margin_db(), 4)
      << " dB; admitted are masses " << IntervalText(stability.m_width().admitted(), units) << ".\n";
  return out.str();
}

std::string RefusalReport(const v1::StabilityReport& report, const v1::AxisInfo& axis) {
  const auto& units = UnitsOf(axis.kind());
  const auto& admitted = report.m_width().admitted();
  std::ostringstream out;
  out << "Refused: a virtual mass of " << Quantity(report.requested_mass(), units.mass) << " on "
      << axis.name() << " " << WhyRefused(report) << ".\n";
  out << "  Admitted are masses " << IntervalText(admitted, units);
  if (!admitted.empty()) {
    out << "; the nearest is " << RoundedTowardZero(report.nearest_admitted_mass()) << " " << units.mass.text;
  }
  out << ".\n";
  if (report.has_admitting_cutoff_hz()) {
    out << "  A filter cut-off of " << RoundedTowardZero(report.admitting_cutoff_hz(), 4)
        << " Hz would admit it; it is " << Rounded(report.loop().cutoff_hz(), 4) << " Hz.\n";
  } else {
    out << "  No cut-off of the filter would admit it.\n";
  }
  out << "  The " << (report.requested_mass() < 0 ? "lower" : "upper") << " edge binds. " << report.binding()
      << "\n";
  return out.str();
}

}  // namespace mwidth::cli
