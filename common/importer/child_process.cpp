#include "common/importer/child_process.h"

#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "common/process/passed_descriptor.h"
#include "common/process/spawn.h"

namespace haptics {
namespace {

/// How long a program may take to end that has closed its end of the socket.
constexpr std::chrono::milliseconds kEndsWithin{1000};

}  // namespace

void ChildProcess::WakeUp::operator()() const noexcept { static_cast<void>(eventfd_write(event.descriptor(), 1)); }

ChildProcess::ChildProcess(const std::filesystem::path& program, std::chrono::milliseconds patience,
                           std::stop_token stop)
    : name_(program.filename().string()),
      deadline_(Clock::now() + patience),
      stop_(std::move(stop)),
      wakeUp_{FileHandle(eventfd(0, EFD_CLOEXEC))},
      onStop_(stop_, std::ref(wakeUp_)) {
  if (!wakeUp_.event) {
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
  socket_ = FileHandle(ends[0]);
  const FileHandle its(ends[1]);
  if (const auto child = spawn(program, {.descriptors = {its.descriptor(), its.descriptor(), -1}})) {
    child_ = *child;
  } else {
    failure_ = "the program " + child.error().text();
  }
}

ChildProcess::~ChildProcess() {
  if (child_ != 0) wait(std::chrono::milliseconds(0));
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
    std::array<pollfd, 2> ready{{{socket_.descriptor(), events, 0}, {wakeUp_.event.descriptor(), POLLIN, 0}}};
    if (poll(ready.data(), ready.size(), static_cast<int>(left)) > 0 && ready[0].revents != 0) return {};
  }
}

tl::unexpected<Error> ChildProcess::ended() {
  if (child_ == 0) return refused("", "cannot be read: " + name_ + " has ended");
  const int status = wait(kEndsWithin);
  const std::string cause = WIFSIGNALED(status) ? std::string("by ") + strsignal(WTERMSIG(status))
                                                : "with code " + std::to_string(WEXITSTATUS(status));
  return refused("", "is damaged: " + name_ + " ends on it " + cause);
}

Result<void> ChildProcess::send(const void* bytes, std::size_t size, int descriptor) {
  const char* at = static_cast<const char*>(bytes);
  while (size > 0) {
    if (auto ready = waitFor(POLLOUT); !ready) return ready;
    const ssize_t sent = sendWith(socket_.descriptor(), at, size, descriptor);
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
    const ssize_t received = recv(socket_.descriptor(), at, size, MSG_DONTWAIT);
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
