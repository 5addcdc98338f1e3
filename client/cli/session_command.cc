#include <functional>
#include <map>
#include <string>

#include "client/cli/commands.h"
#include "client/cli/session/verbs.h"

namespace mwidth::cli {

int RunSession(const CommandLine& line) {
  static const std::map<std::string, std::function<int(const CommandLine&)>> verbs = {
      {"start", RunSessionStart},    {"mark", RunSessionMark},    {"end", RunSessionEnd},
      {"list", session::List},       {"show", session::Show},     {"export", session::Export},
      {"recover", session::Recover}, {"verify", session::Verify}, {"report", session::Report},
      {"replay", session::Replay}};
  return verbs.at(line.session.verb)(line);
}

}  // namespace mwidth::cli
