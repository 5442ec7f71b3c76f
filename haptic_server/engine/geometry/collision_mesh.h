#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/bounding_hierarchy.h"
#include "haptic_server/engine/geometry/closest_point.h"
#include "haptic_server/engine/geometry/large_pages.h"
#include "haptic_server/engine/geometry/segment.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {

/// Triangles tested, for a mesh and for each of its triangles, before all of it is taken for crossed: 0.3 s at least. A sane
/// mesh needs about 10 each, slivers across the whole mesh need thousands. Too small costs speed on such meshes, never safety.
inline constexpr std::int64_t kMaxCrossingTests = 1 << 25, kMaxCrossingTestsEach = 64;

/// The hierarchical database of paper 3.1 for one mesh: polygons, lines and vertices, each with its normal and its
/// neighbours, under a hierarchy of bounding boxes (3.2). Immutable; object frame, metres.
///
/// The paper keeps three lists of primitives with explicit neighbour lists. Here all of it is reached from the
/// polygons' records, one cache line each, in the order of the hierarchy:
///  - polygon t: its lines are (t, 0..2), its vertices triangle(t).vertex[0..2];
///  - line (t, k): its polygons are t and triangle(t).neighbour(k), its vertices corners k and k + 1 of t. A line is
///    the same from both of its polygons;
///  - vertex (t, k): its polygons are the fan around corner k, its lines the edges between them (see visitFan()).
/// A line joins two polygons only where exactly two run along it, in opposite directions. Every other edge is a
/// boundary: rims of holes, fins, duplicates, flipped faces.
///
/// Queries neither allocate nor lock. Triangle numbers are those of the records; canonical() translates them.
class CollisionMesh {
 public:
  CollisionMesh(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles, int threads);

  [[nodiscard]] std::uint32_t triangleCount() const noexcept { return static_cast<std::uint32_t>(records_.size()); }
  [[nodiscard]] const TriangleRecord& triangle(std::uint32_t t) const noexcept { return records_[t]; }
  [[nodiscard]] std::uint32_t canonical(std::uint32_t t) const noexcept { return records_[t].canonical(); }

  /// Asks the caches for what a search reads of triangle t.
  void prefetch(std::uint32_t t) const noexcept { __builtin_prefetch(&records_[t]); }

  [[nodiscard]] Vec3 low() const noexcept { return low_; }    ///< Corner of the box about all vertices.
  [[nodiscard]] Vec3 high() const noexcept { return high_; }  ///< Opposite corner.
  [[nodiscard]] Vec3 centre() const noexcept { return (low_ + high_) * 0.5; }
  /// Of the sphere about centre() through the corners.
  [[nodiscard]] double radius_m() const noexcept { return radius_; }
  /// Largest distance from the origin within the box: what tolerances are fractions of.
  [[nodiscard]] double extent_m() const noexcept { return extent_; }
  /// Every edge joins two polygons: the mesh has an inside, and can only be entered from outside.
  [[nodiscard]] bool closed() const noexcept { return closed_; }
  /// Some part passes through another.
  [[nodiscard]] bool anySelfIntersecting() const noexcept { return anySelfIntersecting_; }

  /// Unit normals of the primitives (3.1): polygon; line = mean of its polygons; vertex = mean of its polygons weighted
  /// by their angles. A polygon without area takes that of the polygon across its longest edge.
  [[nodiscard]] Vec3 faceNormal(std::uint32_t t) const noexcept;
  [[nodiscard]] Vec3 lineNormal(std::uint32_t t, int edge) const noexcept;
  [[nodiscard]] Vec3 vertexNormal(std::uint32_t t, int corner) const noexcept {
    return isMoved_ ? cornerNormal(t, corner) : Vec3(vertexNormals_[records_[t].vertexAt(corner)]);
  }
  /// Normal of the primitive that holds the foot; on a boundary, where faces may be flipped, of its polygon.
  [[nodiscard]] Vec3 normal(const ClosestPoint& foot) const noexcept;

  /// Is h outside, judged at its closest point? The normal of the primitive that holds the foot gives the right sign on
  /// a closed mesh (Baerentzen and Aanaes, Signed Distance Computation Using the Angle Weighted Pseudonormal, 2005).
  /// `side` is -1 for the back of a sheet. On the surface counts as outside (as in Segment::enters).
  [[nodiscard]] bool isOutside(const ClosestPoint& foot, Vec3 h, int side = 1) const noexcept;
  /// Does the foot lie on a boundary, where the search cannot go on and the sign means nothing?
  [[nodiscard]] bool onBoundary(const ClosestPoint& foot) const noexcept;

