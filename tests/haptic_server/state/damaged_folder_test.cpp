#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <future>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/file_bytes.h"
#include "haptic_server/scene/scene_service.h"
#include "tests/haptic_server/state/kept_scene.h"

// A state folder with random damage: flipped bits, files cut off, grown or gone, a disk that is full or cannot be written. The
// server's scene room starts from it in every case, at the newest revision that the undamaged bytes prove, says what is
// lost, and every object whose files are undamaged is as it was at that revision. Afterwards it goes on: edits are kept,
// or refused with the reason, and a second start finds nothing more to say about the log.
namespace haptics::damaged_folder_test {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr SessionId kEditor = 11;
constexpr std::size_t kCheckpointAfter_bytes = 6000;

/// The system's files, of which nothing can be changed for the reason given.
class UnwritableFiles final : public FileSystem {
 public:
  enum class Why { kNone, kReadOnly, kFull };
  explicit UnwritableFiles(Why why) : why_(why) {}

  Result<std::string> read(const fs::path& path) override { return files_->read(path); }
  Result<OpenFile> open(const fs::path& path) override {
    if (why_ == Why::kReadOnly) return readOnly();
    auto file = files_->open(path);
    if (!file || why_ == Why::kNone) return file;
    return std::make_unique<FullFile>(*std::move(file));
  }
  Result<OpenFile> create(const fs::path& path) override {
    if (why_ == Why::kReadOnly) return readOnly();
    auto file = files_->create(path);
    if (!file || why_ == Why::kNone) return file;
    return std::make_unique<FullFile>(*std::move(file));
  }
  Result<void> rename(const fs::path& from, const fs::path& to) override {
    if (why_ == Why::kReadOnly) return readOnly();
    return files_->rename(from, to);
  }
  Result<void> remove(const fs::path& path) override {
    if (why_ == Why::kReadOnly) return readOnly();
    return files_->remove(path);
  }
  Result<void> allocate(const fs::path& path, std::size_t bytes) override {
    if (why_ != Why::kNone) return readOnly();
    return files_->allocate(path, bytes);
  }
  Result<std::vector<Entry>> list(const fs::path& folder) override { return files_->list(folder); }
  bool isFolder(const fs::path& path) override { return files_->isFolder(path); }
  Result<void> makeFolder(const fs::path& path) override {
    if (why_ != Why::kNone) return readOnly();
    return files_->makeFolder(path);
  }
  Result<void> syncFolder(const fs::path& folder) override { return files_->syncFolder(folder); }
  Result<OpenFile> lock(const fs::path& path) override { return files_->lock(path); }
  std::size_t free_bytes(const fs::path& folder) override {
    return why_ == Why::kNone ? files_->free_bytes(folder) : 0;
  }
  std::int64_t now_s() override { return files_->now_s(); }

 private:
  class FullFile final : public File {
   public:
    explicit FullFile(OpenFile file) : file_(std::move(file)) {}
    Result<void> write(std::string_view, std::size_t) override { return refused("", "No space left on device"); }
    Result<void> truncate(std::size_t size) override { return file_->truncate(size); }
    Result<void> sync() override { return file_->sync(); }

   private:
    OpenFile file_;
  };
  static tl::unexpected<Error> readOnly() { return refused("", "Read-only file system"); }
  Why why_;
  std::shared_ptr<FileSystem> files_ = systemFiles();
};

/// A folder as a server left it, in memory, and what each of its bytes proves.
struct Original {
  std::map<fs::path, std::string> files;                    // by path below the folder
  std::map<std::uint64_t, SceneVersion> versions;           // by revision
  std::vector<std::pair<std::size_t, std::uint64_t>> ends;  // of the log's records, and the revision then
  std::uint64_t epoch = 41;

  [[nodiscard]] std::uint64_t last() const { return versions.rbegin()->first; }
  [[nodiscard]] const std::string& log() const { return files.at("log"); }
  [[nodiscard]] const std::string& copy() const { return files.at("checkpoint"); }

