// `mwidth session`: what works on files, without a server. Each returns an exit code and throws where a
// session is not there or cannot be read.
#pragma once

#include "client/cli/command_line.h"

namespace mwidth::cli::session {

int List(const CommandLine& line);
int Show(const CommandLine& line);
int Export(const CommandLine& line);
int Recover(const CommandLine& line);
int Verify(const CommandLine& line);
/// Writes a page for people (report.cc).
int Report(const CommandLine& line);
/// Proves what ran (replay.cc).
int Replay(const CommandLine& line);

}  // namespace mwidth::cli::session
