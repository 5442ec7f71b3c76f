#include "haptic_server/engine/collision/polytope_on_mesh.h"

#include <algorithm>
#include <array>

#include "haptic_server/engine/collision/clipped_polygon.h"
#include "haptic_server/engine/collision/level_axis.h"
#include "haptic_server/engine/collision/polytope_contact.h"
#include "haptic_server/engine/collision/surface_queries.h"
#include "haptic_server/engine/contact/frame.h"

namespace haptics {
namespace {

/// Units of the corner of a polytope that is farthest along a direction.
constexpr std::int64_t kSupport = 60;
/// Of a triangle over a face.
constexpr std::int64_t kFace = 8;
/// More than float32 makes of a box, of a body's extent.
constexpr double kRounding = 1e-6;

/// The boxes are apart.
[[nodiscard]] bool isBeside(const TriangleRecord& triangle, Vec3 low, Vec3 high) noexcept {
  for (int d = 0; d < 3; ++d) {
    const auto& [a, b, c, neighbour] = triangle.rows[static_cast<std::size_t>(d)];
    if (std::min({a, b, c}) > high[d] || std::max({a, b, c}) < low[d]) return true;
  }
  return false;
}

/// The surface goes on where an edge has no neighbour, as at a T-junction: shows each triangle that begins within rounding of
/// a place there.
/// @param beyond  Unit, off the triangle at the edge.
template <class Look>
void visitBeyond(const CollisionMesh& surface, std::uint32_t triangle, Vec3 place, Vec3 beyond, Allowance& allowance,
                 Look look) noexcept {
  const double near_m = 2 * kRounding * surface.extent_m();
  const Vec3 at = place + near_m * beyond;
  allowance.spend(surface_queries::kQuery);
  surface.hierarchy().visitBox(
      Vec3f(at - Vec3(near_m)), Vec3f(at + Vec3(near_m)), allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        for (std::uint32_t t = begin; t < end; ++t) {
          const TriangleRecord& other = surface.triangle(t);
          if (t == triangle || surface_queries::isBoxFarther(other, at, near_m * near_m, allowance)) continue;
          allowance.spend(Allowance::kNearTriangle);
          if (closestOn(other, t, at).squaredDistance <= near_m * near_m) look(t);
        }
      });
}
/// How a surface goes on beyond a triangle's sides, where it bends outward most.
enum class Bend {
  kNone,    ///< Not by more than rounding.
  kSlight,  ///< Its normal tells well enough where to.
  kSharp,   ///< Or it ends there.
};
/// @param middle  Of what may meet it: a side without a neighbour is looked at where it is nearest.
[[nodiscard]] Bend outwardBend(const CollisionMesh& surface, std::uint32_t t, Vec3 normal, Vec3 middle,
                               Allowance& allowance) noexcept {
  constexpr double kSlightest = 0.998;  // cosine
  const TriangleRecord& triangle = surface.triangle(t);
  const double level = 3 * (glm::dot(normal, triangle.corner(0)) - kRounding * surface.extent_m());
  Bend bend = Bend::kNone;
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t other = triangle.neighbour(k);
    if (other == kNoTriangle) {
      const Vec3 from = triangle.corner(k), side = triangle.corner(nextCorner(k)) - from;
      const double along = std::clamp(glm::dot(middle - from, side) / squaredLength(side), 0.0, 1.0);
      bool goesOn = false;
      visitBeyond(surface, t, from + along * side, unitOrZero(glm::cross(side, normal)), allowance,
                  [&](std::uint32_t next) noexcept {
                    goesOn = goesOn || glm::dot(normal, surface.faceNormal(next)) >= kSlightest;
                  });
      if (!goesOn) return Bend::kSharp;
      bend = Bend::kSlight;
      continue;
    }
    const TriangleRecord& neighbour = surface.triangle(other);  // two of its corners are on the plane
    if (glm::dot(normal, neighbour.corner(0) + neighbour.corner(1) + neighbour.corner(2)) >= level) continue;
    if (glm::dot(normal, surface.faceNormal(other)) < kSlightest) return Bend::kSharp;
    bend = Bend::kSlight;
  }
  return bend;
}
/// A face of the solid has the triangle farther above it than the range. Asked of those with few faces.
[[nodiscard]] bool isBeyondAFace(const Polytope& solid, const Frame& pose, const FlatPart& part,
                                 double range_m) noexcept {
  if (!solid.hasFew()) return false;
  const std::array corners{pose.toLocal(part.corners[0]), pose.toLocal(part.corners[1]), pose.toLocal(part.corners[2])};
  return std::ranges::any_of(solid.faces, [&](const Polytope::Face& face) {
    const double farther_m = face.offset_m + range_m;
    return std::ranges::all_of(corners, [&](Vec3 at) { return glm::dot(face.normal, at) > farther_m; });
  });
}
/// What of the triangle is above a face of the solid.
[[nodiscard]] ClippedPolygon partOver(const Polytope& solid, const Polytope::Face& face, Vec3 out, const Frame& pose,
                                      const FlatPart& part, PolytopeContact& found) noexcept {
  ClippedPolygon polygon;
  polygon.fill(part.corners.size(), [&](std::size_t i) { return part.corners[i]; });
  const auto loop = solid.loopOf(face);
  found.units += ClippedPolygon::kUnits * static_cast<std::int64_t>(loop.size());
  polygon.clipTo(
      loop.size(), [&](std::size_t i) { return pose.toWorld(solid.corners[loop[i]]); }, out);
  return polygon;
}
/// Has the face of the solid that is level with the triangle stand for a contact where it counts in its place: without points
/// where nothing is above it. False: it ties with the contact, and neither counts.
[[nodiscard]] bool turnToLevel(const Polytope& solid, const Frame& pose, const FlatPart& part, NearRange& reach,
                               PolytopeContact& found) noexcept {
  LevelAxis level(reach.way, found.normal, found.gap_m, found.points[0].foot);
  for (const Polytope::Face& face : solid.faces) {
    const Vec3 out = pose.rotate(face.normal);
    if (!level.mayTake(-out)) continue;
    const auto heightOver = [&](Vec3 at) { return glm::dot(out, at - pose.origin) - face.offset_m; };
    const Vec3 lowest = *std::ranges::min_element(part.corners, {}, heightOver);
    const double gap_m = heightOver(lowest);
    if (gap_m < -reach.way.step_m) continue;
    // Else a face that nothing is above says nothing.
    const bool isApart = reach.period_s * level.closingAlong(-out, lowest) <= gap_m + reach.way.step_m;
    if (!isApart && partOver(solid, face, out, pose, part, found).count == 0) continue;
    if (!level.takes(-out, gap_m, lowest)) continue;
    found.normal = -out;
    found.ofSecond = true;
    found.gap_m = gap_m;
    found.count = 0;
    for (PolytopeContact::Point point : partOver(solid, face, out, pose, part, found).all()) {
      point.gap_m = heightOver(point.on);
      point.foot = point.on - point.gap_m * out;
      if (point.gap_m <= reach.way.range_m) found.points[found.count++] = point;
    }
  }
  reach.isOneOfTwo = reach.isOneOfTwo || level.isOneOfTwo() || found.count == 0;
  return !level.isTied();
}
[[nodiscard]] Vec3 farthestAlong(Vec3 direction, const TriangleRecord& triangle) noexcept {
  const std::array corners{triangle.corner(0), triangle.corner(1), triangle.corner(2)};
  return *std::ranges::max_element(corners, {}, [&](Vec3 at) { return glm::dot(direction, at); });
}
/// The direction leads out of the surface at a place of the triangle: along its normal, or between it and that of a triangle
/// beyond a side at which the surface bends outward; at a corner of both, away from all of that triangle.
[[nodiscard]] bool isOutOf(const CollisionMesh& surface, std::uint32_t t, Vec3 place, Vec3 normal, Vec3 out,
                           Allowance& allowance) noexcept {
  constexpr double kAlong = 1e-3, kCorner = 1e-6;
  if (glm::dot(normal, out) < 0) return false;
  const TriangleRecord& triangle = surface.triangle(t);
  for (int k = 0; k < 3; ++k) {
    const Vec3 from = triangle.corner(k), to = triangle.corner(nextCorner(k)), side = to - from;
    const Vec3 beyond = unitOrZero(glm::cross(side, normal));
    if (glm::dot(beyond, out) <= kAlong) continue;  // it does not lean to that side
    const double along = glm::dot(place - from, side) / squaredLength(side);
    const bool isAtCorner = along < kCorner || along > 1 - kCorner;
    const auto leadsInto = [&](std::uint32_t other) noexcept {
      const Vec3 its = surface.faceNormal(other);
      const Vec3 across = glm::cross(side, its);  // from the side into it
      const Vec3 into = isAtCorner ? farthestAlong(across, surface.triangle(other)) - place : across;
      return glm::dot(its, beyond) <= 0 || glm::dot(into, out) > kAlong * glm::length(into);
    };
    const std::uint32_t other = triangle.neighbour(k);
    bool leads = other != kNoTriangle && leadsInto(other);
    if (other == kNoTriangle) {
      visitBeyond(surface, t, place, beyond, allowance, [&](std::uint32_t next) noexcept {
        leads = leads || (glm::dot(surface.faceNormal(next), normal) > 0 && leadsInto(next));
      });
    }
    if (leads) return false;
  }
  return true;
}
[[nodiscard]] std::uint32_t idOf(std::uint32_t triangle, std::uint32_t point) noexcept {
  constexpr std::uint32_t kFirst = kMaxCollisionPoints;  // lower ones are those of points
  return kFirst + (triangle * 2'654'435'761U ^ point * 40'503U) % (PolytopeContact::kIds - kFirst);
}

}  // namespace

