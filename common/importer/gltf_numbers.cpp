#include "common/importer/gltf_numbers.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

using nlohmann::json;

constexpr std::uint64_t kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kFloat32 = 5126;
constexpr std::uint64_t kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6;  // modes of a primitive
constexpr std::size_t kGlbHead = 12, kChunkHead = 8;

struct Chunks {
  std::string_view text;
  std::optional<std::string_view> binary;  ///< Of a binary file.
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
  return Chunks{rest.substr(0, size), after.substr(std::min(kChunkHead, after.size()))};
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

/// What base64 says, up to a character that is none of its own.
std::string fromBase64(std::string_view text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t digit = kDigits.find(c);
    if (digit == kDigits.npos) break;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xff);
  }
  return bytes;
}

class Checker {
 public:
  Checker(json& root, std::optional<std::string_view> binary, std::uint64_t mostOfNothing,
          const IncludeReader& readIncluded)
      : root_(root), binary_(binary), mostOfNothing_(mostOfNothing), readIncluded_(readIncluded) {}

  Result<Gltf> run() {
    if (auto ok = extensions(); !ok) return tl::unexpected(std::move(ok).error());
    const auto meshes = meshesOfScene();
    if (!meshes) return tl::unexpected(meshes.error());
    leaveOut();
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
    if (auto ok = dequantize(*meshes); !ok) return tl::unexpected(std::move(ok).error());
    if (isKnown) gltf_.triangles = triangles;
    return std::move(gltf_);
  }

 private:
  json& root_;
  const std::optional<std::string_view> binary_;
  const std::uint64_t mostOfNothing_;
  const IncludeReader& readIncluded_;
  Gltf gltf_;
  std::map<std::string_view, std::string> read_;  ///< By the URI in `root_`.

  [[nodiscard]] Result<void> extensions() const {
    for (const json& name : memberIn(root_, "extensionsRequired")) {
      if (!name.is_string()) continue;
      const auto& text = name.get_ref<const std::string&>();
      const auto has = [&](const char* word) { return text.find(word) != text.npos; };
      if (text == "KHR_draco_mesh_compression" || text == "KHR_mesh_quantization" || text == "KHR_node_visibility" ||
          has("material") || has("technique") || has("texture") || has("light")) {
        continue;
      }
      return refused("", "cannot be read without the extension " + inQuotes(text) +
                             ", which is not known here; export it without that");
    }
    return {};
  }

  /// Of the nodes that the default scene leads to. Refused: nodes that are no tree, or one too deep.
  [[nodiscard]] Result<std::set<std::uint64_t>> meshesOfScene() {
    struct Level {
      const json* nodes;
      bool isHidden;
    };
    std::set<std::uint64_t> nodes, meshes, hidden;
    std::vector<Level> level{{&memberIn(itemIn(root_, "scenes", numberIn(root_, "scene", 0)), "nodes"), false}};
    for (int depth = 0; !level.empty(); ++depth) {
      if (depth > kDeepestNesting)
        return refused("", "nests nodes more than " + std::to_string(kDeepestNesting) + " levels deep");
      std::vector<Level> next;
      for (const auto& [list, isBelowHidden] : level) {
        for (const json& item : *list) {
          if (!item.is_number_unsigned()) continue;
          const auto index = item.get<std::uint64_t>();
          const json& node = itemIn(root_, "nodes", index);
          if (!nodes.insert(index).second) {
            return refused("", "node " + std::to_string(index) + " is the child of two, or of itself");
          }
          const json& more = memberIn(node, "extensions");
          const bool isHidden =
              isBelowHidden || memberIn(memberIn(more, "KHR_node_visibility"), "visible") == json(false);
          if (isHidden) hidden.insert(index);
          if (const std::uint64_t mesh = numberIn(node, "mesh", kNone); mesh != kNone && !isHidden) {
            meshes.insert(mesh);
            count(node, itemIn(root_, "meshes", mesh));
          }
          if (const json& children = memberIn(node, "children"); !children.empty()) {
            next.push_back({&children, isHidden});
          }
        }
      }
      level = std::move(next);
    }
    countUnshown(nodes, hidden);
    return meshes;
  }

