#include "haptic_server/engine/geometry/collision_mesh.h"

#include <algorithm>

#include "common/interruption/grow.h"
#include "common/interruption/progress.h"
#include "common/maths/elementary.h"
#include "haptic_server/engine/geometry/connectivity.h"
#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics {
namespace {

std::array<double, 3> angles_rad(const TriangleRecord& r) noexcept {
  std::array<Vec3, 3> along;
  for (int k = 0; k < 3; ++k) along[static_cast<std::size_t>(k)] = unitOrZero(r.corner(nextCorner(k)) - r.corner(k));
  const auto at = [](Vec3 into, Vec3 outOf) { return elementary::acos(std::clamp(-glm::dot(into, outOf), -1.0, 1.0)); };
  return {at(along[2], along[0]), at(along[0], along[1]), at(along[1], along[2])};
}

int longestEdge(const TriangleRecord& r) noexcept {
  int longest = 0;
  double most = -1;
  for (int k = 0; k < 3; ++k) {
    const double length2 = squaredLength(r.corner(nextCorner(k)) - r.corner(k));
    if (length2 > most) {
      most = length2;
      longest = k;
    }
  }
  return longest;
}

}  // namespace

CollisionMesh::CollisionMesh(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                             int threads) {
  // Parts of the time that a large closed mesh takes.
  constexpr double kHierarchyDone = 0.45, kRecordsDone = 0.75, kNormalsDone = 0.85;
  measure(vertices);
  reportProgress(WorkStage::kBuilding, 0);
  const auto order = hierarchy_.build(vertices, triangles, extent_, threads);
  reportProgress(WorkStage::kBuilding, kHierarchyDone);
  fillRecords(vertices, triangles, order);
  interruptionPoint();
  reportProgress(WorkStage::kBuilding, kRecordsDone);
  const std::vector<std::uint8_t> all(records_.size(), 1);
  sumVertexNormals(all, vertices.size());
  reportProgress(WorkStage::kBuilding, kNormalsDone);
  markSelfIntersecting(all, threads);
}

CollisionMesh::CollisionMesh(const CollisionMesh& from, std::span<const Vec3f> vertices)
    : records_(from.records_), hierarchy_(from.hierarchy_), vertexNormals_(from.vertexNormals_), closed_(from.closed_) {
  measure(vertices);
  std::vector<std::uint8_t> changed(records_.size());
  forEach(records_.size(), [&](std::size_t t) {
    TriangleRecord& r = records_[t];
    changed[t] = r.selfIntersecting() ? 1 : 0;  // what crossed it may have moved away
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f v = vertices[r.vertex[k]];
      for (std::size_t d = 0; d < 3; ++d) {
        float& x = r.rows[d][k];
        if (x != v[static_cast<int>(d)]) changed[t] = 1;
        x = v[static_cast<int>(d)];
      }
    }
    r.flags &= ~(TriangleRecord::kZeroArea | TriangleRecord::kSelfIntersecting);
    if (r.areaNormal() == Vec3(0)) r.flags |= TriangleRecord::kZeroArea;
  });
  sumVertexNormals(changed, vertices.size());
  hierarchy_.refit(records_, extent_);
  markSelfIntersecting(changed, 1);
}

void CollisionMesh::moveVertices(std::span<const Vec3f> vertices) noexcept {
  measure(vertices);
  for (TriangleRecord& r : records_) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f v = vertices[r.vertex[k]];
      for (std::size_t d = 0; d < 3; ++d) r.rows[d][k] = v[static_cast<int>(d)];
    }
    r.flags &= ~TriangleRecord::kZeroArea;
    if (r.areaNormal() == Vec3(0)) r.flags |= TriangleRecord::kZeroArea;
  }
  hierarchy_.refitInPlace(records_, extent_);
  isMoved_ = true;
}

Vec3 CollisionMesh::cornerNormal(std::uint32_t t, int corner) const noexcept {
  Vec3 sum(0);
  const auto add = [&](std::uint32_t polygon, int at) noexcept {
    sum += faceNormal(polygon) * angles_rad(records_[polygon])[static_cast<std::size_t>(at)];
    return true;
  };
  add(t, corner);
  visitFan(*this, t, corner, add);
  return unitOrZero(sum);
}

void CollisionMesh::measure(std::span<const Vec3f> vertices) {
  Vec3f low = vertices.front();
  Vec3f high = low;
  for (const Vec3f v : vertices) {
    low = glm::min(low, v);
    high = glm::max(high, v);
  }
  low_ = Vec3(low);
  high_ = Vec3(high);
  radius_ = glm::length(high_ - low_) * 0.5;
  extent_ = glm::length(glm::max(glm::abs(low_), glm::abs(high_)));
}

void CollisionMesh::fillRecords(std::span<const Vec3f> vertices,
                                std::span<const std::array<std::uint32_t, 3>> triangles,
                                std::span<const std::uint32_t> order) {
  std::vector<std::array<std::uint32_t, 3>> ordered;
  growTo(ordered, triangles.size());
  forEach(ordered.size(), [&](std::size_t t) { ordered[t] = triangles[order[t]]; });
  const std::vector<std::uint32_t> neighbours = findNeighbours(vertices.size(), ordered);
  interruptionPoint();
  const std::vector<std::uint8_t> open = findOpenVertices(vertices.size(), ordered, neighbours);
  growTo(records_, ordered.size());
  forEach(ordered.size(), [&](std::size_t t) {
    TriangleRecord& r = records_[t];
    r.vertex = ordered[t];
    r.flags = order[t] << TriangleRecord::kFlagBits;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f v = vertices[r.vertex[k]];
      for (std::size_t d = 0; d < 3; ++d) r.rows[d][k] = v[static_cast<int>(d)];
      r.setNeighbour(static_cast<int>(k), neighbours[3 * t + k]);
      closed_ = closed_ && neighbours[3 * t + k] != kNoTriangle;
      if (open[r.vertex[k]] != 0) r.flags |= TriangleRecord::kOpenCorner << k;
    }
    if (r.areaNormal() == Vec3(0)) r.flags |= TriangleRecord::kZeroArea;
  });
}

