#include "common/importer/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "common/importer/descriptors.h"

namespace haptics {
namespace {

/// How long a program may take to end that has closed its end of the socket.
constexpr std::chrono::milliseconds kEndsWithin{1000};

/// 0, or the error's number.
int spawn(const std::filesystem::path& program, int socket, pid_t& child) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, socket, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, socket, STDOUT_FILENO);
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

  std::string path = program.string();
  const std::array<char*, 2> arguments{path.data(), nullptr};
  const int error = posix_spawn(&child, path.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

}  // namespace

ChildProcess::WakeUp::WakeUp() : descriptor_(eventfd(0, EFD_CLOEXEC)) {}
ChildProcess::WakeUp::~WakeUp() {
  if (descriptor_ >= 0) close(descriptor_);
}
void ChildProcess::WakeUp::operator()() const noexcept { static_cast<void>(eventfd_write(descriptor_, 1)); }

ChildProcess::ChildProcess(const std::filesystem::path& program, std::chrono::milliseconds patience,
                           std::stop_token stop)
    : name_(program.filename().string()),
      deadline_(Clock::now() + patience),
      stop_(std::move(stop)),
      onStop_(stop_, std::ref(wakeUp_)) {
  if (wakeUp_.descriptor() < 0) {
    failure_ = std::strerror(errno);
  } else {
    start(program);
  }
}

void ChildProcess::start(const std::filesystem::path& program) {
  std::array<int, 2> ends{-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    failure_ = std::strerror(errno);
    return;
  }
  socket_ = ends[0];
  if (const int error = spawn(program, ends[1], child_); error != 0) {
    child_ = 0;
    failure_ = "the program " + program.string() + " does not start: " + std::strerror(error);
  }
  close(ends[1]);
}

ChildProcess::~ChildProcess() {
  if (child_ != 0) {
    wait(std::chrono::milliseconds(0));
  }
  if (socket_ >= 0) close(socket_);
}

int ChildProcess::wait(std::chrono::milliseconds patience) noexcept {
  constexpr std::chrono::milliseconds kLookEvery{5};
  int status = 0;
  pid_t ended = waitpid(child_, &status, WNOHANG);
  for (; ended == 0 && patience.count() > 0; patience -= kLookEvery) {
    std::this_thread::sleep_for(kLookEvery);
    ended = waitpid(child_, &status, WNOHANG);
  }
  if (ended == 0) kill(child_, SIGKILL);
  while (ended == 0 || (ended < 0 && errno == EINTR)) ended = waitpid(child_, &status, 0);
  child_ = 0;
  return status;
}

Result<void> ChildProcess::waitFor(short events) {
  for (;;) {
    if (!failure_.empty()) return refused("", "cannot be read: " + failure_);
    if (stop_.stop_requested()) return refused("", "is not read any more: it was cancelled");
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
    if (left <= 0) return refused("", "cannot be read: " + name_ + " takes too long");
    std::array<pollfd, 2> ready{{{socket_, events, 0}, {wakeUp_.descriptor(), POLLIN, 0}}};
    if (poll(ready.data(), ready.size(), static_cast<int>(left)) > 0 && ready[0].revents != 0) return {};
  }
}

tl::unexpected<Error> ChildProcess::ended() {
  if (child_ == 0) return refused("", "cannot be read: " + name_ + " has ended");
  const int status = wait(kEndsWithin);
  const std::string how = WIFSIGNALED(status) ? std::string("by ") + strsignal(WTERMSIG(status))
                                              : "with code " + std::to_string(WEXITSTATUS(status));
  return refused("", "is damaged: " + name_ + " ends on it " + how);
}

Result<void> ChildProcess::send(const void* bytes, std::size_t size, int descriptor) {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    if (auto ready = waitFor(POLLOUT); !ready) return ready;
    const ssize_t sent = sendWith(socket_, at, size, descriptor);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return ended();
    at += sent;
    size -= static_cast<std::size_t>(sent);
    descriptor = -1;
  }
  return {};
}

Result<void> ChildProcess::receive(void* bytes, std::size_t size) {
  char* at = static_cast<char*>(bytes);
  while (size > 0) {
    if (auto ready = waitFor(POLLIN); !ready) return ready;
    const ssize_t received = recv(socket_, at, size, MSG_DONTWAIT);
    if (received < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (received <= 0) return ended();
    at += received;
    size -= static_cast<std::size_t>(received);
  }
  return {};
}

Result<std::string> ChildProcess::receive(std::size_t size) {
  std::string bytes(size, '\0');
  if (auto received = receive(bytes.data(), size); !received) return tl::unexpected(std::move(received).error());
  return bytes;
}

}  // namespace haptics