  /// What a node that is shown has beside its mesh.
  void count(const json& node, const json& mesh) {
    gltf_.leftOut.skins += memberIn(node, "skin").is_null() ? 0 : 1;
    const json& primitives = memberIn(mesh, "primitives");
    const bool hasTargets = std::any_of(primitives.begin(), primitives.end(),
                                        [](const json& each) { return !memberIn(each, "targets").empty(); });
    gltf_.leftOut.morphs += hasTargets ? 1 : 0;
    const json& instancing = memberIn(memberIn(node, "extensions"), "EXT_mesh_gpu_instancing");
    std::uint64_t copies = 0;
    for (const json& accessor : memberIn(instancing, "attributes")) {
      if (!accessor.is_number_unsigned()) continue;
      copies = std::max(copies, numberIn(itemIn(root_, "accessors", accessor.get<std::uint64_t>()), "count", 0));
    }
    gltf_.leftOut.instances += copies;
  }

  /// Nodes that are not shown lose their meshes.
  void countUnshown(const std::set<std::uint64_t>& reached, const std::set<std::uint64_t>& hidden) {
    std::set<std::uint64_t> placed;
    const json& nodes = memberIn(root_, "nodes");
    for (std::uint64_t index = 0; nodes.is_array() && index < nodes.size(); ++index) {
      const std::uint64_t mesh = numberIn(nodes[index], "mesh", kNone);
      if (mesh == kNone) continue;
      placed.insert(mesh);
      if (reached.contains(index) && !hidden.contains(index)) continue;
      ++gltf_.leftOut.unshown;
      root_["nodes"][index].erase("mesh");
    }
    const json& meshes = memberIn(root_, "meshes");
    for (std::uint64_t mesh = 0; meshes.is_array() && mesh < meshes.size(); ++mesh)
      gltf_.leftOut.unshown += placed.contains(mesh) ? 0 : 1;
  }

  /// What cannot be felt, and primitives of nothing.
  void leaveOut() {
    for (const char* const list : {"materials", "textures", "images", "samplers", "cameras", "skins"})
      root_.erase(list);
    const auto eachIn = [&](const char* list, const auto& take) {
      const auto at = root_.find(list);
      if (at == root_.end() || !at->is_array()) return;
      for (json& item : *at) {
        if (item.is_object()) take(item);
      }
    };
    eachIn("nodes", [](json& node) {
      for (const char* const key : {"skin", "camera", "weights", "extensions"}) node.erase(key);
    });
    eachIn("meshes", [&](json& mesh) {
      mesh.erase("weights");
      const auto primitives = mesh.find("primitives");
      if (primitives == mesh.end() || !primitives->is_array()) return;
      json kept = json::array();
      for (json& primitive : *primitives) {
        const json positions = memberIn(memberIn(primitive, "attributes"), "POSITION");
        if (positions.is_null()) {
          ++gltf_.skipped;
          continue;
        }
        primitive["attributes"] = json::object({{"POSITION", positions}});
        primitive.erase("material");
        primitive.erase("targets");
        json packed = memberIn(memberIn(primitive, "extensions"), "KHR_draco_mesh_compression");
        primitive.erase("extensions");
        if (packed.is_object()) {
          packed["attributes"] = json::object({{"POSITION", memberIn(memberIn(packed, "attributes"), "POSITION")}});
          primitive["extensions"]["KHR_draco_mesh_compression"] = std::move(packed);
        }
        kept.push_back(std::move(primitive));
      }
      *primitives = std::move(kept);
    });
  }

