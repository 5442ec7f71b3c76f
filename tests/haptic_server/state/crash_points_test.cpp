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
#include <utility>

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
  /// Writes what is on the disk of `folder`.
  void writeTo(const fs::path& copy, const fs::path& folder) const {
    for (const auto& [path, names] : folders_) {
      if (!named_.contains(path)) continue;
      const fs::path to = copy / path.lexically_relative(folder);
      fs::create_directories(to);
      for (const auto& [name, inode] : names) {
        const auto bytes = files_.find(inode);
        std::ofstream(to / name, std::ios::binary) << (bytes == files_.end() ? "" : bytes->second);
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

/// The file that a call is about to wait for the disk with.
std::optional<fs::path> syncedFile(pid_t child, const SyscallStop& stop) {
  if (stop.number != SYS_fdatasync && stop.number != SYS_fsync) return std::nullopt;
  return fs::read_symlink("/proc/" + std::to_string(child) + "/fd/" + std::to_string(stop.arguments[0]));
}

/// Runs editAsAServer() in a child, and stops it before each of its system calls.
class StoppedServer {
 public:
  explicit StoppedServer(const fs::path& folder) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ == 0) {
      if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(kMayNotTrace);
      raise(SIGSTOP);
      try {
        editAsAServer(folder, ends[1]);
      } catch (...) {
        _exit(1);
      }
      _exit(0);
    }
    close(ends[1]);
    acknowledgements_ = ends[0];
    waitpid(child_, &status_, 0);
    if (WIFSTOPPED(status_)) ptrace(PTRACE_SETOPTIONS, child_, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);
  }
  StoppedServer(const StoppedServer&) = delete;
  StoppedServer& operator=(const StoppedServer&) = delete;
  ~StoppedServer() {
    if (WIFSTOPPED(status_)) kill(child_, SIGKILL), waitpid(child_, &status_, 0);
    close(acknowledgements_);
  }

  [[nodiscard]] bool mayTrace() const { return !WIFEXITED(status_) || WEXITSTATUS(status_) != kMayNotTrace; }
  [[nodiscard]] bool ended() const { return WIFEXITED(status_) && WEXITSTATUS(status_) == 0; }

  /// To before its next system call, or to its end: false. What a call waits for the disk with is noted in `disk` before it.
  bool continueToCall(Disk& disk) {
    while (WIFSTOPPED(status_)) {
      if (synced_) disk.waitedFor(*std::exchange(synced_, std::nullopt));
      ptrace(PTRACE_SYSCALL, child_, nullptr, nullptr);
      waitpid(child_, &status_, 0);
      SyscallStop stop{};
      if (!WIFSTOPPED(status_) || ptrace(PTRACE_GET_SYSCALL_INFO, child_, sizeof stop, &stop) < 0) continue;
      if (stop.op != kBeforeCall) continue;
      synced_ = syncedFile(child_, stop);
      return true;
    }
    return false;
  }

  /// The number of the last edit that it has answered.
  std::uint64_t acknowledged() {
    for (char byte = 0; read(acknowledgements_, &byte, 1) == 1;) acknowledged_ = static_cast<std::uint64_t>(byte);
    return acknowledged_;
  }

 private:
  pid_t child_ = 0;
  int status_ = 0, acknowledgements_ = -1;
  std::optional<fs::path> synced_;  // by the call that comes
  std::uint64_t acknowledged_ = 0;
};

class CrashPoints : public ::testing::TestWithParam<bool> {};

TEST_P(CrashPoints, WhatWasAcknowledgedIsThereOnce) {
  const bool powerFails = GetParam();
  const TemporaryFolder memory(fs::exists("/dev/shm") ? "/dev/shm" : "/tmp");  // a real disk would take minutes
  const fs::path folder = memory / "folder", copy = memory / "copy";
  Disk disk;
  StoppedServer server(folder);
  if (!server.mayTrace()) GTEST_SKIP() << "no permission to trace a process";
  int points = 0;
  std::uint64_t unanswered = 0;
  for (; server.continueToCall(disk); ++points) {
    const std::uint64_t acknowledged = server.acknowledged();
    if (powerFails) {
      disk.writeTo(copy, folder);
    } else if (fs::exists(folder)) {
      fs::copy(folder, copy, fs::copy_options::recursive);
    }
    KeptScene after(copy, 2, kCheckpointAfter_bytes);
    const std::uint64_t revision = after.version().revision();
    ASSERT_GE(revision, acknowledged) << "lost, at system call " << points;
    ASSERT_LE(revision, acknowledged + 1) << "at system call " << points;
    unanswered += revision - acknowledged;
    ASSERT_TRUE(after.said.empty()) << after.said[0];
    if (revision > 1) {
      ASSERT_EQ(after.version().find("a")->pose.position.x, double(revision));
    }
    const std::uint64_t next = acknowledged + 1;
    const auto again = after.accept(kAlice, next, next == 1 ? edit(add("a")) : edit(moveTo("a", {1, 0, 0})));
    ASSERT_EQ(again->commit.revision, next) << "doubled, at system call " << points;
    fs::remove_all(copy);
  }
  EXPECT_TRUE(server.ended()) << "the child failed";
  EXPECT_GT(points, 250);
  EXPECT_GT(unanswered, kEdits / 2) << "kills between the disk and the answer";
}

INSTANTIATE_TEST_SUITE_P(By, CrashPoints, ::testing::Bool(),
                         [](const auto& by) { return by.param ? "LossOfPower" : "Kill"; });

}  // namespace
}  // namespace haptics::crash_points_test