  /// First entering crossing on from -> to (paper 3.2, first contact). `skip(triangle)` leaves out those that contain
  /// the start by construction. Watertight. Sheets, that is surfaces that are not closed, are entered from both sides.
  /// `Test` is made of from, to and `more`, and meets each triangle with enters(). The answer of a query that has spent
  /// the allowance means nothing, here and below.
  template <class Test = Segment, class Skip, class... More>
  [[nodiscard]] Crossing firstCrossing(Vec3 from, Vec3 to, bool twoSided, Allowance& allowance, Skip skip,
                                       More... more) const noexcept;
  [[nodiscard]] Crossing firstCrossing(Vec3 from, Vec3 to, Allowance& allowance) const noexcept {
    return firstCrossing(from, to, !closed_, allowance, [](std::uint32_t) { return false; });
  }
  /// The same without a limit.
  [[nodiscard]] Crossing firstCrossing(Vec3 from, Vec3 to) const noexcept {
    Allowance endless;
    return firstCrossing(from, to, endless);
  }

  /// Closest point of the whole mesh to h. Looks at no more than `budget` triangles and returns the best of them: near
  /// boxes come first, so what is left out seldom matters. Adds the triangles looked at to `spent`.
  [[nodiscard]] ClosestPoint closestFoot(Vec3 h, int budget, int& spent, Allowance& allowance) const noexcept;
  [[nodiscard]] ClosestPoint closestFoot(Vec3 h, int budget, int& spent) const noexcept {
    Allowance endless;
    return closestFoot(h, budget, spent, endless);
  }

  /// What the database holds, tree and normals included.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  [[nodiscard]] const BoundingHierarchy& hierarchy() const noexcept { return hierarchy_; }

  /// The same mesh with its vertices somewhere else: topology and the triangles' order are kept, the boxes refitted, and
  /// what crosses is looked for anew wherever it may have changed, so that the marks are those of a surface built from
  /// these vertices. A tenth of the time of building where a dent's vertices have moved since `from`, more than half of
  /// it where all have. For the builder thread.
  CollisionMesh(const CollisionMesh& from, std::span<const Vec3f> vertices);

  /// Puts the vertices somewhere else in place, as often as a tick does: without allocating, in a time that grows with the
  /// triangles. The marks of what crosses itself stay as they are, and normals of vertices are made where they are asked for.
  void moveVertices(std::span<const Vec3f> vertices) noexcept;

 private:
  /// Of the polygons around a corner, as they are now.
  [[nodiscard]] Vec3 cornerNormal(std::uint32_t t, int corner) const noexcept;
  void fillRecords(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                   std::span<const std::uint32_t> order);
  void measure(std::span<const Vec3f> vertices);
  /// Of the vertices of triangles that have `changed`, that is are not 0; of all others they are known.
  void sumVertexNormals(std::span<const std::uint8_t> changed, std::size_t vertexCount);
  /// Of a surface without marks. `changed` says of each triangle, by not being 0, that it has moved or was marked
  /// before: two others that share no vertex do not cross each other.
  void markSelfIntersecting(std::span<const std::uint8_t> changed, int threads);

  LargePageVector<TriangleRecord> records_;
  BoundingHierarchy hierarchy_;
  LargePageVector<Vec3f> vertexNormals_;  // by canonical vertex; rounded once, 6e-8 rad
  Vec3 low_{0};
  Vec3 high_{0};
  double radius_ = 0;
  double extent_ = 0;
  bool closed_ = true;
  bool anySelfIntersecting_ = false;
  bool isMoved_ = false;  // by moveVertices(): vertexNormals_ are none
};

/// Builds the database of a mesh that satisfies TriMesh's invariants: finite vertices, indices in range, at least one
/// triangle (and at most TriangleRecord::kMaxRecords), no triangle that names a vertex twice. Anything else is
/// accepted as it is: holes, fins, duplicates, flipped faces, slivers, faces without area. Allocates; for the builder
/// thread, which may be interrupted in it. `threads` is the number to build with.
[[nodiscard]] std::shared_ptr<const CollisionMesh> buildCollisionMesh(
    std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles, int threads = 1);

/// CollisionMesh(from, vertices), where vertices are the mesh's, moved. The fewer differ from those of `from`, the less
/// time it takes.
[[nodiscard]] std::shared_ptr<const CollisionMesh> refitCollisionMesh(const CollisionMesh& from,
                                                                      std::span<const Vec3f> vertices);

template <class Test, class Skip, class... More>
Crossing CollisionMesh::firstCrossing(Vec3 from, Vec3 to, bool twoSided, Allowance& allowance, Skip skip,
                                      More... more) const noexcept {
  Crossing first;
  if (from == to) return first;  // a point enters nothing
  const Test segment{from, to, more...};
  allowance.spend(Allowance::kQuery);
  hierarchy_.visitAlong(from, to, allowance, [&](std::uint32_t begin, std::uint32_t end) noexcept {
    allowance.spend(Allowance::kTriangle * (end - begin));
    for (std::uint32_t t = begin; t < end; ++t) {
      Crossing crossing{t};
      if (segment.enters(records_[t], twoSided, crossing) && (!first || crossing.time < first.time) && !skip(t)) {
        first = crossing;
      }
    }
    return first.time;
  });
  return first;
}

}  // namespace haptics
