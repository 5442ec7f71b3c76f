#include "tests/eval/adapters/adapter_process.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>

#include "common/process/spawn.h"
#include "common/text/printable.h"

namespace haptics::eval {
namespace {

// A method that asks for more is ended by its own allocator. Sanitizers reserve more than any machine has.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr const char* kLimit = "";
#else
constexpr const char* kLimit = "ulimit -d 4194304; ";
#endif

bool isLibrary(const std::string& command) {
  return command.ends_with(".so") && (command.find(' ') == std::string::npos || std::filesystem::exists(command));
}

Result<pid_t> start(const std::string& command, int socket) {
  const auto host = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "method_host";
  const std::string script = std::string(kLimit) + (isLibrary(command) ? "exec \"$0\" \"$1\"" : "exec " + command);
  return spawn("/bin/sh", {.arguments = {"-c", script, host.string(), command},
                           .descriptors = {socket, socket, STDERR_FILENO},
                           .ownSession = true});
}

}  // namespace

AdapterProcess::AdapterProcess(const std::string& command) {
  std::array<int, 2> ends;
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw MethodFault("no way to a process can be made");
  const auto started = start(command, ends[1]);
  close(ends[1]);
  socket_ = ends[0];
  if (!started) fail(started.error().text());
  process_ = *started;
}

AdapterProcess::~AdapterProcess() { end(); }

void AdapterProcess::end() {
  if (process_ > 0) {
    kill(-process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = 0;
  }
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
}

void AdapterProcess::fail(const std::string& what) {
  end();
  throw MethodFault(what);
}

std::string AdapterProcess::howItEnded() {
  constexpr int kTries = 100;
  int status = 0;
  for (int i = 0; i < kTries; ++i) {
    if (waitpid(process_, &status, WNOHANG) == process_) {
      kill(-process_, SIGKILL);  // what it started
      process_ = 0;
      if (WIFSIGNALED(status))
        return "crashed by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ')';
      return "ended with exit status " + std::to_string(WEXITSTATUS(status));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return "closed its output";
}

void AdapterProcess::await(short what, Clock::time_point until, const std::string& where) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd ready{socket_, what, 0};
    const int count = left > 0 ? poll(&ready, 1, static_cast<int>(left)) : 0;
    if (count > 0) return;
    if (count == 0) fail("does not answer in time " + where);
    if (errno != EINTR) fail("cannot be waited for " + where);
  }
}

void AdapterProcess::send(std::string_view bytes, Clock::time_point until, const std::string& where) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EAGAIN) {
      await(POLLOUT, until, where);
    } else if (errno != EINTR) {
      fail(howItEnded() + ' ' + where);
    }
  }
}

void AdapterProcess::receive(std::size_t count, Clock::time_point until, const std::string& where) {
  std::array<char, 1024> part;
  while (bytes_.size() < count) {
    const ssize_t got = recv(socket_, part.data(), std::min(part.size(), count - bytes_.size()), MSG_DONTWAIT);
    if (got > 0) {
      bytes_.append(part.data(), static_cast<std::size_t>(got));
    } else if (got < 0 && errno == EAGAIN) {
      await(POLLIN, until, where);
    } else if (got == 0 || errno != EINTR) {
      fail(howItEnded() + ' ' + where);
    }
  }
}

std::string_view AdapterProcess::ask(adapter::Kind kind, std::string_view message, std::chrono::milliseconds limit,
                                     const std::string& where) {
  using adapter::Head;
  if (process_ == 0) throw MethodFault("is not there any more " + where);
  const auto until = Clock::now() + limit;
  const Head asked{kind, static_cast<std::uint32_t>(message.size())};
  bytes_.assign(reinterpret_cast<const char*>(&asked), sizeof asked);
  bytes_ += message;
  send(bytes_, until, where);
  bytes_.clear();
  receive(sizeof(Head), until, where);
  Head head;
  std::memcpy(&head, bytes_.data(), sizeof head);
  if ((head.kind != kind && head.kind != adapter::Kind::kRefusal) || head.bytes > adapter::kMaxAnswer_bytes)
    fail("answers what is no message " + where + "; standard output is for messages only");
  receive(sizeof head + head.bytes, until, where);
  const std::string_view said = std::string_view(bytes_).substr(sizeof head);
  if (head.kind == adapter::Kind::kRefusal) fail("refuses " + where + ": " + printable(said));
  return said;
}

}  // namespace haptics::eval
