#include "common/mesh/vertex_values.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "common/mesh/tri_mesh.h"

namespace haptics {
namespace {

static_assert(std::endian::native == std::endian::little, "canonical bytes are little-endian");

constexpr std::string_view kMagic = "HVTX";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderSize = kMagic.size() + sizeof kVersion + sizeof(std::uint64_t);

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
T valueAt(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::string encodeVertexValues(std::span<const float> values) {
  std::string bytes(kMagic);
  bytes.reserve(kHeaderSize + values.size_bytes());
  append(bytes, kVersion);
  append(bytes, static_cast<std::uint64_t>(values.size()));
  for (const float value : values) append(bytes, value + 0.0F);  // -0 + 0 is +0
  return bytes;
}

Result<std::vector<float>> decodeVertexValues(std::string_view bytes) {
  if (bytes.size() < kHeaderSize || !bytes.starts_with(kMagic)) {
    return refused("magic", "is not \"HVTX\": the asset does not hold vertex values");
  }
  const auto version = valueAt<std::uint32_t>(bytes, kMagic.size());
  if (version != kVersion) {
    return refused("version", "is " + std::to_string(version) + "; this program reads " + std::to_string(kVersion));
  }
  const auto count = valueAt<std::uint64_t>(bytes, kMagic.size() + sizeof version);
  if (count == 0 || count > kMaxVertices) {
    return refused("count", "is " + std::to_string(count) + "; give 1 to " + std::to_string(kMaxVertices));
  }
  if (bytes.size() != kHeaderSize + count * sizeof(float)) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; " + std::to_string(count) + " values take " +
                               std::to_string(kHeaderSize + count * sizeof(float)));
  }
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes.data() + kHeaderSize, count * sizeof(float));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && values[i] >= 0 && !std::signbit(values[i])) continue;
    return refused("values[" + std::to_string(i) + "]",
                   "is " + std::to_string(values[i]) + "; give a finite number from 0 up");
  }
  return values;
}

ContentHash hashOf(const std::vector<float>& vertexValues) {
  const std::string bytes = encodeVertexValues(vertexValues);
  return Hasher().add(std::as_bytes(std::span(bytes))).finish();
}

}  // namespace haptics
