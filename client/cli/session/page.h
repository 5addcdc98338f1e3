// The report as one page of HTML: no script, nothing from a network, pictures inside.
#pragma once

#include <cstddef>
#include <ostream>
#include <string>

#include "client/cli/session/analysis.h"

namespace mwidth::cli::session {

/// Writes the whole page. Labels, metadata and messages are escaped wherever they come from.
void WritePage(const Analysis& analysis, std::ostream& out);

// Its parts, in their order; each is a <section> or empty.

/// What was recorded and how it went, in sentences.
std::string Summary(const Analysis& analysis);
/// One row for each commanded mass, and the movements laid over each other.
std::string MassSection(const Analysis& analysis);
/// One row for each movement.
std::string MovementSection(const Analysis& analysis);
/// A picture and the figures of one trial; `index` into Analysis::trials.
std::string TrialPart(const Analysis& analysis, std::size_t index);
/// Position, force and mass over the whole session, its states and gaps.
std::string OverviewSection(const Analysis& analysis);
/// Device, loop, limits and M-width at the start.
std::string AxisSection(const Analysis& analysis);
/// Events and markers on one time line.
std::string LogSection(const Analysis& analysis);
/// How each figure is defined.
std::string DefinitionSection();
/// Configuration and command line, folded.
std::string ConfigurationSection(const Analysis& analysis);

/// What the page calls a trial; not escaped.
std::string TrialName(const Analysis& analysis, std::size_t index);
/// The class of a mass's colour in the style sheet, by its place among the groups.
std::string ColourOf(const Analysis& analysis, double mass, const exchange::Filter& filter);

}  // namespace mwidth::cli::session