  static Original make() {
    const TemporaryFolder folder;
    Original original;
    {
      KeptScene scene(folder.path(), original.epoch, kCheckpointAfter_bytes);
      original.versions[0] = scene.version();
      std::string before;
      for (std::uint64_t i = 1; i <= 41; ++i) {
        scene.accept(kEditor, i, someEdit(i));
        const std::string copy = readFile(folder / "checkpoint").value();
        if (copy != before) original.ends = {{copy.size(), i - 1}};
        original.ends.emplace_back(fs::file_size(folder / "log"), i);
        before = copy;
        original.versions[i] = scene.version();
      }
    }
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      if (entry.is_regular_file() && entry.file_size() > 0)
        original.files[fs::relative(entry.path(), folder.path())] = readFile(entry.path()).value();
    }
    return original;
  }

  /// The newest revision that undamaged bytes of one file lead to, at least; nothing: none.
  [[nodiscard]] std::optional<std::uint64_t> proven(const std::optional<std::string>& log,
                                                    const std::optional<std::string>& copy) const {
    const bool copyIsWhole = copy && copy->starts_with(this->copy());
    const std::size_t beginning = ends[0].first;
    std::optional<std::uint64_t> newest;
    if (log) {
      const auto sameUpTo = [&](std::size_t from) {
        std::size_t at = from;
        while (at < log->size() && at < this->log().size() && (*log)[at] == this->log()[at]) ++at;
        return at;
      };
      std::size_t good = sameUpTo(0);
      if (good < beginning && copyIsWhole && log->size() >= beginning) good = sameUpTo(beginning);
      for (const auto& [end, revision] : ends) {
        if (end <= good) newest = revision;
      }
    }
    if (copyIsWhole) newest = std::max(newest.value_or(0), ends[0].second);
    return newest;
  }

 private:
  static Transaction someEdit(std::uint64_t i) {
    const std::string name = numbered("o", i % 6);
    if (i < 6) return edit(add(numbered("o", i), box(0.011 * static_cast<double>(i))));
    if (i == 6) return edit(add("o0"));
    if (i == 9) {
      SurfaceEdit surface = spottedSurface();
      surface.stiffnessOver =
          SurfaceMapEdit{SurfaceMap{0.5, MappedFamily{{}, {.tile_m = 0.01}}}, std::vector<FamilySource>{spots(6)}};
      surface.softnessOver = SurfaceMapEdit{SurfaceMap{0, PerVertexScale{}}, sameValues(0.25F)};
      return edit(setSurface(surface, name));
    }
    if (i % 11 == 0) return edit(RemeshObject{named(name), box(0.01 + 0.001 * static_cast<double>(i))});
    return edit(moveTo(name, {static_cast<double>(i), 0, 0}));
  }
};

class Damage {
 public:
  Damage(const Original& original, std::uint64_t seed) : original_(original), files_(original.files), random_(seed) {
    constexpr UnwritableFiles::Why kWhys[] = {UnwritableFiles::Why::kReadOnly, UnwritableFiles::Why::kFull};
    if (random_() % 5 == 0) why = kWhys[random_() % 2];
    const std::size_t count = random_() % 4 == 0 && why != UnwritableFiles::Why::kNone ? 0 : 1 + random_() % 3;
    for (std::size_t i = 0; i < count && !files_.empty(); ++i) damageOne();
  }

  void write(const fs::path& folder) const {
    for (const auto& [name, bytes] : files_) {
      fs::create_directories((folder / name).parent_path());
      std::ofstream(folder / name, std::ios::binary) << bytes;
    }
    if (random_() % 2 == 0) fs::create_directories(folder / "assets");
  }
  [[nodiscard]] std::optional<std::string> bytes(const fs::path& name) const {
    const auto at = files_.find(name);
    return at == files_.end() ? std::nullopt : std::optional(at->second);
  }
  [[nodiscard]] bool isDamaged(const ContentHash& asset) const {
    const fs::path name = fs::path("assets") / asset.hex();
    const auto whole = original_.files.find(name);
    return whole == original_.files.end() || bytes(name) != whole->second;
  }

