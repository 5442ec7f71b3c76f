#include "haptic_server/state/state_scrubber.h"

#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <new>
#include <string>
#include <utility>

#include "common/mesh/file_bytes.h"
#include "tests/haptic_server/state/kept_scene.h"

namespace haptics::state_scrubber_test {
namespace {

using namespace test;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr auto kPatience = 20s;  // never reached unless something is broken

class Scrubbed : public ::testing::Test {
 protected:
  Scrubbed() {
    scene.accept(11, 1, edit(add("a"), add("b", box(0.2))));
    for (const auto& object : scene.version().objects()) meshes.push_back(object->mesh);
  }
  void flipByte(const fs::path& file, std::size_t at) {
    std::string bytes = readFile(file).value();
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
  }
  [[nodiscard]] StateScrubber::Options options() {
    return {folder.path(), [this] { return meshes; },
            [this](const fs::path& file, const std::optional<ContentHash>& asset) {
              if (reported++ == 0) found.set_value({file, asset});
              return true;
            },
            1ms, std::size_t(1) << 30};
  }
  /// What is found first.
  std::pair<fs::path, std::optional<ContentHash>> wait() {
    auto future = found.get_future();
    if (future.wait_for(kPatience) != std::future_status::ready) return {};
    return future.get();
  }

  TemporaryFolder folder;
  KeptScene scene{folder.path(), 1};
  std::vector<ContentHash> meshes;
  std::atomic<int> reported = 0;
  std::promise<std::pair<fs::path, std::optional<ContentHash>>> found;
};

TEST_F(Scrubbed, ADamagedAssetIsFound) {
  const StateScrubber scrubber(options());
  flipByte(folder / "assets" / meshes[1].hex(), 40);
  EXPECT_EQ(wait().second, meshes[1]);
}

TEST_F(Scrubbed, AMissingAssetIsFound) {
  fs::remove(folder / "assets" / meshes[0].hex());
  const StateScrubber scrubber(options());
  EXPECT_EQ(wait().second, meshes[0]);
}

TEST_F(Scrubbed, GoesOnAfterAnErrorOfItsOwn) {
  fs::remove(folder / "assets" / meshes[0].hex());
  StateScrubber::Options failingOnce = options();
  failingOnce.assets = [this, failed = false]() mutable {
    if (!std::exchange(failed, true)) throw std::bad_alloc();
    return meshes;
  };
  const StateScrubber scrubber(std::move(failingOnce));
  EXPECT_EQ(wait().second, meshes[0]);
}

TEST_F(Scrubbed, ADamagedLogIsFound) {
  flipByte(folder / "log", fs::file_size(folder / "log") - 10);
  const StateScrubber scrubber(options());
  EXPECT_EQ(wait().first, folder / "log");
}

TEST_F(Scrubbed, ADamagedCheckpointIsFound) {
  flipByte(folder / "checkpoint", 30);
  const StateScrubber scrubber(options());
  EXPECT_EQ(wait().first, folder / "checkpoint");
}

TEST_F(Scrubbed, WhatIsWholeIsNotTold) {
  {
    const StateScrubber scrubber(options());
    for (std::uint64_t i = 2; i <= 200; ++i) scene.accept(11, i, edit(moveTo("a", {double(i), 0, 0})));
  }
  EXPECT_EQ(reported, 0);
}

TEST_F(Scrubbed, WhatIsDamagedIsWrittenAnewFromMemory) {
  const fs::path file = folder / "assets" / meshes[0].hex();
  const std::string whole = readFile(file).value();
  flipByte(file, 40);
  fs::remove(folder / "log");
  scene.distrust(meshes[0]);
  scene.sequencer.checkpoint();
  EXPECT_EQ(readFile(file).value(), whole);
  EXPECT_TRUE(fs::exists(folder / "log"));
}

}  // namespace
}  // namespace haptics::state_scrubber_test
