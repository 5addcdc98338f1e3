// What an analysis answers, as pictures.
#pragma once

#include <mwidth/v1/stability.pb.h>

#include <string>
#include <vector>

#include "client/cli/plot/chart.h"
#include "client/cli/plot/map.h"
#include "client/cli/units.h"

namespace mwidth::cli {

/// Both edges over the parameter of a sweep of one row.
plot::Chart SweepChart(const std::string& title, const v1::SweepMWidthRequest& request,
                       const v1::SweepMWidthResponse& row, const Units& units);
/// Each edge as a map over both parameters of a sweep.
plot::Map SweepMap(const std::string& title, const v1::SweepMWidthRequest& request,
                   const std::vector<v1::SweepMWidthResponse>& rows, const Units& units);
/// Magnitude, phase and, where they are known, the effective ratios.
plot::Chart BodeChart(const std::string& title, const v1::GetFrequencyResponseResponse& response);
/// One cut-off frequency and what it makes of a mass.
struct CutoffAccuracy {
  double cutoff_hz = 0;
  v1::Accuracy accuracy;
};

/// Error of the perceived mass over the filter's cut-off, as in the paper's Figure 9; a gap where the mass is
/// unstable. `own` is marked, also as simulated where it was.
plot::Chart AccuracyChart(const std::string& title, const std::vector<CutoffAccuracy>& accuracies,
                          const CutoffAccuracy& own);

}  // namespace mwidth::cli