  UnwritableFiles::Why why = UnwritableFiles::Why::kNone;
  std::string text;

 private:
  const Original& original_;
  std::map<fs::path, std::string> files_;
  mutable std::mt19937_64 random_;

  void damageOne() {
    auto at = files_.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(random_() % files_.size()));
    if (random_() % 2 == 0) at = files_.find(random_() % 3 == 0 ? "checkpoint" : "log");
    if (at == files_.end()) return;
    auto& [name, bytes] = *at;
    const auto offset = [&] { return random_() % std::max<std::size_t>(1, bytes.size()); };
    text += name.string().substr(0, 14) + " of " + std::to_string(bytes.size()) + ": ";
    switch (random_() % 6) {
      case 0: {
        for (std::size_t i = 1 + random_() % 8; i > 0 && !bytes.empty(); --i) {
          const std::size_t bit = offset();
          text += "bit at " + std::to_string(bit) + " ";
          bytes[bit] = static_cast<char>(bytes[bit] ^ 1U << random_() % 8);
        }
        break;
      }
      case 1:
        bytes.resize(offset());
        text += "cut to " + std::to_string(bytes.size());
        break;
      case 2:
        text += "gone";
        files_.erase(at);
        break;
      case 3:
        bytes += std::string(1 + random_() % 5000, '\0');
        text += "zeros behind";
        break;
      case 4:
        for (std::size_t i = 1 + random_() % 400; i > 0; --i) bytes += static_cast<char>(random_());
        text += "anything behind";
        break;
      default: {
        const std::size_t from = offset();
        const std::size_t size = std::min(bytes.size() - from, 1 + random_() % 512);
        bytes.replace(from, size, size, '\0');
        text += "zeros from " + std::to_string(from) + " " + std::to_string(size);
      }
    }
    text += "; ";
  }
};

/// A server's room on a folder.
class Room {
 public:
  Room(const fs::path& folder, std::uint64_t freshEpoch, UnwritableFiles::Why why) {
    const auto note = [this](const std::string& line) { said.push_back(line); };
    auto opened = StateFolder::open(folder, freshEpoch,
                                    {note, note, kCheckpointAfter_bytes, 0, std::make_shared<UnwritableFiles>(why)});
    if (!opened) throw std::runtime_error("does not start: " + opened.error().text());
    folder_ = std::move(opened->folder);
    const auto read = [this](const ContentHash& hash) { return folder_->readAsset(hash); };
    for (const std::string& warning : sceneService_.resume(std::move(opened->state), read, *folder_))
      said.push_back(warning);
  }
  ~Room() { sceneService_.stop(); }

  [[nodiscard]] std::shared_ptr<const SceneHistory> history() const { return sceneService_.history(); }
  EditOutcome submit(std::uint64_t seq, const Transaction& transaction) {
    sceneService_.start();
    std::promise<EditOutcome> outcome;
    if (!sceneService_.submitEdit(kEditor + 1, seq, transaction,
                                  [&](const EditOutcome& its) { outcome.set_value(its); }))
      throw std::runtime_error("no room");
    return outcome.get_future().get();
  }
  [[nodiscard]] std::string words() const {
    std::string text;
    for (const std::string& line : said) text += "\n  " + line;
    return text;
  }

  std::vector<std::string> said;

 private:
  std::unique_ptr<StateFolder> folder_;
  SceneMailbox mailbox_;
  SceneService sceneService_{{}, mailbox_};
};

