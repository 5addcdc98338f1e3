#include "client/cli/report.h"

#include <iomanip>
#include <sstream>

#include "client/cli/enum_words.h"
#include "client/cli/numbers.h"

namespace mwidth::cli {
namespace {

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
    table.Row("fault", EnumWords(v1::FaultKind_Name(axis.fault().kind()), "FAULT_KIND_", ' ') + " at tick " +
                           std::to_string(axis.fault().tick()) + ": " + axis.fault().message());
  }
  table.Row("controlled by", axis.controller().empty() ? "nobody" : axis.controller());
  table.Row("mass", Quantity(axis.mass(), units.mass) +
                        (axis.mass() == axis.target_mass()
                             ? ""
                             : ", on its way to " + Quantity(axis.target_mass(), units.mass)));
  table.Row("filter", FilterText(axis.info().loop()));
  table.Row("admitted masses", IntervalText(axis.m_width().admitted(), units));
  table.Row("robust for", AssumptionsText(AssumptionsOf(axis.info()), axis.info().loop(), units));
  table.Row("position", Quantity(axis.position(), units.position));
  table.Row("velocity", Quantity(axis.velocity(), units.velocity));
  table.Row("force", Quantity(axis.force(), units.force) + " (limit " +
                         Quantity(axis.info().force_limit(), units.force) + ")");
  table.Row("tick", std::to_string(axis.tick()));
  table.Row("missed ticks", std::to_string(axis.missed_ticks()));
  if (axis.saturated_ticks() + axis.slew_limited_ticks() > 0) {
    table.Row("clamped ticks", std::to_string(axis.saturated_ticks()) + " by the force limit, " +
                                   std::to_string(axis.slew_limited_ticks()) + " by its slew limit");
  }
  table.Row("dropped samples", std::to_string(axis.dropped_samples()));
  table.Row("real time", std::string(axis.realtime() ? "yes" : "no") +
                             (axis.realtime_message().empty() ? "" : "; " + axis.realtime_message()));
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

// What the edges of an M-width stand for. `robust_for`: what is assumed.
void AppendEdges(const v1::GetMWidthResponse& response, const std::string& robust_for, const Units& units,
                 std::ostream& out) {
  const auto& m_width = response.m_width();
  const auto& loop = response.loop();
  if (!m_width.nominal().empty()) {
    out << "\nAt its nominal edges the loop oscillates at " << Rounded(m_width.min_critical_hz())
        << " Hz (lower) and " << Rounded(m_width.max_critical_hz()) << " Hz (upper).\n";
  }
  out << "Robust means stable for " << robust_for << ".\n";
  if (robust_for != kThisLoopAlone && m_width.has_min_binding() && m_width.has_max_binding()) {
    const auto lower = BindingText(m_width.min_binding(), loop, units);
    const auto upper = BindingText(m_width.max_binding(), loop, units);
    out << "The robust edges are set by " << lower
        << (lower == upper ? "" : " (lower) and " + upper + " (upper)") << ".\n";
  }
  out << "Admitted masses keep a gain margin of " << Rounded(m_width.required_gain_margin_db()) << " dB.\n";
}

}  // namespace

std::string StateName(v1::State state) { return EnumWords(v1::State_Name(state), "STATE_", ' '); }

std::string KindName(v1::AxisKind kind) { return EnumWords(v1::AxisKind_Name(kind), "AXIS_KIND_", ' '); }

std::string StateReport(const v1::GetStateResponse& response) {
  Table table;
  table.out() << "mwidthd " << response.server_version() << "\n";
  for (const auto& axis : response.axes()) {
    table.out() << "\n";
    AppendAxis(axis, table);
  }
  return table.Text();
}

std::string MWidthReport(const v1::GetMWidthResponse& response, const v1::AxisInfo& axis,
                         const Assumptions& assumptions) {
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
  AppendEdges(response, AssumptionsText(assumptions, response.loop(), units), units, out);
  return table.Text();
}

}  // namespace mwidth::cli
