#include "common/importer/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>

namespace haptics::sandbox_test {
namespace {

/// How a process ends that goes into the sandbox and does this there, as waitpid() has it.
int statusOf(const std::function<bool()>& inside) {
  const pid_t child = fork();
  if (child == 0) {
    lowerPriorityAndLimit(60);
    if (!enterSandbox()) _exit(2);
    _exit(inside() ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

bool isKilledBySystemCall(const std::function<bool()>& inside) {
  const int status = statusOf(inside);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS;
}

TEST(Sandbox, LeavesWhatComputingNeeds) {
  EXPECT_EQ(statusOf([] {
              std::string large(64U << 20, 'x');
              std::string larger = large + large;
              return larger.size() == 2 * large.size();
            }),
            0);
}

TEST(Sandbox, OpensNoFile) {
  EXPECT_EQ(statusOf([] { return open("/etc/passwd", O_RDONLY) < 0 && errno == EACCES; }), 0);
}

TEST(Sandbox, EndsWhatDoesAnythingElse) {
  EXPECT_TRUE(isKilledBySystemCall([] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }));
  EXPECT_TRUE(isKilledBySystemCall(
      [] { return mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED; }));
  EXPECT_TRUE(isKilledBySystemCall([] { return fork() >= 0; }));
  EXPECT_TRUE(isKilledBySystemCall([] { return execl("/bin/true", "true", nullptr) == 0; }));
  EXPECT_TRUE(isKilledBySystemCall([] { return kill(getppid(), 0) == 0; }));
  EXPECT_TRUE(isKilledBySystemCall([] { return setpriority(PRIO_PROCESS, 0, -10) == 0; }));
  EXPECT_TRUE(isKilledBySystemCall([] { return unlink("/nowhere") == 0; }));
}

/// Of /proc/self/status, as it is once a process is expendable.
std::map<std::string, std::string> statusLines() {
  std::ifstream file("/proc/self/status");
  std::map<std::string, std::string> lines;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name, value;
    if (words >> name >> value) lines[name] = value;
  }
  return lines;
}

TEST(Sandbox, HasNoPrivilegeAndLittlePriority) {
  const pid_t child = fork();
  if (child == 0) {
    lowerPriorityAndLimit(60);
    auto lines = statusLines();
    rlimit memory{}, files{}, size{};
    getrlimit(RLIMIT_AS, &memory);
    getrlimit(RLIMIT_NOFILE, &files);
    getrlimit(RLIMIT_FSIZE, &size);
    const std::string none(16, '0');
    int wrong = 0;
    if (lines["NoNewPrivs:"] != "1") wrong |= 1;
    for (const char* set : {"CapEff:", "CapPrm:", "CapInh:", "CapAmb:"}) wrong |= lines[set] == none ? 0 : 2;
    if (geteuid() == 0 && lines["CapBnd:"] != none) wrong |= 4;
    if (getpriority(PRIO_PROCESS, 0) <= 0 || sched_getscheduler(0) != SCHED_OTHER) wrong |= 8;
    if (memory.rlim_cur == RLIM_INFINITY) wrong |= 16;
    if (files.rlim_cur > 64 || size.rlim_cur != 0) wrong |= 32;
    _exit(wrong);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "bits as in the test: " << WEXITSTATUS(status);
}

}  // namespace
}  // namespace haptics::sandbox_test
