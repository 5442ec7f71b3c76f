#include "common/importer/chunks_3ds.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

namespace haptics {
namespace {

constexpr std::uint16_t kMain = 0x4D4D, kProject = 0xC23D, kEditor = 0x3D3D, kObject = 0x4000, kHidden = 0x4010,
                        kMesh = 0x4100, kUnknown = 0x41FF;
constexpr std::size_t kHead_bytes = 6;

struct Chunk3ds {
  std::uint16_t id;
  std::size_t at, from, end;  ///< Of its head and of what is in it.
};

class Chunks3ds {
 public:
  explicit Chunks3ds(std::string& file) : file_(file) {}

  Result<std::uint64_t> run() {
    const Chunk3ds all = chunkAt(0);
    if (file_.size() < kHead_bytes || (all.id != kMain && all.id != kProject))
      return refused("", "is no 3DS: it does not begin with the bytes 4D 4D");
    walk(all);
    if (!fault_.empty()) return refused("", fault_);
    return hidden_;
  }

 private:
  std::string& file_;
  std::uint64_t hidden_ = 0;
  std::string fault_;

  [[nodiscard]] Chunk3ds chunkAt(std::size_t at) const {
    Chunk3ds chunk{0, at, at + kHead_bytes, at};
    if (file_.size() < at + kHead_bytes) return chunk;
    std::uint32_t size = 0;
    std::memcpy(&chunk.id, file_.data() + at, sizeof chunk.id);
    std::memcpy(&size, file_.data() + at + sizeof chunk.id, sizeof size);
    chunk.end = at + size;
    return chunk;
  }

  /// Calls `take` for each chunk in one.
  template <class Take>
  void eachIn(const Chunk3ds& outer, std::size_t from, const Take& take) {
    const std::size_t end = std::min(outer.end, file_.size());
    for (std::size_t at = from; at + kHead_bytes <= end && fault_.empty();) {
      const Chunk3ds chunk = chunkAt(at);
      if (chunk.end > end || chunk.end < chunk.from) {
        char text[120];
        std::snprintf(text, sizeof text,
                      "is cut off or damaged: the chunk 0x%04X at byte %zu is of %zu bytes; %zu are left", chunk.id, at,
                      chunk.end - at, end - at);
        fault_ = text;
        return;
      }
      take(chunk);
      at = chunk.end;
    }
  }

  void walk(const Chunk3ds& all) {
    eachIn(all, all.from, [&](const Chunk3ds& chunk) {
      if (chunk.id == kMain) walk(chunk);
      if (chunk.id != kEditor) return;
      eachIn(chunk, chunk.from, [&](const Chunk3ds& object) {
        if (object.id == kObject) takeObject(object);
      });
    });
  }

  void takeObject(const Chunk3ds& object) {
    const std::size_t name = file_.find('\0', object.from);
    if (name >= object.end) return;
    bool isHidden = false;
    std::vector<std::size_t> meshes;
    eachIn(object, name + 1, [&](const Chunk3ds& part) {
      isHidden = isHidden || part.id == kHidden;
      if (part.id == kMesh) meshes.push_back(part.at);
      if (part.id == kMesh) eachIn(part, part.from, [](const Chunk3ds&) {});
    });
    if (!isHidden) return;
    hidden_ += meshes.size();
    for (const std::size_t at : meshes) std::memcpy(file_.data() + at, &kUnknown, sizeof kUnknown);
  }
};

}  // namespace

Result<std::uint64_t> checked3ds(std::string& file) { return Chunks3ds(file).run(); }

}  // namespace haptics
