#include "common/importer/gltf_fields.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/importer/gltf_values.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

using nlohmann::json;

/// As a refusal quotes it.
std::string textOf(const json& value) {
  constexpr std::size_t kMaxSaid = 60;
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() <= kMaxSaid) return printable(text);
  std::size_t end = kMaxSaid;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // between two characters
  return printable(text.substr(0, end)) + "...";
}

tl::unexpected<Error> wrong(const std::string& path, const json& value, const std::string& right) {
  return refused(
      "", value.is_null() ? path + " is missing; it is " + right : path + " is " + textOf(value) + "; it is " + right);
}

std::string at(const char* list, std::uint64_t index) { return std::string(list) + '[' + std::to_string(index) + ']'; }

/// Nothing, or a whole number from 0.
Result<void> wholeNumber(const json& in, const std::string& path, const char* key, bool isNeeded) {
  const json& value = memberIn(in, key);
  if (value.is_number_unsigned() || (value.is_null() && !isNeeded)) return {};
  return wrong(path + '.' + key, value, "a whole number from 0");
}

/// Nothing, or so many numbers.
Result<void> numbers(const json& in, const std::string& path, const char* key, std::size_t count) {
  const json& value = memberIn(in, key);
  const bool isList = value.is_array() && value.size() == count &&
                      std::all_of(value.begin(), value.end(), [](const json& each) { return each.is_number(); });
  if (value.is_null() || isList) return {};
  return wrong(path + '.' + key, value, std::to_string(count) + " numbers");
}

}  // namespace

Result<void> GltfFields::root() const {
  const json& version = memberIn(memberIn(root_, "asset"), "version");
  if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2."))
    return wrong("asset.version", version, "\"2.0\"");
  const json& least = memberIn(memberIn(root_, "asset"), "minVersion");
  if (!least.is_null() && least != "2.0") return wrong("asset.minVersion", least, "\"2.0\" in what is read here");
  for (const char* const list : {"scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"}) {
    const json& value = memberIn(root_, list);
    if (!value.is_null() && !value.is_array()) return wrong(list, value, "a list");
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (!value[i].is_object()) return wrong(at(list, i), value[i], "an object {}");
    }
  }
  if (memberIn(root_, "meshes").empty()) return refused("", "has no meshes: meshes is missing, or an empty list");
  if (auto ok = reference(root_, "", "scene", "scenes"); !ok) return ok;
  const std::uint64_t scene = numberIn(root_, "scene", 0);
  const json& nodes = memberIn(itemIn(root_, "scenes", scene), "nodes");
  if (!nodes.is_null() && !nodes.is_array()) return wrong(at("scenes", scene) + ".nodes", nodes, "a list");
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (auto ok = reference(json{{"nodes", nodes[i]}}, at("scenes", scene), "nodes", "nodes"); !ok) return ok;
  }
  return {};
}

Result<void> GltfFields::reference(const json& in, const std::string& path, const char* key, const char* list) const {
  const json &value = memberIn(in, key), &those = memberIn(root_, list);
  if (value.is_null() || (value.is_number_unsigned() && value.get<std::uint64_t>() < those.size())) return {};
  const std::string count = std::to_string(those.size());
  return wrong(path + (path.empty() ? "" : ".") + key, value,
               std::string("the number of one of the ") + count + ' ' + list + ", from 0");
}

Result<void> GltfFields::node(std::uint64_t index) const {
  const json& node = itemIn(root_, "nodes", index);
  const std::string path = at("nodes", index);
  if (auto ok = reference(node, path, "mesh", "meshes"); !ok) return ok;
  const json& children = memberIn(node, "children");
  if (!children.is_null() && !children.is_array()) return wrong(path + ".children", children, "a list");
  for (const json& child : children) {
    if (auto ok = reference(json{{"children", child}}, path, "children", "nodes"); !ok) return ok;
  }
  for (const auto& [key, count] : {std::pair{"matrix", 16}, {"translation", 3}, {"rotation", 4}, {"scale", 3}}) {
    if (auto ok = numbers(node, path, key, static_cast<std::size_t>(count)); !ok) return ok;
  }
  const json& turn = memberIn(node, "rotation");
  const bool turnsByNothing = std::all_of(turn.begin(), turn.end(), [](const json& each) { return each == 0; });
  if (!turn.is_null() && turnsByNothing) return wrong(path + ".rotation", turn, "a quaternion of length 1");
  return {};
}

Result<void> GltfFields::mesh(std::uint64_t index) {
  const json& primitives = memberIn(itemIn(root_, "meshes", index), "primitives");
  const std::string mesh = at("meshes", index) + ".primitives";
  if (!primitives.is_array()) return wrong(mesh, primitives, "a list");
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const json& primitive = primitives[i];
    const std::string path = mesh + '[' + std::to_string(i) + ']';
    const json& attributes = memberIn(primitive, "attributes");
    if (!attributes.is_object()) return wrong(path + ".attributes", attributes, "an object with POSITION");
    if (const json& mode = memberIn(primitive, "mode"); !mode.is_null() && numberIn(primitive, "mode", kNoIndex) > 6)
      return wrong(path + ".mode", mode, "a whole number from 0 to 6");
    if (auto ok = reference(attributes, path + ".attributes", "POSITION", "accessors"); !ok) return ok;
    if (auto ok = reference(primitive, path, "indices", "accessors"); !ok) return ok;
    for (const bool isOfPositions : {true, false}) {
      const std::uint64_t own =
          numberIn(isOfPositions ? attributes : primitive, isOfPositions ? "POSITION" : "indices", kNoIndex);
      if (own == kNoIndex) continue;
      if (auto ok = accessor(own, isOfPositions); !ok) return ok;
    }
  }
  return {};
}

