#include "haptic_server/engine/surface/shading_normals.h"

#include <algorithm>
#include <limits>

#include "common/interruption/grow.h"
#include "common/maths/elementary.h"

namespace haptics {
namespace {

/// The polygons around a vertex from one sharp line to the next, or all of them.
struct Sector {
  Vec3 normal{0};
  double roundness = 0;  // 1/m
  double hollowness = 0;
};

void forEachTriangle(const CollisionMesh& surface, auto work) {
  forEach(surface.triangleCount(), [&](std::size_t t) { work(static_cast<std::uint32_t>(t)); });
}

[[nodiscard]] std::size_t placeOf(std::uint32_t t, int k) { return 3 * std::size_t{t} + static_cast<std::size_t>(k); }

/// Bound of the smooth surface's bulge over a polygon: a sixth of the largest product at its lines, if all three are as
/// large.
[[nodiscard]] double bulgeBound(const TriangleRecord& triangle, const ShadingRecord& shading) {
  double most = 0;
  for (int k = 0; k < 3; ++k) {
    const int next = nextCorner(k);
    most =
        std::max(most, glm::dot(triangle.corner(next) - triangle.corner(k), shading.normal(next) - shading.normal(k)));
  }
  return shading.hasNormals() ? most / 6 : 0;
}

class Builder {
 public:
  Builder(const CollisionMesh& surface, double crease_rad, std::span<const std::array<std::uint32_t, 2>> creases)
      : surface_(surface), minCosine_(elementary::cos(crease_rad)), creases_(creases) {
    const std::size_t corners = 3 * std::size_t{surface.triangleCount()};
    sharp_.resize(corners);
    sharpVertex_.resize(vertexCount());
    sectorOf_.assign(corners, kNone);
    forEachTriangle(surface, [&](std::uint32_t t) {
      for (int k = 0; k < 3; ++k) {
        if (!isSharp(t, k)) continue;
        sharp_[placeOf(t, k)] = 1;
        for (const int end : {k, nextCorner(k)}) sharpVertex_[surface.triangle(t).vertexAt(end)] = 1;
      }
    });
    forEachTriangle(surface, [&](std::uint32_t t) {
      for (int k = 0; k < 3; ++k) {
        if (sectorOf_[placeOf(t, k)] == kNone) addSector(t, k);
      }
    });
    forEach(sectors_.size(), [&](std::size_t i) { sectors_[i].normal = unitOrZero(sectors_[i].normal); });
    forEachTriangle(surface, [&](std::uint32_t t) { bendAlong(t); });
  }

  [[nodiscard]] ShadingRecord record(std::uint32_t t) const {
    ShadingRecord r{};
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Sector& sector = sectors_[sectorOf_[placeOf(t, k)]];
      for (int d = 0; d < 3; ++d) r.rows[static_cast<std::size_t>(d)][i] = static_cast<float>(sector.normal[d]);
      r.rows[i][3] = static_cast<float>(sector.roundness);
      r.hollowness[i] = static_cast<float>(sector.hollowness);
      if (sharp_[placeOf(t, k)] != 0) r.flags |= ShadingRecord::kSharpLine << k;
      if (sharpVertex_[surface_.triangle(t).vertexAt(k)] != 0) r.flags |= ShadingRecord::kSharpVertex << k;
      if (sector.normal == Vec3(0)) r.flags |= ShadingRecord::kNoNormals;
    }
    if (surface_.triangle(t).zeroArea()) r.flags |= ShadingRecord::kNoNormals;
    return r;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  struct Corner {
    std::uint32_t t;
    int k;
    bool operator==(const Corner&) const = default;
  };

  [[nodiscard]] bool isSharp(std::uint32_t t, int edge) const {
    const TriangleRecord& r = surface_.triangle(t);
    if (r.neighbour(edge) == kNoTriangle) return true;
    const std::uint32_t a = r.vertexAt(edge), b = r.vertexAt(nextCorner(edge));
    if (std::ranges::binary_search(creases_, std::array{std::min(a, b), std::max(a, b)})) return true;
    return glm::dot(surface_.faceNormal(t), surface_.faceNormal(r.neighbour(edge))) < minCosine_;
  }

