#include "tests/eval/figure/virtual_display.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>

namespace haptics::eval {
namespace {

constexpr int kPatience_ms = 20'000;

/// Xvfb chooses a free display and writes its number into the pipe.
pid_t startXvfb(int pipeEnd) {
  const pid_t child = fork();
  if (child != 0) return child;
  const std::string fd = std::to_string(pipeEnd);
  const int null = open("/dev/null", O_RDWR);
  for (const int out : {STDOUT_FILENO, STDERR_FILENO}) dup2(null, out);
  execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "1280x1024x24", "-nolisten", "tcp",
         static_cast<char*>(nullptr));
  _exit(127);
}

std::string numberFrom(int pipeEnd) {
  std::string number;
  pollfd ready{pipeEnd, POLLIN, 0};
  std::array<char, 16> bytes;
  while (number.find('\n') == std::string::npos && poll(&ready, 1, kPatience_ms) == 1) {
    const ssize_t count = read(pipeEnd, bytes.data(), bytes.size());
    if (count <= 0) break;
    number.append(bytes.data(), static_cast<std::size_t>(count));
  }
  return number.substr(0, number.find('\n'));
}

}  // namespace

Result<std::unique_ptr<VirtualDisplay>> VirtualDisplay::ensure() {
  // Mesa's software renderer takes every core unless told otherwise.
  setenv("LP_NUM_THREADS", "1", 0);
  if (const char* name = std::getenv("DISPLAY"); name && *name) {
    return std::unique_ptr<VirtualDisplay>(new VirtualDisplay(0));
  }
  std::array<int, 2> ends;
  if (pipe(ends.data()) != 0) return refused("", "no pipe can be made");
  fcntl(ends[0], F_SETFD, FD_CLOEXEC);
  std::unique_ptr<VirtualDisplay> display(new VirtualDisplay(startXvfb(ends[1])));
  close(ends[1]);
  const std::string number = numberFrom(ends[0]);
  close(ends[0]);
  if (number.empty()) {
    return refused("DISPLAY", "is not set, and Xvfb cannot be started to draw without one: install xvfb");
  }
  setenv("DISPLAY", (":" + number).c_str(), 1);
  return display;
}

VirtualDisplay::~VirtualDisplay() {
  if (server_ <= 0) return;
  unsetenv("DISPLAY");
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

}  // namespace haptics::eval