bool findOnMesh(const Collider& solid, const Collider& ground, const Pose& pose, bool solidIsFirst, NearRange& reach,
                ManyNear& near, Allowance& allowance) noexcept {
  using namespace surface_queries;
  const CollisionMesh& surface = *ground.surface;
  const Polytope& polytope = *solid.points->polytope;
  const Frame frame(pose);
  const Quat back = glm::conjugate(pose.rotation);
  Polytope::Corner from = 0;
  Vec3 low, high;
  const double widest_m = reach.way.range_m + kRounding * surface.extent_m();
  for (int d = 0; d < 3; ++d) {
    const Vec3 along{frame.x[d], frame.y[d], frame.z[d]};  // the ground's axis in the solid's frame
    from = polytope.farthest(-along, from);
    low[d] = frame.toWorld(polytope.corners[from])[d] - widest_m;
    from = polytope.farthest(along, from);
    high[d] = frame.toWorld(polytope.corners[from])[d] + widest_m;
  }
  const Vec3 middle = frame.toWorld(polytope.middle);
  const double farthest_m = polytope.radius_m + std::max(widest_m, reach.deepest_m);
  const auto isFar = [&](std::uint32_t t, const TriangleRecord& triangle) noexcept {
    const double squared = farthest_m * farthest_m;
    return !polytope.hasFew() &&
           (isBoxFarther(triangle, middle, squared, allowance) || isFarther(triangle, middle, squared, allowance) ||
            closestOn(triangle, t, middle).squaredDistance > squared);
  };
  bool hasRoom = true;
  const auto add = [&](std::uint32_t t, const PolytopeContact& contact, bool isBehind) noexcept {
    if (contact.count == 0) return;
    const auto& deepest = *std::ranges::min_element(contact.all(), {}, &PolytopeContact::Point::gap_m);
    if (isBehind && deepest.gap_m < -kSurelyBehind_m &&
        !isInside(surface, contact.ofSecond ? deepest.foot : deepest.on, reach.deepest_m, allowance))
      return;
    hasRoom = hasRoom && near.count + contact.count <= near.capacity();
    if (!hasRoom) return;
    const std::uint32_t number = surface.triangle(t).canonical();
    for (const PolytopeContact::Point& point : contact.all()) {
      NearPoint& one = near[near.count++];
      const bool ofGround = contact.ofSecond;
      const Vec3 place = frame.toLocal(ofGround ? point.foot : point.on), at = ofGround ? point.on : point.foot;
      one.contact = {idOf(number, point.id),
                     solidIsFirst != ofGround ? 0U : 1U,
                     ofGround ? at : place,
                     ofGround ? place : at,
                     ofGround ? back * -contact.normal : contact.normal,
                     Vec3(0)};
      one.gap_m = point.gap_m;
      one.at = solidIsFirst ? point.on : frame.toLocal(point.on);
      one.normal = solidIsFirst ? contact.normal : back * -contact.normal;
    }
  };
  const auto addOver = [&](std::uint32_t t, const FlatPart& part, bool areCorners, bool isBehind) noexcept {
    const PolytopeContact contact =
        contactOver(polytope, frame, part, {-reach.deepest_m, reach.way.range_m}, from, areCorners);
    allowance.spend(contact.units);
    add(t, contact, isBehind);
  };
  const auto meet = [&](std::uint32_t t) noexcept {
    const TriangleRecord& triangle = surface.triangle(t);
    allowance.spend(kBox);
    if (isBeside(triangle, low, high) || isFar(t, triangle)) return;
    const FlatPart part{{triangle.corner(0), triangle.corner(1), triangle.corner(2)}, surface.faceNormal(t)};
    allowance.spend(kSupport);
    const double height_m = heightOver(polytope, frame, part, reach.way.range_m, from);
    if (height_m > reach.way.range_m) return;
    const bool isBehind = glm::dot(part.normal, middle - part.corners[0]) < 0;  // as above a thin plate's far side
    const Bend bend = outwardBend(surface, t, part.normal, middle, allowance);
    if (bend == Bend::kNone && height_m < -reach.deepest_m) return;
    if (bend == Bend::kSharp && isBeyondAFace(polytope, frame, part, reach.way.range_m)) return;
    if (bend != Bend::kSharp) {
      addOver(t, part, bend == Bend::kNone, isBehind);
    } else if (auto found = contactOf(polytope, part, closestOn(triangle, t, middle).point, pose, reach.way.range_m)) {
      const bool counts = found->count > 0 && turnToLevel(polytope, frame, part, reach, *found);
      allowance.spend(Allowance::kNearTriangle + found->units +
                      kFace * static_cast<std::int64_t>(polytope.faces.size()));
      if (!counts) return;
      const auto isOutAt = [&](const PolytopeContact::Point& point) noexcept {
        return isOutOf(surface, t, found->ofSecond ? point.on : point.foot, part.normal, found->normal, allowance);
      };
      if (std::ranges::any_of(found->all(), isOutAt)) add(t, *found, isBehind);
    } else if (height_m >= -reach.deepest_m) {
      addOver(t, part, false, isBehind);
    }
  };
  allowance.spend(kQuery + 6 * kSupport);
  const auto meetAll = [&](std::uint32_t begin, std::uint32_t end) noexcept {
    for (std::uint32_t t = begin; t < end && hasRoom && !allowance.isSpent(); ++t) meet(t);
    return farthest_m * farthest_m;
  };
  if (polytope.hasFew()) {
    surface.hierarchy().visitBox(Vec3f(low), Vec3f(high), allowance, meetAll);
  } else {  // its sphere leaves more out
    surface.hierarchy().visitNear(middle, allowance, meetAll, farthest_m * farthest_m);
  }
  return hasRoom;
}

}  // namespace haptics
