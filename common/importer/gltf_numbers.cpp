#include "common/importer/gltf_numbers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/importer/gltf_fields.h"
#include "common/importer/gltf_pose.h"
#include "common/importer/gltf_values.h"
#include "common/importer/xml_text.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

using nlohmann::json;

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
  if (file.substr(kGlbHead + 4, 4) != "JSON") return refused("", "is a binary glTF whose first chunk is not \"JSON\"");
  const std::uint64_t size = number32(file, kGlbHead);
  const std::string_view rest = file.substr(kGlbHead + kChunkHead);
  if (size > rest.size()) return refused("", "is a binary glTF that is cut off");
  Chunks chunks{rest.substr(0, size), {}};
  for (std::string_view left = rest.substr(size); left.size() >= kChunkHead && !chunks.binary;) {
    const std::string_view content = left.substr(kChunkHead);
    const std::string_view own = content.substr(0, std::min<std::uint64_t>(number32(left, 0), content.size()));
    if (left.substr(4, 4) == std::string_view("BIN\0", 4)) chunks.binary = own;
    left = content.substr(own.size());
  }
  return chunks;
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

class Checker {
 public:
  Checker(json& root, std::optional<std::string_view> binary, std::uint64_t mostOfNothing,
          const IncludeReader& readIncluded)
      : root_(root),
        binary_(binary),
        mostOfNothing_(mostOfNothing),
        values_(root, binary, readIncluded),
        fields_(root, binary.has_value()) {}

  Result<Gltf> run() {
    if (auto ok = extensions(); !ok) return tl::unexpected(std::move(ok).error());
    if (auto ok = fields_.root(); !ok) return tl::unexpected(std::move(ok).error());
    const auto shown = meshesOfScene();
    if (!shown) return tl::unexpected(shown.error());
    for (const std::uint64_t mesh : *shown) {
      if (auto ok = fields_.mesh(mesh); !ok) return tl::unexpected(std::move(ok).error());
    }
    if (auto ok = pose(); !ok) return tl::unexpected(std::move(ok).error());
    leaveOut();
    std::uint64_t triangles = 0;
    bool isKnown = true;
    std::set<std::uint64_t> meshes;
    for (const json& node : memberIn(root_, "nodes")) meshes.insert(numberIn(node, "mesh", kNoIndex));
    for (const std::uint64_t mesh : meshes) {
      for (const json& primitive : memberIn(itemIn(root_, "meshes", mesh), "primitives")) {
        const std::uint64_t positions = numberIn(memberIn(primitive, "attributes"), "POSITION", kNoIndex);
        const std::uint64_t indices = numberIn(primitive, "indices", kNoIndex);
        if (auto ok = accessor(positions, "VEC3"); !ok) return tl::unexpected(std::move(ok).error());
        if (auto ok = accessor(indices, "SCALAR"); !ok) return tl::unexpected(std::move(ok).error());
        const std::uint64_t corners =
            numberIn(itemIn(root_, "accessors", indices != kNoIndex ? indices : positions), "count", 0);
        const std::uint64_t mode = numberIn(primitive, "mode", kTriangles);
        if (mode == kTriangles) triangles += (corners + 2) / 3;  // one that is not complete, too
        if ((mode == kTriangleStrip || mode == kTriangleFan) && corners > 2) triangles += corners - 2;
        isKnown = isKnown && memberIn(primitive, "extensions").is_null();
        if (triangles > mostOfNothing_) {
          return refused("", "makes more than " + std::to_string(mostOfNothing_) + " triangles of the same values");
        }
      }
    }
    if (auto ok = dequantize(meshes); !ok) return tl::unexpected(std::move(ok).error());
    const bool hasBuffers = !memberIn(root_, "buffers").empty();
    if (binary_ && hasBuffers && memberIn(root_["buffers"][0], "uri").is_null())
      root_["buffers"][0]["uri"] = kGltfBinary;
    if (!gltf_.positions.empty())
      root_["buffers"].push_back({{"byteLength", gltf_.positions.size()}, {"uri", kGltfPositions}});
    if (isKnown) gltf_.triangles = triangles;
    return std::move(gltf_);
  }