void CollisionMesh::sumVertexNormals(std::span<const std::uint8_t> changed, std::size_t vertexCount) {
  std::vector<std::uint8_t> anew(vertexCount);
  for (std::uint32_t t = 0; t < records_.size(); ++t) {
    if (changed[t] == 0 && !records_[t].zeroArea()) continue;  // without area it takes that of another, which may move
    for (const std::uint32_t v : records_[t].vertex) anew[v] = 1;
  }
  interruptionPoint();
  std::vector<Vec3> sum;
  growTo(sum, vertexCount, Vec3(0));
  forEach(records_.size(), [&](std::size_t t) {
    const auto& vertex = records_[t].vertex;
    if ((anew[vertex[0]] | anew[vertex[1]] | anew[vertex[2]]) == 0) return;
    const Vec3 normal = faceNormal(static_cast<std::uint32_t>(t));
    const auto angles = angles_rad(records_[t]);
    for (std::size_t k = 0; k < 3; ++k) sum[vertex[k]] += normal * angles[k];
  });
  vertexNormals_.resize(vertexCount);
  forEach(vertexCount, [&](std::size_t v) {
    if (anew[v] != 0) vertexNormals_[v] = Vec3f(unitOrZero(sum[v]));
  });
}

Vec3 CollisionMesh::faceNormal(std::uint32_t t) const noexcept {
  // A few in a row is what collinear points along one edge make; beyond that there is no normal to find.
  constexpr int kFarthest = 8;
  for (int i = 0; i < kFarthest && records_[t].zeroArea(); ++i) {
    const std::uint32_t across = records_[t].neighbour(longestEdge(records_[t]));
    if (across == kNoTriangle) break;
    t = across;
  }
  return unitOrZero(records_[t].areaNormal());
}

Vec3 CollisionMesh::lineNormal(std::uint32_t t, int edge) const noexcept {
  const std::uint32_t across = records_[t].neighbour(edge);
  const Vec3 own = faceNormal(t);
  return across == kNoTriangle ? own : unitOrZero(own + faceNormal(across));
}

Vec3 CollisionMesh::normal(const ClosestPoint& foot) const noexcept {
  if (onBoundary(foot)) return faceNormal(foot.triangle);
  Vec3 n(0);
  if (foot.feature == Feature::kLine) n = lineNormal(foot.triangle, foot.index);
  if (foot.feature == Feature::kVertex) n = unitOrZero(vertexNormal(foot.triangle, foot.index));
  return n == Vec3(0) ? faceNormal(foot.triangle) : n;  // a sheet folded onto itself has no mean
}

bool CollisionMesh::isOutside(const ClosestPoint& foot, Vec3 h, int side) const noexcept {
  const TriangleRecord& r = records_[foot.triangle];
  double height = 0;
  switch (foot.feature) {
    case Feature::kPolygon:
      height = glm::dot(r.areaNormal(), h - r.corner(0));
      break;
    case Feature::kLine:
      height = glm::dot(lineNormal(foot.triangle, foot.index), h - foot.point);
      break;
    case Feature::kVertex:
      height = glm::dot(vertexNormal(foot.triangle, foot.index), h - foot.point);
      break;
  }
  return (height >= 0) == (side > 0);
}

bool CollisionMesh::onBoundary(const ClosestPoint& foot) const noexcept {
  const TriangleRecord& r = records_[foot.triangle];
  if (foot.feature == Feature::kPolygon) return false;
  return foot.feature == Feature::kLine ? r.neighbour(foot.index) == kNoTriangle : r.openAt(foot.index);
}

ClosestPoint CollisionMesh::closestFoot(Vec3 h, int budget, int& spent, Allowance& allowance) const noexcept {
  ClosestPoint best;
  int left = budget;
  allowance.spend(Allowance::kQuery);
  hierarchy_.visitNear(h, allowance, [&](std::uint32_t begin, std::uint32_t end) noexcept {
    allowance.spend(Allowance::kNearTriangle * (end - begin));
    for (std::uint32_t t = begin; t < end && left > 0; ++t, --left) {
      const ClosestPoint foot = closestOn(records_[t], t, h);
      if (foot.squaredDistance < best.squaredDistance) best = foot;
    }
    return left > 0 ? best.squaredDistance : -1.0;
  });
  spent += budget - left;
  return best;
}

std::size_t CollisionMesh::memory_bytes() const noexcept {
  return records_.capacity() * sizeof(TriangleRecord) + hierarchy_.memory_bytes() +
         vertexNormals_.capacity() * sizeof(Vec3f);
}

std::shared_ptr<const CollisionMesh> refitCollisionMesh(const CollisionMesh& from, std::span<const Vec3f> vertices) {
  return std::make_shared<const CollisionMesh>(from, vertices);
}

std::shared_ptr<const CollisionMesh> buildCollisionMesh(std::span<const Vec3f> vertices,
                                                        std::span<const std::array<std::uint32_t, 3>> triangles,
                                                        int threads) {
  return std::make_shared<const CollisionMesh>(vertices, triangles, threads);
}

}  // namespace haptics
