#include "tests/eval/table1/viewer_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace haptics::eval {

ViewerProcess::ViewerProcess(std::uint16_t port, std::filesystem::path summary) : summary_(std::move(summary)) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "graphics_client";
  if (!std::filesystem::exists(program)) throw std::runtime_error(program.string() + " is missing: build it too");
  const std::string address = "127.0.0.1:" + std::to_string(port);
  std::array<int, 2> ends;
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe to the viewer can be made");
  process_ = fork();
  if (process_ == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    execl(program.c_str(), "graphics_client", "--connect", address.c_str(), "--offscreen", "--summary",
          summary_.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  output_ = ends[0];
}

bool ViewerProcess::holds(std::uint64_t revision, double patience_s) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(patience_s);
  while (held_ < revision) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd ready{output_, POLLIN, 0};
    if (left <= 0 || poll(&ready, 1, static_cast<int>(left)) != 1) return false;
    std::array<char, 512> bytes;
    const ssize_t count = read(output_, bytes.data(), bytes.size());
    if (count <= 0) return false;
    said_.append(bytes.data(), static_cast<std::size_t>(count));
    for (std::size_t end = said_.find('\n'); end != std::string::npos; end = said_.find('\n')) {
      unsigned long long held = 0;
      if (std::sscanf(said_.c_str(), "scene revision %llu", &held) == 1 &&
          said_.substr(0, end).find(" not equal") == std::string::npos) {
        held_ = held;
      }
      said_.erase(0, end + 1);
    }
  }
  return true;
}

double ViewerProcess::finish() {
  if (process_ <= 0) return 0;
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
  process_ = 0;
  std::ifstream file(summary_);
  const auto summary = nlohmann::json::parse(file, nullptr, false);
  return summary.is_object() ? summary.value("fps", 0.0) : 0;
}

ViewerProcess::~ViewerProcess() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  if (output_ >= 0) close(output_);
}

}  // namespace haptics::eval
