// session: recorded sessions, their files and what is made of them.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/cli/command_line.h"

namespace mwidth::cli {
namespace {

CLI::App* Verb(CLI::App& session, CommandLine& line, const std::string& name, const std::string& description,
               const std::string& examples) {
  auto* verb = Subcommand(session, name, description, examples);
  verb->callback([&line, name] { line.session.verb = name; });
  return verb;
}

CLI::Option* AddSessions(CLI::App* verb, CommandLine& line, const std::string& description) {
  return verb->add_option("session", line.session.sessions, description)->type_name("SESSION");
}

// "key=value" pairs into `take`.
void AddMetadata(CLI::App* verb, const std::function<void(const std::string&, const std::string&)>& take) {
  verb->add_option_function<std::vector<std::string>>(
          "--meta",
          [take](const std::vector<std::string>& pairs) {
            for (const std::string& pair : pairs) {
              const std::size_t equals = pair.find('=');
              if (equals == std::string::npos) {
                throw CLI::ValidationError("--meta", "'" + pair + "' is not KEY=VALUE");
              }
              take(pair.substr(0, equals), pair.substr(equals + 1));
            }
          },
          "Anything else to keep with it; may be given several times")
      ->type_name("KEY=VALUE");
}

void DefineStart(CLI::App& session, CommandLine& line) {
  auto* verb = Verb(session, line, "start", "Ask the server to record an axis, until session end",
                    "  mwidth session start sub-01 reach\n"
                    "  mwidth session start sub-01 reach --visit 2 --run 3 --meta arm=left");
  v1::SessionLabels& labels = line.session.labels;
  const auto add = [verb](const std::string& name, const std::function<void(const std::string&)>& take,
                          const std::string& description) {
    return verb->add_option_function<std::string>(name, take, description)->type_name("LABEL");
  };
  add(
      "subject", [&labels](const std::string& text) { labels.set_subject(text); }, "Who: letters and digits")
      ->required();
  add(
      "task", [&labels](const std::string& text) { labels.set_task(text); },
      "What is done: letters and digits")
      ->required();
  add(
      "--visit", [&labels](const std::string& text) { labels.set_visit(text); },
      "Which visit, where there are several");
  add(
      "--operator", [&labels](const std::string& text) { labels.set_operator_(text); },
      "Who runs the session");
  verb->add_option_function<uint32_t>(
      "--run", [&labels](uint32_t run) { labels.set_run(run); },
      "From 1; default: one more than the last of this subject, visit and task");
  AddMetadata(verb, [&labels](const std::string& key, const std::string& value) {
    (*labels.mutable_metadata())[key] = value;
  });
}

void DefineEnd(CLI::App& session, CommandLine& line) {
  auto* verb = Verb(session, line, "end", "Ask the server to end a session; it is on the disk then",
                    "  mwidth session end");
  AddSessions(verb, line, "Its name; may be left out where only one is being recorded")->expected(0, 1);
}

void DefineMark(CLI::App& session, CommandLine& line) {
  auto* verb = Verb(session, line, "mark", "Mark this moment in the session that is being recorded",
                    "  mwidth session mark 'strap adjusted'\n"
                    "  mwidth session mark 'reach 1' --kind trial_start --meta target_deg=30");
  verb->add_option("label", line.session.marker, "What happened")->required();
  verb->add_option("--kind", line.session.marker_kind,
                   "trial_start and trial_end bound a trial; anything else is the study's own");
  AddMetadata(verb, [&line](const std::string& key, const std::string& value) {
    line.session.marker_metadata[key] = value;
  });
}

void DefineExport(CLI::App& session, CommandLine& line) {
  auto* verb =
      Verb(session, line, "export",
           "Write sessions for other programs. Nothing that is there is replaced without --force; "
           "blocks that are damaged are left out, told, and exit code 1",
           "  mwidth session export sub-01_task-reach_run-01_20261122T063200Z --to out --format csv\n"
           "  mwidth session export --folder /srv/sessions sub-01_task-reach_run-01_20261122T063200Z "
           "sub-01_task-reach_run-02_20261122T064500Z --to study --format bids");
  AddSessions(verb, line, "Names or files")->required();
  verb->add_option(
          "--to", line.session.to,
          "Folder: csv makes a folder of each session's name in it, hdf5 a file; bids adds them to the "
          "dataset that it is, or becomes")
      ->required()
      ->type_name("FOLDER");
  verb->add_option("--format", line.session.format, "csv, hdf5 or bids (Motion-BIDS)")
      ->required()
      ->check(CLI::IsMember({"csv", "hdf5", "bids"}));
  verb->add_flag("--force", line.session.force, "Replace what an earlier export of the session wrote");
}

void DefineReport(CLI::App& session, CommandLine& line) {
  auto* verb =
      Verb(session, line, "report",
           "Write one page of HTML with pictures: each trial and movement, overshoot, commanded and "
           "perceived mass, margins, events. Markers of kind trial_start and trial_end bound trials; "
           "their metadata target_deg, target_rad or target_m, and start_.., say where a reach goes. "
           "Blocks that are damaged are left out, told, and exit code 1",
           "  mwidth session report sub-01_task-reach_run-01_20261122T063200Z\n"
           "  mwidth session report sub-01_task-reach_run-01_20261122T063200Z --to reach.html");
  AddSessions(verb, line, "Name or file")->required()->expected(1);
  verb->add_option("--to", line.session.to, "The page; default: the session's name with .html")
      ->type_name("FILE");
}

void DefineReplay(CLI::App& session, CommandLine& line) {
  auto* verb = Verb(
      session, line, "replay",
      "Send the recorded positions once more through the estimator and the force law, and compare every "
      "bit of motion and force: proves what ran, with the same build. Exit code 1 where anything differs "
      "or cannot be compared",
      "  mwidth session replay sub-01_task-reach_run-01_20261122T063200Z");
  AddSessions(verb, line, "Names or files")->required();
}

}  // namespace

void DefineSession(CLI::App& app, CommandLine& line) {
  auto* session = Subcommand(
      app, "session", "Recorded sessions: a session is named as the list has it, or by its file",
      "  mwidth session list\n"
      "  mwidth session show sub-01_task-reach_run-01_20261122T063200Z\n"
      "  mwidth session export sub-01_task-reach_run-01_20261122T063200Z --to study --format bids\n"
      "  mwidth session verify mwidth-sessions/*");
  session->require_subcommand(1);
  session->add_option("--folder", line.session.folder, "Where the sessions are")
      ->envname("MWIDTH_SESSIONS")
      ->capture_default_str();
  DefineStart(*session, line);
  DefineMark(*session, line);
  DefineEnd(*session, line);
  Verb(*session, line, "list", "The sessions in the folder, the newest first", "  mwidth session list");
  auto* show = Verb(*session, line, "show", "All that a session says of itself but its samples",
                    "  mwidth session show sub-01_task-reach_run-01_20261122T063200Z");
  AddSessions(show, line, "Name or file")->required()->expected(1);
  DefineExport(*session, line);
  auto* recover =
      Verb(*session, line, "recover",
           "Close the files of sessions whose server died, with everything that it had written. A "
           "server does this itself when it starts; a session that is being recorded stays as it is",
           "  mwidth session recover");
  AddSessions(recover, line, "Names or files; default: all that are open");
  auto* verify =
      Verb(*session, line, "verify",
           "Check every block of sessions against its checksums, and compute every column again; exit "
           "code 1 where anything is damaged",
           "  mwidth session verify sub-01_task-reach_run-01_20261122T063200Z");
  AddSessions(verify, line, "Names or files")->required();
  DefineReport(*session, line);
  DefineReplay(*session, line);
}

}  // namespace mwidth::cli
