#include "common/importer/gltf_numbers.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

using nlohmann::json;

constexpr std::uint64_t kFloat32 = 5126;
constexpr std::uint64_t kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6;  // modes of a primitive
constexpr std::size_t kGlbHead = 12, kChunkHead = 8;

struct Chunks {
  std::string_view text;
  std::optional<std::uint64_t> binary_bytes;  ///< Of a binary file.
};

std::uint64_t number32(std::string_view bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

Result<Chunks> chunksOf(std::string_view file) {
  if (!file.starts_with("glTF")) return Chunks{file, std::nullopt};
  if (file.size() < kGlbHead + kChunkHead) return refused("", "is a binary glTF that is cut off");
  if (const auto version = number32(file, 4); version != 2) {
    return refused("", "is binary glTF of version " + std::to_string(version) + "; only version 2 is read");
  }
  const std::uint64_t size = number32(file, kGlbHead);
  const std::string_view rest = file.substr(kGlbHead + kChunkHead);
  if (size > rest.size()) return refused("", "is a binary glTF that is cut off");
  const std::string_view after = rest.substr(size);
  return Chunks{rest.substr(0, size), after.size() < kChunkHead ? 0 : after.size() - kChunkHead};
}

int deepestNesting(std::string_view text) {
  int depth = 0, deepest = 0;
  bool isQuoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (isQuoted && c == '\\') {
      ++i;
    } else if (c == '"') {
      isQuoted = !isQuoted;
    } else if (!isQuoted && (c == '[' || c == '{')) {
      deepest = std::max(deepest, ++depth);
    } else if (!isQuoted && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return deepest;
}

/// The member, where it is a whole number from 0; else `instead`.
std::uint64_t numberIn(const json& object, const char* key, std::uint64_t instead) {
  const auto at = object.is_object() ? object.find(key) : object.end();
  return at != object.end() && at->is_number_unsigned() ? at->get<std::uint64_t>() : instead;
}

/// Element of a list that is a member; null where it is not there.
const json& itemIn(const json& object, const char* key, std::uint64_t index) {
  static const json nothing;
  const auto at = object.is_object() ? object.find(key) : object.end();
  return at != object.end() && at->is_array() && index < at->size() ? (*at)[index] : nothing;
}
const json& memberIn(const json& object, const char* key) {
  static const json nothing;
  const auto at = object.is_object() ? object.find(key) : object.end();
  return at != object.end() ? *at : nothing;
}

constexpr std::uint64_t kNone = ~std::uint64_t{0};

class Checker {
 public:
  Checker(const json& root, std::optional<std::uint64_t> binary_bytes, std::uint64_t mostOfNothing)
      : root_(root), binary_bytes_(binary_bytes), mostOfNothing_(mostOfNothing) {}

  Result<GltfTriangles> run() {
    if (auto ok = extensions(); !ok) return tl::unexpected(std::move(ok).error());
    const auto meshes = meshesOfScene();
    if (!meshes) return tl::unexpected(meshes.error());
    std::uint64_t triangles = 0;
    bool isKnown = true;
    for (const std::uint64_t mesh : *meshes) {
      for (const json& primitive : memberIn(itemIn(root_, "meshes", mesh), "primitives")) {
        const std::uint64_t positions = numberIn(memberIn(primitive, "attributes"), "POSITION", kNone);
        const std::uint64_t indices = numberIn(primitive, "indices", kNone);
        if (auto ok = accessor(positions, true); !ok) return tl::unexpected(std::move(ok).error());
        if (auto ok = accessor(indices, false); !ok) return tl::unexpected(std::move(ok).error());
        const std::uint64_t corners =
            numberIn(itemIn(root_, "accessors", indices != kNone ? indices : positions), "count", 0);
        const std::uint64_t mode = numberIn(primitive, "mode", kTriangles);
        if (mode == kTriangles) triangles += corners / 3;
        if ((mode == kTriangleStrip || mode == kTriangleFan) && corners > 2) triangles += corners - 2;
        isKnown = isKnown && memberIn(primitive, "extensions").is_null();
        if (triangles > mostOfNothing_) {
          return refused("", "makes more than " + std::to_string(mostOfNothing_) + " triangles of the same values");
        }
      }
    }
    return isKnown ? GltfTriangles(triangles) : std::nullopt;
  }

 private:
  const json& root_;
  const std::optional<std::uint64_t> binary_bytes_;
  const std::uint64_t mostOfNothing_;

  [[nodiscard]] Result<void> extensions() const {
    for (const json& name : memberIn(root_, "extensionsRequired")) {
      if (!name.is_string()) continue;
      const auto& text = name.get_ref<const std::string&>();
      const auto has = [&](const char* word) { return text.find(word) != text.npos; };
      if (text == "KHR_draco_mesh_compression" || has("material") || has("technique") || has("texture") ||
          has("light")) {
        continue;
      }
      return refused("", "cannot be read without the extension " + inQuotes(text) +
                             ", which is not known here; export it without that");
    }
    return {};
  }

  /// Of the nodes that the default scene leads to. Refused: nodes that are no tree, or one too deep.
  [[nodiscard]] Result<std::set<std::uint64_t>> meshesOfScene() const {
    std::set<std::uint64_t> nodes, meshes;
    std::vector<const json*> level{&memberIn(itemIn(root_, "scenes", numberIn(root_, "scene", 0)), "nodes")};
    for (int depth = 0; !level.empty(); ++depth) {
      if (depth > kDeepestNesting)
        return refused("", "nests nodes more than " + std::to_string(kDeepestNesting) + " levels deep");
      std::vector<const json*> next;
      for (const json* const list : level) {
        for (const json& item : *list) {
          if (!item.is_number_unsigned()) continue;
          const auto index = item.get<std::uint64_t>();
          const json& node = itemIn(root_, "nodes", index);
          if (!nodes.insert(index).second) {
            return refused("", "node " + std::to_string(index) + " is the child of two, or of itself");
          }
          if (const std::uint64_t mesh = numberIn(node, "mesh", kNone); mesh != kNone) meshes.insert(mesh);
          if (const json& children = memberIn(node, "children"); !children.empty()) next.push_back(&children);
        }
      }
      level = std::move(next);
    }
    return meshes;
  }

  [[nodiscard]] static std::uint64_t bytesOf(const json& accessor) {
    const std::uint64_t type = numberIn(accessor, "componentType", 0);
    const std::uint64_t each = type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : 4;
    return each * (memberIn(accessor, "type") == "VEC3" ? 3 : 1);
  }

  /// What a buffer may hold: what its file has, where that is this one.
  [[nodiscard]] std::uint64_t bytesOfBuffer(std::uint64_t index) const {
    const json& buffer = itemIn(root_, "buffers", index);
    const std::uint64_t claimed = numberIn(buffer, "byteLength", 0);
    const json& uri = memberIn(buffer, "uri");
    if (uri.is_null()) return std::min(claimed, binary_bytes_.value_or(claimed));
    if (!uri.is_string()) return claimed;
    const auto& text = uri.get_ref<const std::string&>();
    return text.starts_with("data:") ? std::min<std::uint64_t>(claimed, text.size()) : claimed;
  }

  [[nodiscard]] Result<void> accessor(std::uint64_t index, bool isOfPositions) const {
    const json& accessor = itemIn(root_, "accessors", index);
    if (accessor.is_null()) return {};
    const std::string name = "accessor " + std::to_string(index);
    if (isOfPositions && numberIn(accessor, "componentType", kFloat32) != kFloat32) {
      return refused("", name + " has positions that are no float32 (quantized), which are not read");
    }
    const std::uint64_t count = numberIn(accessor, "count", 0), element = bytesOf(accessor);
    const json& view = itemIn(root_, "bufferViews", numberIn(accessor, "bufferView", kNone));
    const std::uint64_t stride = std::max(numberIn(view, "byteStride", element), std::uint64_t{1});
    std::uint64_t most = mostOfNothing_;
    if (!view.is_null()) {
      const std::uint64_t buffer_bytes = bytesOfBuffer(numberIn(view, "buffer", 0));
      const std::uint64_t from = numberIn(view, "byteOffset", 0), offset = numberIn(accessor, "byteOffset", 0);
      std::uint64_t view_bytes =
          from > buffer_bytes ? 0 : std::min(numberIn(view, "byteLength", 0), buffer_bytes - from);
      view_bytes -= std::min(offset, view_bytes);
      most = view_bytes < element ? 0 : (view_bytes - element) / stride + 1;
    }
    if (count <= most) return {};
    return refused("",
                   name + " claims " + std::to_string(count) + " values; there are bytes for " + std::to_string(most));
  }
};

}  // namespace

Result<GltfTriangles> checkGltf(std::string_view file, std::uint64_t mostOfNothing) {
  return chunksOf(file).and_then([&](const Chunks& chunks) -> Result<GltfTriangles> {
    if (deepestNesting(chunks.text) > kDeepestNesting) {
      return refused("", "nests more than " + std::to_string(kDeepestNesting) + " levels deep");
    }
    const json root = json::parse(chunks.text, nullptr, false);
    if (!root.is_object()) return refused("", "is no glTF: its JSON is cut off or damaged");
    return Checker(root, chunks.binary_bytes, mostOfNothing).run();
  });
}

}  // namespace haptics
