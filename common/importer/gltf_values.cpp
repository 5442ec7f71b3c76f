#include "common/importer/gltf_values.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/importer/gltf_numbers.h"
#include "common/mesh/text_scan.h"

namespace haptics {
namespace {

using nlohmann::json;

template <class T>
double valueAt(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double componentAt(const char* bytes, std::uint64_t type) {
  switch (type) {
    case gltf::kInt8:
      return valueAt<std::int8_t>(bytes);
    case gltf::kUint8:
      return valueAt<std::uint8_t>(bytes);
    case gltf::kInt16:
      return valueAt<std::int16_t>(bytes);
    case gltf::kUint16:
      return valueAt<std::uint16_t>(bytes);
    case gltf::kUint32:
      return valueAt<std::uint32_t>(bytes);
    default:
      return valueAt<float>(bytes);
  }
}

/// What a normalized 1 is stored as.
double oneOf(std::uint64_t type) {
  switch (type) {
    case gltf::kInt8:
      return 127;
    case gltf::kUint8:
      return 255;
    case gltf::kInt16:
      return 32767;
    case gltf::kUint16:
      return 65535;
    default:
      return 1;
  }
}

}  // namespace

std::uint64_t numberIn(const json& object, const char* key, std::uint64_t instead) {
  const auto at = object.is_object() ? object.find(key) : object.end();
  return at != object.end() && at->is_number_unsigned() ? at->get<std::uint64_t>() : instead;
}

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

std::uint64_t gltf::bytesOf(std::uint64_t componentType) {
  if (componentType == kInt8 || componentType == kUint8) return 1;
  if (componentType == kInt16 || componentType == kUint16) return 2;
  return componentType == kUint32 || componentType == kFloat32 ? 4 : 0;
}

std::uint64_t gltf::componentsOf(const json& accessor) {
  const json& type = memberIn(accessor, "type");
  for (const auto& [name, components] :
       {std::pair{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}) {
    if (type == name) return static_cast<std::uint64_t>(components);
  }
  return 0;
}

Result<std::vector<double>> GltfValues::of(std::uint64_t index, const char* type, std::uint64_t most) {
  const json& accessor = itemIn(root_, "accessors", index);
  const std::string name = "accessors[" + std::to_string(index) + "]";
  if (memberIn(accessor, "type") != type) return refused("", name + ".type is not \"" + type + '"');
  const std::uint64_t count = numberIn(accessor, "count", 0), components = gltf::componentsOf(accessor);
  if (count > most) {
    return refused("", name + " claims " + std::to_string(count) + " values; it may have " + std::to_string(most));
  }
  Layout layout{.view = numberIn(accessor, "bufferView", kNoIndex),
                .offset = numberIn(accessor, "byteOffset", 0),
                .type = numberIn(accessor, "componentType", 0),
                .components = components,
                .count = count,
                .isNormalized = memberIn(accessor, "normalized") == json(true)};
  std::vector<double> all(count * components, 0.0);
  if (layout.view != kNoIndex) {
    auto stored = numbers(layout, name);
    if (!stored) return stored;
    all = *std::move(stored);
  }
  const json& sparse = memberIn(accessor, "sparse");
  if (sparse.is_null()) return all;
  const json &indices = memberIn(sparse, "indices"), &values = memberIn(sparse, "values");
  layout.count = numberIn(sparse, "count", 0);
  if (layout.count > count) {
    return refused("", name + ".sparse.count is " + std::to_string(layout.count) + "; the accessor has " +
                           std::to_string(count) + " values");
  }
  layout.view = numberIn(values, "bufferView", kNoIndex);
  layout.offset = numberIn(values, "byteOffset", 0);
  const auto places = numbers({.view = numberIn(indices, "bufferView", kNoIndex),
                               .offset = numberIn(indices, "byteOffset", 0),
                               .type = numberIn(indices, "componentType", 0),
                               .components = 1,
                               .count = layout.count},
                              name + ".sparse.indices");
  if (!places) return places;
  const auto changed = numbers(layout, name + ".sparse.values");
  if (!changed) return changed;
  for (std::size_t i = 0; i < places->size(); ++i) {
    const double place = (*places)[i];
    if (!(place >= 0 && place < static_cast<double>(count))) {
      return refused("",
                     name + ".sparse.indices has a number that is none of its " + std::to_string(count) + " values");
    }
    std::copy_n(changed->begin() + static_cast<std::ptrdiff_t>(i * components), components,
                all.begin() + static_cast<std::ptrdiff_t>(static_cast<std::uint64_t>(place) * components));
  }
  return all;
}

Result<std::vector<double>> GltfValues::numbers(const Layout& layout, const std::string& name) {
  const json& view = itemIn(root_, "bufferViews", layout.view);
  const std::uint64_t each = gltf::bytesOf(layout.type), element = each * layout.components;
  if (view.is_null() || each == 0) return refused("", name + " has no bufferView, or no componentType, that is known");
  const auto buffer = bytesIn(numberIn(view, "buffer", kNoIndex));
  if (!buffer) return tl::unexpected(buffer.error());
  std::string_view bytes = buffer->substr(std::min<std::uint64_t>(numberIn(view, "byteOffset", 0), buffer->size()));
  bytes = bytes.substr(0, numberIn(view, "byteLength", 0));
  bytes.remove_prefix(std::min<std::uint64_t>(layout.offset, bytes.size()));
  const std::uint64_t own = numberIn(view, "byteStride", 0), stride = own > 0 ? own : element;
  const std::uint64_t room = bytes.size() < element ? 0 : (bytes.size() - element) / stride + 1;
  if (layout.count > room) {
    return refused(
        "", name + " claims " + std::to_string(layout.count) + " values; there are bytes for " + std::to_string(room));
  }
  std::vector<double> all;
  all.reserve(layout.count * layout.components);
  const double one = layout.isNormalized ? oneOf(layout.type) : 1;
  for (std::uint64_t i = 0; i < layout.count; ++i) {
    for (std::uint64_t k = 0; k < layout.components; ++k) {
      const double value = componentAt(bytes.data() + i * stride + k * each, layout.type) / one;
      all.push_back(layout.isNormalized ? std::max(value, -1.0) : value);
    }
  }
  return all;
}

Result<std::string_view> GltfValues::bytesIn(std::uint64_t index) {
  const json& uri = memberIn(itemIn(root_, "buffers", index), "uri");
  if (!uri.is_string()) return binary_.value_or("");
  const auto& text = uri.get_ref<const std::string&>();
  if (const auto at = read_.find(text); at != read_.end()) return at->second;
  auto bytes = text.starts_with("data:") ? fromDataUri(text) : readIncluded_(withoutPercents(text));
  if (!bytes) return refused("", "names the file " + inQuotes(text) + ", which is not in its folder or below");
  return read_.emplace(text, *std::move(bytes)).first->second;
}

std::optional<std::string> fromDataUri(std::string_view uri) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t comma = uri.find(',');
  if (comma == uri.npos || !uri.substr(0, comma).ends_with(";base64")) return std::nullopt;
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  std::string_view text = uri.substr(comma + 1);
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    const std::size_t digit = kDigits.find(c == '-' ? '+' : c == '_' ? '/' : c);
    if (digit == kDigits.npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xff);
  }
  return bytes;
}

}  // namespace haptics
