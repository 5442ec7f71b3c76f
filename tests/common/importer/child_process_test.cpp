#include "common/importer/child_process.h"

#include <thread>
#include <vector>

#include "tests/common/mesh/mesh_files.h"

namespace haptics::child_process_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class ChildProcesses : public fixture::MeshFiles {
 protected:
  /// A program: what /bin/sh is to do.
  std::filesystem::path script(const std::string& name, const std::string& text) const {
    const auto file = write(name, "#!/bin/sh\n" + text + '\n');
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file;
  }
  /// Why four bytes did not come.
  static std::string refusal(const std::filesystem::path& program, std::chrono::milliseconds patience = 60s,
                             std::stop_token stop = {}) {
    ChildProcess child(program, patience, std::move(stop));
    const auto received = child.receive(4);
    return received ? "nothing" : received.error().reason;
  }
};

TEST_F(ChildProcesses, AreTalkedWith) {
  ChildProcess child("/bin/cat", 60s, {});
  const std::string content(30'000, 'x');
  ASSERT_TRUE(child.send(content.data(), content.size()));
  EXPECT_EQ(child.receive(content.size()).value(), content);
}

TEST_F(ChildProcesses, CanBeManyAtOnce) {
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::array<int, 4> good{};
  for (int& count : good) {
    threads.emplace_back([&] {
      for (int i = 0; i < 10; ++i) {
        ChildProcess child("/bin/cat", 60s, {});
        count += child.send("x", 1) && child.receive(1) == "x" ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(good, ::testing::Each(10));
}

TEST_F(ChildProcesses, AreKilledWhenTheyTakeTooLong) {
  EXPECT_THAT(refusal(script("slow", "exec sleep 600"), 20ms), HasSubstr("slow takes too long"));
}

TEST_F(ChildProcesses, AreKilledWhenTheyAreToStop) {
  std::stop_source stop;
  std::jthread later([&] {
    std::this_thread::sleep_for(50ms);
    stop.request_stop();
  });
  EXPECT_THAT(refusal(script("slow", "exec sleep 600"), 60s, stop.get_token()), HasSubstr("cancelled"));
}

TEST_F(ChildProcesses, ThatCloseTheirSocketAndStayAreKilled) {
  EXPECT_THAT(refusal(script("deaf", "exec <&- >&- 2>&-\nexec sleep 600")), HasSubstr("deaf ends on it by Killed"));
}

TEST_F(ChildProcesses, ThatFailOrDieOrAreNotThereAreRefused) {
  EXPECT_THAT(refusal(script("fail", "exit 7")), HasSubstr("with code 7"));
  EXPECT_THAT(refusal(script("die", "kill -SEGV $$")), HasSubstr("die ends on it by Segmentation fault"));
  EXPECT_THAT(refusal(folder_ / "missing"), HasSubstr("does not start"));
}

TEST_F(ChildProcesses, GetNoOtherDescriptors) {
  const auto program = script("count", "set -- /proc/$$/fd/*\nprintf %04d $#");
  std::array<int, 20> others{};
  for (int& other : others) other = dup(STDIN_FILENO);
  ChildProcess child(program, 60s, {});
  EXPECT_LE(std::stoi(child.receive(4).value()), 5) << "socket twice, /dev/null, the script and the folder";
  for (const int other : others) close(other);
}

}  // namespace
}  // namespace haptics::child_process_test
