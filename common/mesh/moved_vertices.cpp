#include "common/mesh/moved_vertices.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "common/mesh/tri_mesh.h"

namespace haptics {
namespace {

static_assert(sizeof(Vec3f) == 3 * sizeof(float));

constexpr std::string_view kMovedVerticesMagic = "HMOV";
constexpr std::size_t kVertexSize = sizeof(std::uint32_t) + sizeof(Vec3f);

bool isPlace(Vec3f place) {
  for (int d = 0; d < 3; ++d) {
    const float x = place[d];
    const bool negativeZero = x == 0 && std::signbit(x);
    if (!(std::abs(x) <= MovedVertices::kMaxMoved_m) || negativeZero) return false;  // also what is no number
  }
  return true;
}

std::string at(const char* list, std::size_t i) { return std::string(list) + "[" + std::to_string(i) + "]"; }

}  // namespace

void MovedVertices::moveIn(std::span<Vec3f> vertices) const noexcept {
  for (std::size_t i = 0; i < vertex.size() && vertex[i] < vertices.size(); ++i) vertices[vertex[i]] = place[i];
}

std::optional<Vec3f> MovedVertices::placeOf(std::uint32_t which) const noexcept {
  const auto found = std::ranges::lower_bound(vertex, which);
  if (found == vertex.end() || *found != which) return std::nullopt;
  return place[static_cast<std::size_t>(found - vertex.begin())];
}

Result<void> checkMovedVertices(const MovedVertices& moved) {
  for (std::size_t i = 0; i < moved.vertex.size(); ++i) {
    if (i > 0 && moved.vertex[i] <= moved.vertex[i - 1]) {
      return refused(at("vertex", i), "is " + std::to_string(moved.vertex[i]) + " after " +
                                          std::to_string(moved.vertex[i - 1]) + "; give each once, in ascending order");
    }
    if (!isPlace(moved.place[i])) {
      return refused(at("place", i), "is no place within " + std::to_string(int(MovedVertices::kMaxMoved_m)) + " m");
    }
  }
  return {};
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

CanonicalBytes canonicalBytes(const MovedVertices& moved) {
  return {listHeader(kMovedVerticesMagic, moved.vertex.size()),
          {std::as_bytes(std::span(moved.vertex)), std::as_bytes(std::span(moved.place))}};
}

std::string encodeMovedVertices(const MovedVertices& moved) { return canonicalBytes(moved).copy(); }

Result<MovedVertices> decodeMovedVertices(std::string_view bytes) {
  const auto counted = listCount(bytes, kMovedVerticesMagic, "moved vertices", kVertexSize, kMaxVertices);
  if (!counted) return tl::unexpected(counted.error());
  const std::size_t count = *counted;
  MovedVertices moved{std::vector<std::uint32_t>(count), std::vector<Vec3f>(count)};
  std::memcpy(moved.vertex.data(), bytes.data() + kListHeaderSize, count * sizeof(std::uint32_t));
  std::memcpy(moved.place.data(), bytes.data() + kListHeaderSize + count * sizeof(std::uint32_t),
              count * sizeof(Vec3f));
  if (auto right = checkMovedVertices(moved); !right) return tl::unexpected<Error>(std::move(right).error());
  return moved;
}

ContentHash hashOf(const MovedVertices& moved) { return canonicalBytes(moved).hash(); }

}  // namespace haptics