Result<void> GltfFields::accessor(std::uint64_t index, bool isOfPositions) {
  const json& accessor = itemIn(root_, "accessors", index);
  const std::string path = at("accessors", index);
  for (const auto& [key, isNeeded] : {std::pair{"count", true}, {"componentType", true}, {"byteOffset", false}}) {
    if (auto ok = wholeNumber(accessor, path, key, isNeeded); !ok) return ok;
  }
  const char* const type = isOfPositions ? "VEC3" : "SCALAR";
  if (memberIn(accessor, "type") != type)
    return wrong(path + ".type", memberIn(accessor, "type"), '"' + std::string(type) + '"');
  const std::uint64_t component = numberIn(accessor, "componentType", 0);
  const bool isSigned = component == gltf::kInt8 || component == gltf::kInt16, isReal = component == gltf::kFloat32;
  const bool isWide = component == gltf::kUint32;
  if (gltf::bytesOf(component) == 0 || (isOfPositions ? isWide : isSigned || isReal)) {
    return wrong(path + ".componentType", accessor["componentType"],
                 isOfPositions ? "5126 (float32) for positions, or one of the integers of 8 or 16 bits"
                               : "5121, 5123 or 5125 for indices, integers from 0");
  }
  if (auto ok = reference(accessor, path, "bufferView", "bufferViews"); !ok) return ok;
  const std::uint64_t element = gltf::bytesOf(component) * gltf::componentsOf(accessor);
  if (const std::uint64_t own = numberIn(accessor, "bufferView", kNoIndex); own != kNoIndex) {
    if (auto ok = view(own, element); !ok) return ok;
  }
  const json& sparse = memberIn(accessor, "sparse");
  if (sparse.is_null()) return {};
  for (const auto& [key, size] : {std::pair{"indices", std::uint64_t{1}}, {"values", element}}) {
    const json& part = memberIn(sparse, key);
    const std::string own = path + ".sparse." + key;
    if (!memberIn(part, "bufferView").is_number_unsigned())
      return wrong(own + ".bufferView", memberIn(part, "bufferView"), "the number of a bufferView, from 0");
    if (auto ok = reference(part, own, "bufferView", "bufferViews"); !ok) return ok;
    if (auto ok = view(numberIn(part, "bufferView", 0), size); !ok) return ok;
  }
  return {};
}

Result<void> GltfFields::view(std::uint64_t index, std::uint64_t element_bytes) {
  const json& view = itemIn(root_, "bufferViews", index);
  const std::string path = at("bufferViews", index);
  for (const auto& [key, isNeeded] :
       {std::pair{"buffer", true}, {"byteLength", true}, {"byteOffset", false}, {"byteStride", false}}) {
    if (auto ok = wholeNumber(view, path, key, isNeeded); !ok) return ok;
  }
  const std::uint64_t stride = numberIn(view, "byteStride", 0);
  if (stride > 0 && stride < element_bytes)
    return wrong(path + ".byteStride", view["byteStride"],
                 std::to_string(element_bytes) + " or more, as one value takes");
  if (auto ok = reference(view, path, "buffer", "buffers"); !ok) return ok;
  return buffer(numberIn(view, "buffer", 0));
}

Result<void> GltfFields::buffer(std::uint64_t index) {
  if (!buffers_.insert(index).second) return {};
  const json& buffer = itemIn(root_, "buffers", index);
  const std::string path = at("buffers", index);
  if (auto ok = wholeNumber(buffer, path, "byteLength", true); !ok) return ok;
  const json& uri = memberIn(buffer, "uri");
  if (uri.is_null() && isBinary_ && index == 0) return {};
  for (const char* const packing : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    if (uri.is_string() || memberIn(memberIn(buffer, "extensions"), packing).is_null()) continue;
    return refused("", path + " is packed by " + packing + ", which is not known here; export it without that");
  }
  if (!uri.is_string()) return wrong(path + ".uri", uri, "the name of a file");
  if (!uri.get_ref<const std::string&>().starts_with("data:")) return {};
  const auto bytes = fromDataUri(uri.get_ref<const std::string&>());
  const std::uint64_t length = numberIn(buffer, "byteLength", 0);
  if (!bytes) return refused("", path + ".uri is not base64, as \"data:application/octet-stream;base64,...\" is");
  if (bytes->size() >= length) return {};
  return refused("", path + ".byteLength is " + std::to_string(length) + "; its uri holds " +
                         std::to_string(bytes->size()) + " bytes");
}

void plainGltf(json& value) {
  constexpr double kMax = 9e15;
  if (value.is_structured()) {
    for (json& each : value) plainGltf(each);
    for (auto at = value.begin(); value.is_object() && at != value.end();) at = at->is_null() ? value.erase(at) : ++at;
  } else if (value.is_number_float()) {
    const auto number = value.get<double>();
    if (number >= 0 && number < kMax && number == std::floor(number)) value = static_cast<std::uint64_t>(number);
  }
}

}  // namespace haptics
