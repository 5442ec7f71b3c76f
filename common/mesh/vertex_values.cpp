#include "common/mesh/vertex_values.h"

#include <cmath>
#include <cstring>

#include "common/mesh/tri_mesh.h"

namespace haptics {
namespace {

constexpr std::string_view kVertexValuesMagic = "HVTX";

}  // namespace

std::string encodeVertexValues(std::span<const float> values) {
  std::string bytes = listHeader(kVertexValuesMagic, values.size());
  bytes.reserve(kListHeaderSize + values.size_bytes());
  for (const float value : values) append(bytes, value + 0.0F);  // -0 + 0 is +0
  return bytes;
}

Result<std::vector<float>> decodeVertexValues(std::string_view bytes) {
  const auto counted = listCount(bytes, kVertexValuesMagic, "vertex values", sizeof(float), kMaxVertices);
  if (!counted) return tl::unexpected(counted.error());
  const std::size_t count = *counted;
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes.data() + kListHeaderSize, count * sizeof(float));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && values[i] >= 0 && !std::signbit(values[i])) continue;
    return refused("values[" + std::to_string(i) + "]",
                   "is " + std::to_string(values[i]) + "; give a finite number from 0 up");
  }
  return values;
}

CanonicalBytes canonicalBytes(const std::vector<float>& vertexValues) {
  return {listHeader(kVertexValuesMagic, vertexValues.size()), {std::as_bytes(std::span(vertexValues))}};
}

ContentHash hashOf(const std::vector<float>& vertexValues) { return canonicalBytes(vertexValues).hash(); }

}  // namespace haptics
