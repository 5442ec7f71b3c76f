#include "tests/eval/instructions.h"

#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace haptics::eval {
namespace {

/// The child stops itself before and after the work.
std::optional<double> countWithMarkers(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    raise(SIGSTOP);
    work();
    raise(SIGSTOP);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFSTOPPED(status)) return std::nullopt;
  double steps = 0;
  do {
    if (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) != 0) break;
    if (waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) return std::nullopt;
    ++steps;
  } while (WSTOPSIG(status) == SIGTRAP);
  const bool whole = WSTOPSIG(status) == SIGSTOP;
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return whole ? std::optional(steps) : std::nullopt;
}

}  // namespace

std::optional<double> countInstructions(const std::function<void()>& work) {
  const auto nothing = countWithMarkers([] {});
  const auto all = nothing ? countWithMarkers(work) : std::nullopt;
  if (!all) return std::nullopt;
  return *all - *nothing;
}

}  // namespace haptics::eval
