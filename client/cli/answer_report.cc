#include "client/cli/answer_report.h"

#include "client/cli/loop_words.h"
#include "client/cli/numbers.h"

namespace mwidth::cli {
namespace {

bool Noisy(const client::Refusal& refusal) { return refusal.reason == "NOISY_MASS"; }

// The ways in which a mass can be inadmissible: noisy, unstable, or too near to it, for the nominal loop or
// for another.
std::string WhyRefused(const client::Refusal& refusal) {
  const auto& report = refusal.stability;
  const auto required_db = report.m_width().required_gain_margin_db();
  const auto least_db = report.margins().gain_db();
  if (Noisy(refusal)) {
    return "would be stable, but make the force noisier than the axis allows";
  }
  if (report.gain_margin_db() < 0) {
    return "would make the loop unstable";
  }
  if (least_db < 0) {
    return "would not be stable for every hand and device that the axis allows for";
  }
  if (least_db < required_db) {
    return "would leave a gain margin of " + Rounded(least_db, 3) + " dB, and " + Rounded(required_db, 3) +
           " dB are required";
  }
  return "is not proved to leave a gain margin of " + Rounded(required_db, 3) +
         " dB for every hand and device that the axis allows for";
}

// The edge that binds, or the noise: the server's sentence.
std::string Binding(const client::Refusal& refusal) {
  const auto& report = refusal.stability;
  const bool edge = !Noisy(refusal) && !report.m_width().admitted().empty();
  return "  " +
         (edge ? std::string("The ") + (report.requested_mass() < 0 ? "lower" : "upper") + " edge binds. "
               : std::string()) +
         report.binding() + "\n";
}

// The least of the nominal loop and of those that bind.
std::string MarginsLine(const v1::StabilityReport& report) {
  return "  Margins: " + MarginsText(report.margins()) + ".\n";
}

// "Admitted are masses from -0.05 to 0.35 kg".
std::string AdmittedText(const v1::StabilityReport& report, const v1::AxisInfo& axis) {
  const auto& admitted = report.m_width().admitted();
  return admitted.empty() ? "No mass is admitted: " + admitted.empty_reason()
                          : "Admitted are masses " + IntervalText(admitted, UnitsOf(axis.kind()));
}

std::string Mass(double mass, const v1::AxisInfo& axis) {
  return Quantity(mass, UnitsOf(axis.kind()).mass) + " on " + axis.name();
}

}  // namespace

std::string AdmissionReport(const v1::SetMassResponse& response, const v1::AxisInfo& axis,
                            bool validate_only) {
  const auto& stability = response.stability();
  return (validate_only ? "Would render " : "Rendering ") + Mass(response.mass(), axis) + ". " +
         AdmittedText(stability, axis) + ".\n" + MarginsLine(stability);
}

std::string RefusalReport(const client::Refusal& refusal, const v1::AxisInfo& axis) {
  const auto& report = refusal.stability;
  std::string text = "Refused: a virtual mass of " + Mass(report.requested_mass(), axis) + " " +
                     WhyRefused(refusal) + ".\n  " + AdmittedText(report, axis);
  if (report.m_width().admitted().empty()) {
    return text + ".\n";
  }
  text += "; the nearest is " + RoundedTowardZero(report.nearest_admitted_mass()) + " " +
          UnitsOf(axis.kind()).mass.text + ".\n";
  if (report.has_admitting_cutoff_hz()) {
    text += "  A filter cut-off of " + RoundedTowardZero(report.admitting_cutoff_hz(), 4) +
            " Hz would admit it; it is " + Rounded(report.loop().cutoff_hz(), 4) + " Hz.\n";
  } else {
    text += "  No lower cut-off of the filter would admit it.\n";
  }
  return text + Binding(refusal) + MarginsLine(report);
}

std::string FilterReport(const v1::SetFilterResponse& response, const v1::AxisInfo& axis,
                         bool validate_only) {
  const auto& stability = response.stability();
  std::string text = axis.name() + (validate_only ? ": filter would be " : ": filter is ") +
                     FilterText(response.loop()) + "; it " + (validate_only ? "is " : "was ") +
                     FilterText(axis.loop()) + ".\n  " + AdmittedText(stability, axis) + ".\n";
  if (stability.requested_mass() != 0) {
    text += "  The mass of " + Mass(stability.requested_mass(), axis) + " stays.\n" + MarginsLine(stability);
  }
  return text;
}

std::string FilterRefusalReport(const client::Refusal& refusal, const v1::AxisInfo& axis) {
  const auto& report = refusal.stability;
  return "Refused: with " + FilterText(report.loop()) + ", the virtual mass of " +
         Mass(report.requested_mass(), axis) + " that is set " + WhyRefused(refusal) +
         ".\n  Masses admitted with this filter: " +
         IntervalText(report.m_width().admitted(), UnitsOf(axis.kind())) + ".\n" + Binding(refusal) +
         MarginsLine(report);
}

}  // namespace mwidth::cli