/// As it was, but for what its damaged files held.
void expectAsItWas(const ObjectRecord& now, const ObjectRecord& was, const Damage& damage) {
  EXPECT_EQ(now.id, was.id);
  EXPECT_EQ(now.name, was.name);
  EXPECT_EQ(now.pose, was.pose);
  EXPECT_EQ(now.material.stiffness_N_per_m, was.material.stiffness_N_per_m);
  if (damage.isDamaged(was.mesh)) {
    EXPECT_NE(now.mesh, was.mesh);
    return;
  }
  EXPECT_EQ(now.mesh, was.mesh);
  const auto whole = [&](const auto& assets) {
    return std::ranges::none_of(assets, [&](const AssetName& asset) { return damage.isDamaged(asset.hash); });
  };
  const auto keeps = [&](auto property) {
    SurfaceProperties alone;
    alone.*property = was.material.surface.*property;
    EXPECT_EQ(now.material.surface.*property == was.material.surface.*property, whole(assetsOf(alone)));
  };
  keeps(&SurfaceProperties::friction);
  keeps(&SurfaceProperties::texture);
  keeps(&SurfaceProperties::stiffnessOver);
  keeps(&SurfaceProperties::softnessOver);
}

void judge(const Original& original, std::uint64_t seed) {
  const Damage damage(original, seed);
  const TemporaryFolder folder;
  damage.write(folder.path());
  const auto proven = original.proven(damage.bytes("log"), damage.bytes("checkpoint"));
  const bool mayWrite = damage.why == UnwritableFiles::Why::kNone;
  ContentHash root;
  std::uint64_t revision = 0;
  {
    Room room(folder.path(), 42, damage.why);
    SCOPED_TRACE(damage.text + room.words());
    const auto history = room.history();
    revision = history->version.revision();
    const auto kept = original.versions.find(revision);
    const bool lostParts = kept == original.versions.end() || kept->second.root() != history->version.root();
    ASSERT_TRUE(!lostParts || original.versions.contains(revision - 1)) << revision;
    const SceneVersion& was = original.versions.at(lostParts ? revision - 1 : revision);
    ASSERT_GE(was.revision(), proven.value_or(0));
    ASSERT_EQ(history->version.objects().size(), was.objects().size());
    for (const auto& object : was.objects()) {
      const auto now = history->version.find(object->id);
      ASSERT_TRUE(now);
      expectAsItWas(*now, *object, damage);
    }
    if (was.revision() < original.last() || lostParts) {
      EXPECT_FALSE(room.said.empty()) << "what is lost must be said";
    }
    if (lostParts) {
      EXPECT_NE(history->epoch, original.epoch);
    }
    if (!mayWrite) {
      const auto refusal = room.submit(1, edit(add("new", box(0.33))));
      ASSERT_TRUE(std::holds_alternative<Error>(refusal));
      EXPECT_EQ(std::get<Error>(refusal).field, "state");
      EXPECT_EQ(room.history()->version.revision(), revision);
      return;
    }
    const auto outcome = room.submit(1, edit(add("new", box(0.33))));
    ASSERT_TRUE(std::holds_alternative<Accepted>(outcome)) << std::get<Error>(outcome).text();
    root = room.history()->version.root();
  }
  const Room again(folder.path(), 43, UnwritableFiles::Why::kNone);
  SCOPED_TRACE(damage.text + again.words());
  EXPECT_EQ(again.history()->version.root(), root);
  EXPECT_NE(again.history()->epoch, 43U);
  for (const std::string& line : again.said) EXPECT_TRUE(line.starts_with("object")) << line;
}

TEST(DamagedFolder, IsStartedFromWhateverItHolds) {
  const char* most = std::getenv("HAPTICS_DAMAGES");
  const char* only = std::getenv("HAPTICS_SEED");
  const std::uint64_t count = most ? std::strtoull(most, nullptr, 10) : 60;
  const std::uint64_t first = only ? std::strtoull(only, nullptr, 10) : 1;
  const Original original = Original::make();
  ASSERT_GT(original.ends[0].second, 0U) << "the checkpoint is to hold something";
  ASSERT_GT(original.ends.size(), 3U);
  for (std::uint64_t seed = first; seed <= (only ? first : count); ++seed) {
    try {
      judge(original, seed);
    } catch (const std::exception& failure) {
      ADD_FAILURE() << failure.what();
    }
    if (::testing::Test::HasFailure()) FAIL() << "HAPTICS_SEED=" << seed;
  }
}

}  // namespace
}  // namespace haptics::damaged_folder_test