 private:
  json& root_;
  const std::optional<std::string_view> binary_;
  const std::uint64_t mostOfNothing_;
  GltfValues values_;
  GltfFields fields_;
  Gltf gltf_;
  std::vector<std::uint64_t> posed_ = {};  ///< Nodes that are shown, and whose meshes are moved.

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
          if (auto ok = fields_.node(index); !ok) return tl::unexpected(std::move(ok).error());
          if (!nodes.insert(index).second) {
            return refused("", "node " + std::to_string(index) + " is the child of two, or of itself");
          }
          const json& more = memberIn(node, "extensions");
          const bool isHidden =
              isBelowHidden || memberIn(memberIn(more, "KHR_node_visibility"), "visible") == json(false);
          if (isHidden) hidden.insert(index);
          if (const std::uint64_t mesh = numberIn(node, "mesh", kNoIndex); mesh != kNoIndex && !isHidden) {
            meshes.insert(mesh);
            if (isPosed(root_, node)) posed_.push_back(index);
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
    const json& primitives = memberIn(mesh, "primitives");
    const bool hasTargets = std::any_of(primitives.begin(), primitives.end(),
                                        [](const json& each) { return !memberIn(each, "targets").empty(); });
    gltf_.leftOut.morphs += hasTargets && !isPosed(root_, node) ? 1 : 0;
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
      const std::uint64_t mesh = numberIn(nodes[index], "mesh", kNoIndex);
      if (mesh == kNoIndex) continue;
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
    for (const char* const list : {"scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"}) {
      eachIn(list, [](json& item) {
        if (!memberIn(item, "name").is_string()) item.erase("name");
      });
    }
    eachIn("nodes", [](json& node) {
      for (const char* const key : {"skin", "camera", "weights", "extensions"}) node.erase(key);
      makeUnit(node);
    });
    eachIn("buffers", [](json& buffer) {
      if (const json& uri = memberIn(buffer, "uri"); uri.is_string()) buffer["uri"] = plainDataUri(uri);
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

  /// Assimp scales by a quaternion whose length is not 1.
  static void makeUnit(json& node) {
    const json& turn = memberIn(node, "rotation");
    double sum = 0;
    for (const json& each : turn) sum += each.is_number() ? each.get<double>() * each.get<double>() : NAN;
    constexpr double kOfRounding = 1e-6;  // stays as it is
    if (turn.size() != 4 || !(sum > 0) || !std::isfinite(sum) || std::abs(sum - 1) < kOfRounding) return;
    for (json& each : node["rotation"]) each = each.get<double>() / std::sqrt(sum);
  }

  /// In the letters of base64 that Assimp knows (RFC 4648, section 4, not 5), filled up to four.
  static std::string plainDataUri(std::string uri) {
    const std::size_t text = uri.starts_with("data:") ? uri.find(',') : uri.npos;
    if (text == uri.npos) return uri;
    std::replace(uri.begin() + static_cast<std::ptrdiff_t>(text), uri.end(), '-', '+');
    std::replace(uri.begin() + static_cast<std::ptrdiff_t>(text), uri.end(), '_', '/');
    uri.append((4 - (uri.size() - text - 1) % 4) % 4, '=');
    return uri;
  }

  /// KHR_mesh_quantization: positions of integers, which Assimp does not read.
  [[nodiscard]] Result<void> dequantize(const std::set<std::uint64_t>& meshes) {
    std::set<std::uint64_t> quantized;
    for (const std::uint64_t mesh : meshes) {
      for (const json& primitive : memberIn(itemIn(root_, "meshes", mesh), "primitives")) {
        const std::uint64_t index = numberIn(memberIn(primitive, "attributes"), "POSITION", kNoIndex);
        const json& accessor = itemIn(root_, "accessors", index);
        if (memberIn(primitive, "extensions").is_null() &&
            numberIn(accessor, "componentType", gltf::kFloat32) != gltf::kFloat32)
          quantized.insert(index);
      }
    }
    for (const std::uint64_t index : quantized) {
      const auto values = values_.of(index, "VEC3", mostOfNothing_);
      if (!values) return tl::unexpected(values.error());
      std::string bytes;
      for (const double value : *values) {
        const auto number = static_cast<float>(value);
        bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
      }
      root_["accessors"][index] = accessorOf(bytes);
    }
    return {};
  }

  /// Of positions that are added to the file's.
  json accessorOf(const std::string& bytes) {
    constexpr std::size_t kPoint_bytes = 3 * sizeof(float);
    if (!memberIn(root_, "bufferViews").is_array()) root_["bufferViews"] = json::array();
    const std::size_t view = root_["bufferViews"].size(), from = gltf_.positions.size();
    root_["bufferViews"].push_back(
        {{"buffer", memberIn(root_, "buffers").size()}, {"byteOffset", from}, {"byteLength", bytes.size()}});
    gltf_.positions += bytes;
    return {{"bufferView", view},
            {"componentType", gltf::kFloat32},
            {"type", "VEC3"},
            {"count", bytes.size() / kPoint_bytes}};
  }

  /// Gives nodes that are posed meshes of their own; of those with a skin, to a node of the scene.
  [[nodiscard]] Result<void> pose() {
    if (posed_.empty()) return {};
    GltfPose poses(root_, values_, mostOfNothing_);
    for (const std::uint64_t index : posed_) {
      json& node = root_["nodes"][index];
      json mesh = itemIn(root_, "meshes", numberIn(node, "mesh", kNoIndex));
      if (isPacked(mesh)) {
        ++(memberIn(node, "skin").is_null() ? gltf_.leftOut.morphs : gltf_.leftOut.skins);
        continue;
      }
      const auto positions = poses.of(node);
      if (!positions) return tl::unexpected(positions.error());
      json primitives = json::array();
      for (std::size_t i = 0; i < positions->size(); ++i) {
        if ((*positions)[i].empty()) continue;
        primitives.push_back(mesh["primitives"][i]);
        primitives.back()["attributes"] = json{{"POSITION", root_["accessors"].size()}};
        root_["accessors"].push_back(accessorOf((*positions)[i]));
      }
      mesh["primitives"] = std::move(primitives);
      const std::size_t own = root_["meshes"].size();
      root_["meshes"].push_back(std::move(mesh));
      if (memberIn(node, "skin").is_null()) {
        node["mesh"] = own;
        continue;
      }
      json shown{{"mesh", own}};
      if (const json& name = memberIn(node, "name"); !name.is_null()) shown["name"] = name;
      node.erase("mesh");
      root_["scenes"][numberIn(root_, "scene", 0)]["nodes"].push_back(root_["nodes"].size());
      root_["nodes"].push_back(std::move(shown));
    }
    return {};
  }

  /// By Draco, whose points Assimp knows alone.
  static bool isPacked(const json& mesh) {
    const json& primitives = memberIn(mesh, "primitives");
    return std::any_of(primitives.begin(), primitives.end(), [](const json& each) {
      return !memberIn(memberIn(each, "extensions"), "KHR_draco_mesh_compression").is_null();
    });
  }

  /// As Assimp has it: 0 is that of values without a gap.
  [[nodiscard]] static std::uint64_t strideOf(const json& view, std::uint64_t element) {
    const std::uint64_t stride = numberIn(view, "byteStride", 0);
    return stride > 0 ? stride : element;
  }

  /// What a buffer may hold: what its file has, where that is this one.
  [[nodiscard]] std::uint64_t bytesOfBuffer(std::uint64_t index) const {
    if (index == memberIn(root_, "buffers").size()) return gltf_.positions.size();  // which is added at last
    const json& buffer = itemIn(root_, "buffers", index);
    const std::uint64_t claimed = numberIn(buffer, "byteLength", 0);
    const json& uri = memberIn(buffer, "uri");
    if (uri.is_null()) return binary_ ? std::min<std::uint64_t>(claimed, binary_->size()) : claimed;
    if (!uri.is_string()) return claimed;
    const auto& text = uri.get_ref<const std::string&>();
    return text.starts_with("data:") ? std::min<std::uint64_t>(claimed, text.size()) : claimed;
  }

  [[nodiscard]] Result<void> accessor(std::uint64_t index, const char* type) {
    const json& accessor = itemIn(root_, "accessors", index);
    if (accessor.is_null()) return {};
    const std::string name = "accessors[" + std::to_string(index) + "]";
    const std::uint64_t count = numberIn(accessor, "count", 0);
    const std::uint64_t element = gltf::bytesOf(numberIn(accessor, "componentType", 0)) * gltf::componentsOf(accessor);
    const json& view = itemIn(root_, "bufferViews", numberIn(accessor, "bufferView", kNoIndex));
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
    if (count <= most && memberIn(accessor, "sparse").is_null()) return {};
    if (count <= most) return values_.of(index, type, mostOfNothing_).map([](const auto& /*numbers*/) {});
    return refused("",
                   name + " claims " + std::to_string(count) + " values; there are bytes for " + std::to_string(most));
  }
};

/// A file of no scene shows all of its nodes, and one without nodes all of its meshes.
void showAllNodes(json& root) {
  if (memberIn(root, "scenes").size() > 0) return;
  if (memberIn(root, "nodes").empty()) {
    root["nodes"] = json::array();
    for (std::size_t mesh = 0; mesh < memberIn(root, "meshes").size(); ++mesh)
      root["nodes"].push_back(json{{"mesh", mesh}});
  }
  const json& nodes = root["nodes"];
  if (!nodes.is_array()) return;
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
  json root;
  try {
    root = json::parse(chunks->text);
  } catch (const json::parse_error& error) {
    const std::string_view before = chunks->text.substr(0, error.byte);
    const std::string line = std::to_string(1 + std::ranges::count(before, '\n'));
    const bool isCode = std::string_view(error.what()).find("UTF-8") != std::string_view::npos;
    return refused("", "is no glTF: its JSON is " + std::string(isCode ? "not in UTF-8" : "cut off or damaged") +
                           " in line " + line);
  }
  if (!root.is_object()) return refused("", "is no glTF: its JSON is no object {}");
  if (memberIn(root, "meshes").is_object()) {
    const json& version = memberIn(memberIn(root, "asset"), "version");
    const bool isWord = version.is_string() && version.get_ref<const std::string&>().starts_with('1');
    if (isWord || version == 1) return Gltf{.file = std::move(file), .positions = {}, .leftOut = {}};
    return refused("", "is glTF of version " + version.dump() + " (asset.version); \"2.0\" and \"1.0\" are read");
  }
  plainGltf(root);
  if (json& asset = root["asset"]; memberIn(asset, "version") == 2) asset["version"] = "2.0";
  showAllNodes(root);
  auto gltf = Checker(root, chunks->binary, mostOfNothing, readIncluded).run();
  if (!gltf) return gltf;
  gltf->file = root.dump(-1, ' ', false, json::error_handler_t::replace);
  gltf->binary = chunks->binary.value_or("");
  return gltf;
}

}  // namespace haptics
