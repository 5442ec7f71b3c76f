#include "common/process/spawn.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>

#include <system_error>

namespace haptics {

Result<pid_t> spawn(const std::filesystem::path& program, const SpawnOptions& options) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  int next = 0;
  for (const int descriptor : options.descriptors) {
    if (descriptor >= 0) {
      posix_spawn_file_actions_adddup2(&files, descriptor, next++);
    } else {
      posix_spawn_file_actions_addopen(&files, next++, "/dev/null", O_RDWR, 0);
    }
  }
  posix_spawn_file_actions_addclosefrom_np(&files, next);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : options.blockedSignals) sigaddset(&signals, signal);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                           (options.ownSession ? POSIX_SPAWN_SETSID : 0)));
  std::string path = program.string();
  std::vector<std::string> words = options.arguments;
  std::vector<char*> arguments{path.data()};
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t process = 0;
  const int error = posix_spawn(&process, path.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error == 0) return process;
  return refused(path, "does not start: " + std::generic_category().message(error));
}

}  // namespace haptics
