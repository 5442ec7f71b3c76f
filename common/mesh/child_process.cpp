#include "common/mesh/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace haptics {
namespace {

using Clock = std::chrono::steady_clock;

std::string nameOf(const std::filesystem::path& program) { return program.filename().string(); }

/// A pipe whose ends are closed with it.
class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  }
  ~Pipe() {
    closeWriter();
    close(ends_[0]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] int reader() const { return ends_[0]; }
  [[nodiscard]] int writer() const { return ends_[1]; }
  void closeWriter() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

Result<pid_t> start(const std::filesystem::path& program, const std::string& argument, const Pipe& output) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output.writer(), STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::string path = program.string(), word = argument;
  const std::array<char*, 3> arguments{path.data(), word.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawn(&child, path.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error == 0) return child;
  return refused("", "cannot be read: the program " + path + " does not start: " + std::strerror(error));
}

/// Nothing wrong: an empty text.
std::string readAll(int descriptor, Clock::time_point deadline, std::size_t most, std::string& output) {
  std::array<char, 1 << 16> block;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd ready{descriptor, POLLIN, 0};
    const int changes = left > 0 ? poll(&ready, 1, static_cast<int>(left)) : 0;
    if (changes == 0) return "takes too long";
    if (changes < 0 && errno == EINTR) continue;
    const ssize_t size = read(descriptor, block.data(), block.size());
    if (size == 0) return "";
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return std::strerror(errno);
    output.append(block.data(), static_cast<std::size_t>(size));
    if (output.size() > most) return "gives more than can be taken";
  }
}

}  // namespace

Result<std::string> outputOf(const std::filesystem::path& program, const std::string& argument,
                             std::chrono::milliseconds patience, std::size_t mostOutput) {
  Pipe pipe;
  const auto child = start(program, argument, pipe);
  if (!child) return tl::unexpected(child.error());
  pipe.closeWriter();

  std::string output;
  const std::string fault = readAll(pipe.reader(), Clock::now() + patience, mostOutput, output);
  if (!fault.empty()) kill(*child, SIGKILL);
  int status = 0;
  while (waitpid(*child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!fault.empty()) return refused("", "cannot be read: " + nameOf(program) + ' ' + fault);
  if (WIFSIGNALED(status)) {
    return refused("", "is damaged: " + nameOf(program) + " ends on it by " + strsignal(WTERMSIG(status)));
  }
  if (WEXITSTATUS(status) != 0) {
    return refused("",
                   "is damaged: " + nameOf(program) + " ends on it with code " + std::to_string(WEXITSTATUS(status)));
  }
  return output;
}

}  // namespace haptics
