#include "tests/eval/baselines/pseudocode.h"

#include <limits>

#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics::eval {

template <Primitives kPrimitives>
void Pseudocode<kPrimitives>::place(Vec3 hip) {
  collision_ = false;
  previousHip_ = hip;
}

template <Primitives kPrimitives>
Felt Pseudocode<kPrimitives>::tick(std::span<const Pose> poses, Vec3 hip) {
  bodies_.setPoses(poses);
  const Felt felt = collision_ ? search(hip) : firstContact(hip);
  previousHip_ = hip;
  return felt;
}

template <Primitives kPrimitives>
Felt Pseudocode<kPrimitives>::firstContact(Vec3 hip) {
  const BodySet::Hit hit = bodies_.firstCrossing(previousHip_, hip);
  if (!hit) return {false, hip, Vec3(0), 0};
  collision_ = true;
  body_ = hit.body;
  contacted_ = {Feature::kPolygon, hit.crossing.triangle, 0};
  const Pose& pose = bodies_.pose(body_);
  const ClosestPoint foot = closestOn(surface().triangle(contacted_.triangle), contacted_.triangle, toLocal(pose, hip));
  return {true, toWorld(pose, foot.point), Vec3(0), 1};  // as printed: the penetration vector is not set here
}

template <Primitives kPrimitives>
Felt Pseudocode<kPrimitives>::search(Vec3 hip) {
  const Pose& pose = bodies_.pose(body_);
  const Vec3 h = toLocal(pose, hip);
  int looked = 1;
  Distance distance1 = distanceTo(contacted_, h);
  while (true) {
    const Primitive primitive1 = contacted_;
    bool changed = false;
    forNeighbours(primitive1, [&](const Primitive& primitive2) {
      ++looked;
      const Distance distance2 = distanceTo(primitive2, h);
      if (!(distance2.squared < distance1.squared)) return;
      contacted_ = primitive2;
      distance1 = distance2;
      changed = true;
    });
    if (!changed) break;
  }
  ClosestPoint at;
  at.triangle = contacted_.triangle;
  at.feature = contacted_.kind;
  at.index = static_cast<std::uint8_t>(contacted_.index);
  const Vec3 vector1 = distance1.point - h;
  if (glm::dot(vector1, surface().normal(at)) < 0) {
    collision_ = false;
    return {false, hip, Vec3(0), looked};
  }
  return {true, toWorld(pose, distance1.point), spring_N_per_m() * (pose.rotation * vector1), looked};
}

template <Primitives kPrimitives>
typename Pseudocode<kPrimitives>::Distance Pseudocode<kPrimitives>::distanceTo(const Primitive& primitive,
                                                                               Vec3 hip) const {
  const TriangleRecord& record = surface().triangle(primitive.triangle);
  const Distance none{std::numeric_limits<double>::infinity(), hip};
  if (primitive.kind == Feature::kVertex) {
    const Vec3 corner = record.corner(primitive.index);
    return {squaredLength(hip - corner), corner};
  }
  if (primitive.kind == Feature::kLine) {
    const Vec3x4 h = broadcast(hip);
    const Prism::OnEdges on = Prism(record).onEdges(h);
    if (kPrimitives == Primitives::kOpen && on.atCorner(primitive.index)) return none;
    return {on.squaredDistance[primitive.index], on.point[primitive.index]};
  }
  const ClosestPoint foot = closestOn(record, primitive.triangle, hip);
  if (kPrimitives == Primitives::kOpen && foot.feature != Feature::kPolygon) return none;
  return {foot.squaredDistance, foot.point};
}

template <Primitives kPrimitives>
template <class Visit>
void Pseudocode<kPrimitives>::forNeighbours(const Primitive& primitive, Visit visit) const {
  const std::uint32_t t = primitive.triangle;
  if (primitive.kind == Feature::kPolygon) {
    for (int k = 0; k < 3; ++k) visit(Primitive{Feature::kLine, t, k});
    for (int k = 0; k < 3; ++k) visit(Primitive{Feature::kVertex, t, k});
    return;
  }
  if (primitive.kind == Feature::kLine) {
    visit(Primitive{Feature::kVertex, t, primitive.index});
    visit(Primitive{Feature::kVertex, t, nextCorner(primitive.index)});
    visit(Primitive{Feature::kPolygon, t, 0});
    const std::uint32_t across = surface().triangle(t).neighbour(primitive.index);
    if (across != kNoTriangle) visit(Primitive{Feature::kPolygon, across, 0});
    return;
  }
  const auto polygonAndLine = [&](std::uint32_t polygon, int corner) {
    visit(Primitive{Feature::kLine, polygon, corner});
    visit(Primitive{Feature::kPolygon, polygon, 0});
    return true;
  };
  polygonAndLine(t, primitive.index);
  visitFan(surface(), t, primitive.index, polygonAndLine);
}

template class Pseudocode<Primitives::kClosed>;
template class Pseudocode<Primitives::kOpen>;

}  // namespace haptics::eval
