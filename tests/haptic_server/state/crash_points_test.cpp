#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/mesh/file_bytes.h"
#include "tests/haptic_server/state/kept_scene.h"

// sys/ptrace.h and linux/ptrace.h cannot both be included: what PTRACE_GET_SYSCALL_INFO tells is declared here.
namespace {
struct SyscallStop {
  std::uint8_t op;
  std::uint8_t pad[3];
  std::uint32_t arch;
  std::uint64_t instructionPointer, stackPointer;
  std::uint64_t number;
  std::uint64_t arguments[6];
};
constexpr std::uint8_t kBeforeCall = 1;
}  // namespace

// A server ends before each of its system calls, one after the other, by a kill (everything written is there) or by a
// loss of power (only what the disk was waited for is there): whatever it had acknowledged is there afterwards, once.
namespace haptics::crash_points_test {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr SessionId kAlice = 11;
constexpr std::uint64_t kEdits = 60;
constexpr std::size_t kCheckpointAfter_bytes = 3000;  // several within the run
constexpr int kMayNotTrace = 77;

/// Moves "a" with each edit and re-meshes it now and then; tells `acknowledged` how far it came.
void editAsAServer(const fs::path& folder, int acknowledged) {
  KeptScene scene(folder, 1, kCheckpointAfter_bytes);
  for (std::uint64_t i = 1; i <= kEdits; ++i) {
    Transaction next = i == 1 ? edit(add("a")) : edit(moveTo("a", {double(i), 0, 0}));
    if (i % 7 == 0) next.operations.emplace_back(RemeshObject{named("a"), box(0.01 * double(i))});
    scene.accept(kAlice, i, next);
    const auto byte = static_cast<char>(i);
    if (write(acknowledged, &byte, 1) != 1) _exit(1);
  }
}

/// A disk that keeps nothing that it was not waited for: names in a folder, bytes in a file.
class Disk {
 public:
  void waitedFor(const fs::path& path) {
    if (fs::is_directory(path)) {
      auto& names = folders_[path] = {};
      for (const auto& entry : fs::directory_iterator(path)) {
        if (entry.is_directory()) {
          named_.insert(entry.path());
        } else {
          names[entry.path().filename()] = inodeOf(entry.path());
        }
      }
    } else {
      files_[inodeOf(path)] = fs::file_size(path) == 0 ? "" : readFile(path).value();
    }
  }
  /// Puts what is on the disk into the place of what the folder holds.
  void restore(const fs::path& folder) const {
    fs::remove_all(folder);
    for (const auto& [path, names] : folders_) {
      if (!named_.contains(path)) continue;
      fs::create_directories(path);
      for (const auto& [name, inode] : names) {
        const auto bytes = files_.find(inode);
        std::ofstream(path / name, std::ios::binary) << (bytes == files_.end() ? "" : bytes->second);
      }
    }
  }

 private:
  std::map<fs::path, std::map<fs::path, ino_t>> folders_;
  std::set<fs::path> named_;  // folders
  std::map<ino_t, std::string> files_;

  static ino_t inodeOf(const fs::path& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) throw std::runtime_error("no " + path.string());
    return status.st_ino;
  }
};

/// The file that the call is about to wait for the disk with.
std::optional<fs::path> syncedFile(pid_t child, const SyscallStop& stop) {
  if (stop.number != SYS_fdatasync && stop.number != SYS_fsync) return std::nullopt;
  return fs::read_symlink("/proc/" + std::to_string(child) + "/fd/" + std::to_string(stop.arguments[0]));
}

struct Outcome {
  bool mayTrace = true;
  bool ended = false;  ///< The child came to its end.
  std::uint64_t acknowledged = 0;
};

/// Runs editAsAServer() in a child that ends before its system call number `calls`. What it waits for is noted in
/// `disk` before the call: no kill falls between.
Outcome editUntilKilled(const fs::path& folder, int calls, Disk& disk) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(kMayNotTrace);
    raise(SIGSTOP);
    try {
      editAsAServer(folder, ends[1]);
    } catch (...) {
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD);
  while (WIFSTOPPED(status)) {
    SyscallStop stop{};
    ptrace(PTRACE_GET_SYSCALL_INFO, child, sizeof stop, &stop);
    if (stop.op == kBeforeCall && calls-- == 0) {
      kill(child, SIGKILL);
    } else {
      if (const auto path = stop.op == kBeforeCall ? syncedFile(child, stop) : std::nullopt) disk.waitedFor(*path);
      ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    }
    waitpid(child, &status, 0);
  }
  close(ends[1]);
  const bool exited = WIFEXITED(status);
  Outcome outcome{!exited || WEXITSTATUS(status) != kMayNotTrace, exited && WEXITSTATUS(status) == 0, 0};
  for (char byte = 0; read(ends[0], &byte, 1) == 1;) outcome.acknowledged = static_cast<std::uint64_t>(byte);
  close(ends[0]);
  EXPECT_TRUE(outcome.ended || !outcome.mayTrace || WIFSIGNALED(status)) << "the child failed";
  return outcome;
}

class CrashPoints : public ::testing::TestWithParam<bool> {};

TEST_P(CrashPoints, WhatWasAcknowledgedIsThereOnce) {
  const bool powerFails = GetParam();
  const TemporaryFolder memory(fs::exists("/dev/shm") ? "/dev/shm" : "/tmp");  // a real disk would take minutes
  int points = 0;
  std::uint64_t unanswered = 0;
  for (bool ended = false; !ended; ++points) {
    const fs::path folder = memory / std::to_string(points);
    Disk disk;
    const Outcome outcome = editUntilKilled(folder, points, disk);
    if (!outcome.mayTrace) GTEST_SKIP() << "no permission to trace a process";
    ended = outcome.ended;
    if (powerFails) disk.restore(folder);

    KeptScene after(folder, 2, kCheckpointAfter_bytes);
    const std::uint64_t revision = after.version().revision();
    ASSERT_GE(revision, outcome.acknowledged) << "lost, at system call " << points;
    ASSERT_LE(revision, outcome.acknowledged + 1) << "at system call " << points;
    unanswered += revision - outcome.acknowledged;
    ASSERT_TRUE(after.said.empty()) << after.said[0];
    if (revision > 1) {
      ASSERT_EQ(after.version().find("a")->pose.position.x, double(revision));
    }
    const std::uint64_t next = outcome.acknowledged + 1;
    const auto again = after.accept(kAlice, next, next == 1 ? edit(add("a")) : edit(moveTo("a", {1, 0, 0})));
    ASSERT_EQ(again->commit.revision, next) << "doubled, at system call " << points;
    fs::remove_all(folder);
  }
  EXPECT_GT(points, 250);
  EXPECT_GT(unanswered, kEdits / 2) << "kills between the disk and the answer";
}

INSTANTIATE_TEST_SUITE_P(By, CrashPoints, ::testing::Bool(),
                         [](const auto& by) { return by.param ? "LossOfPower" : "Kill"; });

}  // namespace
}  // namespace haptics::crash_points_test