  /// KHR_mesh_quantization: positions of integers, which Assimp does not read.
  [[nodiscard]] Result<void> dequantize(const std::set<std::uint64_t>& meshes) {
    std::set<std::uint64_t> quantized;
    for (const std::uint64_t mesh : meshes) {
      for (const json& primitive : memberIn(itemIn(root_, "meshes", mesh), "primitives")) {
        const std::uint64_t index = numberIn(memberIn(primitive, "attributes"), "POSITION", kNone);
        const json& accessor = itemIn(root_, "accessors", index);
        if (memberIn(primitive, "extensions").is_null() && numberIn(accessor, "componentType", kFloat32) != kFloat32)
          quantized.insert(index);
      }
    }
    if (quantized.empty()) return {};
    const auto isList = [&](const char* key) { return memberIn(root_, key).is_array(); };
    if (!isList("buffers") || !isList("bufferViews")) return refused("", "has accessors of no buffer");
    const std::size_t buffer = root_["buffers"].size();
    for (const std::uint64_t index : quantized) {
      json& accessor = root_["accessors"][index];
      const json& view = itemIn(root_, "bufferViews", numberIn(accessor, "bufferView", kNone));
      if (view.is_null() || !memberIn(accessor, "sparse").is_null()) {
        return refused("", "accessor " + std::to_string(index) +
                               " has quantized positions that are sparse, or of no bytes; export them as float32");
      }
      const auto bytes = bytesIn(numberIn(view, "buffer", 0));
      if (!bytes) return tl::unexpected(bytes.error());
      const std::size_t from = gltf_.positions.size();
      const std::string_view all = *bytes;
      const std::uint64_t at = numberIn(view, "byteOffset", 0) + numberIn(accessor, "byteOffset", 0);
      const std::uint64_t element = bytesOf(accessor), stride = strideOf(view, element);
      const std::uint64_t count = numberIn(accessor, "count", 0);
      if (count > 0 && at + (count - 1) * stride + element > all.size()) {
        return refused("", "accessor " + std::to_string(index) + " is of more bytes than its buffer has");
      }
      for (std::uint64_t i = 0; i < count; ++i) appendFloats(accessor, all.substr(at + i * stride, element));
      const std::size_t size = gltf_.positions.size() - from;
      accessor["componentType"] = kFloat32;
      accessor["bufferView"] = root_["bufferViews"].size();
      for (const char* const key : {"byteOffset", "normalized", "min", "max"}) accessor.erase(key);
      root_["bufferViews"].push_back({{"buffer", buffer}, {"byteOffset", from}, {"byteLength", size}});
    }
    root_["buffers"].push_back({{"byteLength", gltf_.positions.size()}, {"uri", kGltfPositions}});
    return {};
  }

