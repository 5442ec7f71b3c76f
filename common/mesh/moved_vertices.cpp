#include "common/mesh/moved_vertices.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "common/mesh/tri_mesh.h"

namespace haptics {
namespace {

static_assert(std::endian::native == std::endian::little, "canonical bytes are little-endian");
static_assert(sizeof(Vec3f) == 3 * sizeof(float));

constexpr std::string_view kMagic = "HMOV";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderSize = kMagic.size() + sizeof kVersion + sizeof(std::uint64_t);
constexpr std::size_t kVertexSize = sizeof(std::uint32_t) + sizeof(Vec3f);

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

bool isPlace(Vec3f place) {
  for (int d = 0; d < 3; ++d) {
    const float x = place[d];
    const bool negativeZero = x == 0 && std::signbit(x);
    if (!(std::abs(x) <= MovedVertices::kMostMoved_m) || negativeZero) return false;  // also what is no number
  }
  return true;
}

std::string at(const char* list, std::size_t i) { return std::string(list) + "[" + std::to_string(i) + "]"; }

Result<void> check(const MovedVertices& moved) {
  for (std::size_t i = 0; i < moved.vertex.size(); ++i) {
    if (i > 0 && moved.vertex[i] <= moved.vertex[i - 1]) {
      return refused(at("vertex", i), "is " + std::to_string(moved.vertex[i]) + " after " +
                                          std::to_string(moved.vertex[i - 1]) + "; give each once, in ascending order");
    }
    if (!isPlace(moved.place[i])) {
      return refused(at("place", i), "is no place within " + std::to_string(int(MovedVertices::kMostMoved_m)) + " m");
    }
  }
  return {};
}

}  // namespace

void MovedVertices::moveIn(std::span<Vec3f> vertices) const noexcept {
  for (std::size_t i = 0; i < vertex.size() && vertex[i] < vertices.size(); ++i) vertices[vertex[i]] = place[i];
}

std::optional<Vec3f> MovedVertices::placeOf(std::uint32_t which) const noexcept {
  const auto found = std::ranges::lower_bound(vertex, which);
  if (found == vertex.end() || *found != which) return std::nullopt;
  return place[static_cast<std::size_t>(found - vertex.begin())];
}

MovedVertices movedBetween(std::span<const Vec3f> before, std::span<const Vec3f> after) {
  MovedVertices moved;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i] == before[i]) continue;
    moved.vertex.push_back(static_cast<std::uint32_t>(i));
    moved.place.push_back(after[i] + Vec3f(0));  // -0 + 0 is +0
  }
  return moved;
}

std::string encodeMovedVertices(const MovedVertices& moved) {
  std::string bytes(kMagic);
  bytes.reserve(kHeaderSize + kVertexSize * moved.vertex.size());
  append(bytes, kVersion);
  append(bytes, static_cast<std::uint64_t>(moved.vertex.size()));
  for (const std::uint32_t vertex : moved.vertex) append(bytes, vertex);
  for (const Vec3f place : moved.place) append(bytes, place + Vec3f(0));
  return bytes;
}

Result<MovedVertices> decodeMovedVertices(std::string_view bytes) {
  if (bytes.size() < kHeaderSize || !bytes.starts_with(kMagic)) {
    return refused("magic", "is not \"HMOV\": the asset does not hold moved vertices");
  }
  const auto version = valueAt<std::uint32_t>(bytes, kMagic.size());
  if (version != kVersion) {
    return refused("version", "is " + std::to_string(version) + "; this program reads " + std::to_string(kVersion));
  }
  const auto count = valueAt<std::uint64_t>(bytes, kMagic.size() + sizeof version);
  if (count == 0 || count > kMaxVertices) {
    return refused("count", "is " + std::to_string(count) + "; give 1 to " + std::to_string(kMaxVertices));
  }
  if (bytes.size() != kHeaderSize + count * kVertexSize) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; " + std::to_string(count) +
                               " vertices take " + std::to_string(kHeaderSize + count * kVertexSize));
  }
  MovedVertices moved{std::vector<std::uint32_t>(count), std::vector<Vec3f>(count)};
  std::memcpy(moved.vertex.data(), bytes.data() + kHeaderSize, count * sizeof(std::uint32_t));
  std::memcpy(moved.place.data(), bytes.data() + kHeaderSize + count * sizeof(std::uint32_t), count * sizeof(Vec3f));
  if (auto right = check(moved); !right) return tl::unexpected<Error>(std::move(right).error());
  return moved;
}

ContentHash hashOf(const MovedVertices& moved) {
  const std::string bytes = encodeMovedVertices(moved);
  return Hasher().add(std::as_bytes(std::span(bytes))).finish();
}

}  // namespace haptics
