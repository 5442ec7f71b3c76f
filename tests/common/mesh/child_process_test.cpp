#include "common/mesh/child_process.h"

#include <thread>
#include <vector>

#include "mesh_files.h"

namespace haptics {
namespace {

using ::testing::HasSubstr;
using std::chrono_literals::operator""s;

using ChildProcess = testing::MeshFiles;

constexpr std::size_t kMegabyte = 1'000'000;

TEST_F(ChildProcess, GivesItsOutput) {
  const std::string content(300'000, 'x');
  EXPECT_EQ(outputOf("/bin/cat", write("content", content), 60s, kMegabyte).value(), content);
}

TEST_F(ChildProcess, CanRunManyTimesAtOnce) {
  const auto file = write("content", "x");
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::array<int, 4> good{};
  for (int& count : good) {
    threads.emplace_back([&] {
      for (int i = 0; i < 10; ++i) count += outputOf("/bin/cat", file, 60s, kMegabyte) == "x" ? 1 : 0;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(good, ::testing::Each(10));
}

TEST_F(ChildProcess, IsKilledWhenItTakesTooLong) {
  EXPECT_THAT(outputOf("/bin/sleep", "600", std::chrono::milliseconds(20), kMegabyte).error().reason,
              HasSubstr("sleep takes too long"));
}

TEST_F(ChildProcess, IsKilledWhenItWritesTooMuch) {
  EXPECT_THAT(outputOf("/bin/cat", "/dev/zero", 60s, kMegabyte).error().reason, HasSubstr("more than can be taken"));
}

TEST_F(ChildProcess, ThatFailsOrDiesOrIsNotThereIsRefused) {
  EXPECT_THAT(outputOf("/bin/cat", folder_ / "missing", 60s, kMegabyte).error().reason, HasSubstr("with code 1"));
  const auto script = write("die", "#!/bin/sh\nkill -SEGV $$\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  EXPECT_THAT(outputOf(script, "", 60s, kMegabyte).error().reason, HasSubstr("die ends on it by Segmentation fault"));
  EXPECT_THAT(outputOf(folder_ / "missing", "", 60s, kMegabyte).error().reason, HasSubstr("does not start"));
}

}  // namespace
}  // namespace haptics
