// The subcommands. Each returns an exit code and throws client::Error where the server cannot be reached or
// declines.
#pragma once

#include <mwidth/v1/rendering.pb.h>

#include "client/cli/command_line.h"

namespace mwidth::cli {

enum ExitCode : int { kDone = 0, kRefused = 1, kUsage = 2, kFailed = 3 };

int RunState(const CommandLine& line);
int RunMWidth(const CommandLine& line);
int RunSweep(const CommandLine& line);
int RunBode(const CommandLine& line);
int RunAccuracy(const CommandLine& line);
int RunSetMass(const CommandLine& line);
int RunSetFilter(const CommandLine& line);
int RunStop(const CommandLine& line);
int RunClearFault(const CommandLine& line);
int RunStream(const CommandLine& line);
int RunEvents(const CommandLine& line);
int RunFigures(const CommandLine& line);
int RunDriveProbe(const CommandLine& line);
int RunSession(const CommandLine& line);
int RunSessionStart(const CommandLine& line);
int RunSessionMark(const CommandLine& line);
int RunSessionEnd(const CommandLine& line);

}  // namespace mwidth::cli
