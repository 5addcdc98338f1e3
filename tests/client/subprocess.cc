#include "tests/client/subprocess.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace mwidth::testing {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

// A nameless file, gone when it is closed: unlike a pipe, nobody has to drain it while the program runs.
File Scratch() { return {std::tmpfile(), std::fclose}; }

std::string Content(std::FILE* file) {
  std::string content;
  std::rewind(file);
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) {
    content.push_back(static_cast<char>(c));
  }
  return content;
}

pid_t Start(std::vector<std::string> words, const std::string& server, int out, int err) {
  std::vector<char*> argv;
  for (auto& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  // Set in this process: the tests run one program at a time.
  setenv("MWIDTH_SERVER", server.c_str(), 1);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err, STDERR_FILENO);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw std::runtime_error("cannot start " + words[0]);
  }
  return pid;
}

}  // namespace

Outcome RunProgram(const std::string& command, const std::vector<std::string>& arguments,
                   const std::string& server, const std::function<void(int pid)>& meanwhile) {
  const auto out = Scratch();
  const auto err = Scratch();
  std::vector<std::string> words = {command};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const pid_t pid = Start(words, server, fileno(out.get()), fileno(err.get()));
  if (meanwhile) {
    meanwhile(pid);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          .out = Content(out.get()),
          .err = Content(err.get())};
}

}  // namespace mwidth::testing