  void appendFloats(const json& accessor, std::string_view element) {
    const std::uint64_t type = numberIn(accessor, "componentType", 0);
    const bool isWide = type == kInt16 || type == kUint16, isSigned = type == kInt8 || type == kInt16;
    const int bits = isWide ? 16 : 8, size = isWide ? 2 : 1;
    const bool isNormalized = memberIn(accessor, "normalized") == json(true);
    const double most = isSigned ? (1 << (bits - 1)) - 1 : (1 << bits) - 1;
    for (int i = 0; i < 3; ++i) {
      int value = static_cast<unsigned char>(element[i * size]);
      if (isWide) value |= static_cast<unsigned char>(element[i * size + 1]) << 8;
      if (isSigned && value >= 1 << (bits - 1)) value -= 1 << bits;
      const auto number = static_cast<float>(isNormalized ? std::max(value / most, -1.0) : value);
      gltf_.positions.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
  }

  [[nodiscard]] Result<std::string_view> bytesIn(std::uint64_t index) {
    const json& uri = memberIn(itemIn(root_, "buffers", index), "uri");
    if (!uri.is_string()) return binary_.value_or("");
    const auto& text = uri.get_ref<const std::string&>();
    if (const auto at = read_.find(text); at != read_.end()) return at->second;
    std::optional<std::string> bytes;
    if (text.starts_with("data:")) {
      bytes = fromBase64(std::string_view(text).substr(text.find(',') + 1));
    } else {
      bytes = readIncluded_(withoutPercents(text));
    }
    if (!bytes) return refused("", "names the file " + inQuotes(text) + ", which is not in its folder or below");
    return read_.emplace(text, *std::move(bytes)).first->second;
  }

  /// As Assimp has it: 0 is that of values without a gap.
  [[nodiscard]] static std::uint64_t strideOf(const json& view, std::uint64_t element) {
    const std::uint64_t stride = numberIn(view, "byteStride", 0);
    return stride > 0 ? stride : element;
  }

  [[nodiscard]] static std::uint64_t bytesOf(const json& accessor) {
    const std::uint64_t type = numberIn(accessor, "componentType", 0);
    const std::uint64_t each = type == kInt8 || type == kUint8 ? 1 : type == kInt16 || type == kUint16 ? 2 : 4;
    return each * (memberIn(accessor, "type") == "VEC3" ? 3 : 1);
  }

  /// What a buffer may hold: what its file has, where that is this one.
  [[nodiscard]] std::uint64_t bytesOfBuffer(std::uint64_t index) const {
    const json& buffer = itemIn(root_, "buffers", index);
    const std::uint64_t claimed = numberIn(buffer, "byteLength", 0);
    const json& uri = memberIn(buffer, "uri");
    if (uri.is_null()) return binary_ ? std::min<std::uint64_t>(claimed, binary_->size()) : claimed;
    if (!uri.is_string()) return claimed;
    const auto& text = uri.get_ref<const std::string&>();
    return text.starts_with("data:") ? std::min<std::uint64_t>(claimed, text.size()) : claimed;
  }

  [[nodiscard]] Result<void> accessor(std::uint64_t index, bool isOfPositions) const {
    const json& accessor = itemIn(root_, "accessors", index);
    if (accessor.is_null()) return {};
    const std::string name = "accessor " + std::to_string(index);
    const std::uint64_t type = numberIn(accessor, "componentType", kFloat32);
    if (isOfPositions && type != kFloat32 && !(type >= kInt8 && type <= kUint16)) {
      return refused("", name + " has positions of component type " + std::to_string(type) +
                             "; they are float32, or integers of 8 or 16 bits");
    }
    if (isOfPositions && memberIn(accessor, "type") != "VEC3")
      return refused("", name + " has positions whose type is not \"VEC3\"");
    const std::uint64_t count = numberIn(accessor, "count", 0), element = bytesOf(accessor);
    const json& view = itemIn(root_, "bufferViews", numberIn(accessor, "bufferView", kNone));
    const std::uint64_t stride = strideOf(view, element);
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

/// A file of no scene shows all of its nodes.
void showAllNodes(json& root) {
  const json& nodes = memberIn(root, "nodes");
  if (memberIn(root, "scenes").size() > 0 || !nodes.is_array()) return;
  std::vector<bool> isChild(nodes.size(), false);
  for (const json& node : nodes) {
    for (const json& child : memberIn(node, "children")) {
      if (child.is_number_unsigned() && child.get<std::uint64_t>() < isChild.size())
        isChild[child.get<std::uint64_t>()] = true;
    }
  }
  json roots = json::array();
  for (std::size_t i = 0; i < isChild.size(); ++i) {
    if (!isChild[i]) roots.push_back(i);
  }
  root["scenes"] = json::array({json{{"nodes", std::move(roots)}}});
  root.erase("scene");
}

}  // namespace

std::string withoutPercents(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned char c = 0;
    const char* const end = uri.data() + std::min(i + 3, uri.size());
    if (uri[i] == '%' && std::from_chars(uri.data() + i + 1, end, c, 16).ptr == uri.data() + i + 3) {
      name += static_cast<char>(c);
      i += 2;
    } else {
      name += uri[i];
    }
  }
  return name;
}

Result<Gltf> preparedGltf(std::string file, std::uint64_t mostOfNothing, const IncludeReader& readIncluded) {
  if (file.starts_with("\xef\xbb\xbf")) file.erase(0, 3);
  const auto chunks = chunksOf(file);
  if (!chunks) return tl::unexpected(chunks.error());
  if (deepestNesting(chunks->text) > kDeepestNesting) {
    return refused("", "nests more than " + std::to_string(kDeepestNesting) + " levels deep");
  }
  json root = json::parse(chunks->text, nullptr, false);
  if (!root.is_object()) return refused("", "is no glTF: its JSON is cut off or damaged");
  if (memberIn(root, "meshes").is_object())
    return Gltf{.file = std::move(file), .positions = {}, .leftOut = {}};  // of version 1
  showAllNodes(root);
  auto gltf = Checker(root, chunks->binary, mostOfNothing, readIncluded).run();
  if (!gltf) return gltf;
  std::string text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  if (!chunks->binary) {
    gltf->file = std::move(text);
    return gltf;
  }
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::string_view after =
      std::string_view(file).substr(static_cast<std::size_t>(chunks->text.data() + chunks->text.size() - file.data()));
  const auto put = [&](std::size_t number) {
    const auto value = static_cast<std::uint32_t>(number);
    gltf->file.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  gltf->file.assign(file, 0, 8);
  put(kGlbHead + kChunkHead + text.size() + after.size());
  put(text.size());
  gltf->file.append(file, kGlbHead + 4, 4).append(text).append(after);
  return gltf;
}

}  // namespace haptics