  /// The polygon beside this one around the same vertex, across corner edge `edge`.
  [[nodiscard]] Corner across(Corner c, int edge) const {
    const TriangleRecord& r = surface_.triangle(c.t);
    const std::uint32_t other = r.neighbour(edge);
    return {other, surface_.triangle(other).cornerOf(r.vertexAt(c.k))};
  }

  /// Back to a sharp line, or once around; then forward over all of the sector.
  void addSector(std::uint32_t t, int k) {
    const Corner start{t, k};
    Corner first = start;
    while (sharp_[placeOf(first.t, first.k)] == 0) {
      first = across(first, first.k);
      if (first == start) break;
    }
    const auto index = static_cast<std::uint32_t>(sectors_.size());
    Sector& sector = sectors_.emplace_back();
    for (Corner c = first;;) {
      sectorOf_[placeOf(c.t, c.k)] = index;
      sector.normal += weighted(c);
      const int edge = previousCorner(c.k);
      if (sharp_[placeOf(c.t, edge)] != 0) break;
      c = across(c, edge);
      if (c == first) break;
    }
  }

  /// A polygon's normal with its weight in the vertex's.
  [[nodiscard]] Vec3 weighted(Corner c) const {
    const TriangleRecord& r = surface_.triangle(c.t);
    const Vec3 a = r.corner(nextCorner(c.k)) - r.corner(c.k);
    const Vec3 b = r.corner(previousCorner(c.k)) - r.corner(c.k);
    const double scale = squaredLength(a) * squaredLength(b);
    return scale > 0 ? glm::cross(a, b) / scale : Vec3(0);
  }

  /// How the normals turn along the lines of a polygon.
  void bendAlong(std::uint32_t t) {
    const TriangleRecord& r = surface_.triangle(t);
    for (int k = 0; k < 3; ++k) {
      Sector& a = sectors_[sectorOf_[placeOf(t, k)]];
      Sector& b = sectors_[sectorOf_[placeOf(t, nextCorner(k))]];
      const Vec3 way = r.corner(nextCorner(k)) - r.corner(k);
      if (way == Vec3(0)) continue;
      const double bend = glm::dot(b.normal - a.normal, way) / squaredLength(way);
      for (Sector* sector : {&a, &b}) {
        sector->roundness = std::max(sector->roundness, bend);
        sector->hollowness = std::max(sector->hollowness, -bend);
      }
    }
  }

  [[nodiscard]] std::size_t vertexCount() const {
    std::uint32_t last = 0;
    for (std::uint32_t t = 0; t < surface_.triangleCount(); ++t)
      last = std::max(last, std::ranges::max(surface_.triangle(t).vertex));
    return std::size_t{last} + 1;
  }

  const CollisionMesh& surface_;
  double minCosine_;
  std::span<const std::array<std::uint32_t, 2>> creases_;
  std::vector<std::uint8_t> sharp_;        // by line (t, k)
  std::vector<std::uint8_t> sharpVertex_;  // by vertex
  std::vector<Sector> sectors_;
  std::vector<std::uint32_t> sectorOf_;  // of corner (t, k)
};

}  // namespace

ShadingNormals::ShadingNormals(const CollisionMesh& surface, double crease_rad,
                               std::span<const std::array<std::uint32_t, 2>> creases) {
  const Builder builder(surface, crease_rad, creases);
  records_.resize(surface.triangleCount());
  forEachTriangle(surface, [&](std::uint32_t t) {
    records_[t] = builder.record(t);
    highestBulge_m_ = std::max(highestBulge_m_, bulgeBound(surface.triangle(t), records_[t]));
  });
}

}  // namespace haptics
