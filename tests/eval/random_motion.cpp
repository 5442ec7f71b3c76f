#include "tests/eval/random_motion.h"

#include <algorithm>
#include <cmath>

#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

/// For so long a method may keep the shape before an edit, to let the contact on it fade.
constexpr int kTicksToAdopt = 300;

}  // namespace

void RandomMotion::add(shapes::Shape shape, const Pose& pose) {
  auto surface = shape.build();
  WindingMesh mesh(shape.vertices, shape.triangles);
  bodies_.push_back({std::move(shape), std::move(surface), std::move(mesh), pose});
}

void RandomMotion::refit(std::size_t body, const shapes::Shape& moved) {
  Moved& changed = bodies_[body];
  changed.shape = moved;
  changed.surface = refitCollisionMesh(*changed.surface, moved.vertices);
  changed.meshBefore = std::exchange(changed.mesh, WindingMesh(moved.vertices, moved.triangles));
  changed.ticksSinceEdit = 0;
  edited_ = body;
}

/// Under a face of one of the bodies.
void RandomMotion::chooseTarget() {
  riddenBody_ = static_cast<std::size_t>(random_.below(static_cast<int>(bodies_.size())));
  const shapes::Shape& shape = bodies_[riddenBody_].shape;
  const auto t = static_cast<std::size_t>(random_.below(static_cast<int>(shape.triangles.size())));
  const Vec3 a = shape.corner(t, 0);
  const Vec3 b = shape.corner(t, 1) - a;
  const Vec3 c = shape.corner(t, 2) - a;
  const double u = random_.between(0, 1);
  const double v = random_.between(0, 1 - u);
  target_ = a + u * b + v * c - random_.between(0, kDeepest_m) * glm::normalize(glm::cross(b, c));
  const bool stands = random_.below(4) == 0;
  speed_m_per_s_ = stands ? 0 : 0.02 * std::pow(50, random_.between(0, 1));
  ticksLeft_ = 30 + random_.below(400);
}

void RandomMotion::next(Vec3 ihip) {
  constexpr double kQuickest_m_per_s = 4;
  edited_.reset();
  for (Moved& body : bodies_) ++body.ticksSinceEdit;
  moveBodies(ihip);
  if (--ticksLeft_ <= 0) chooseTarget();
  const auto limited = [](Vec3 way, double most) {
    const double length = glm::length(way);
    return length > most ? way * (most / length) : way;
  };
  hip_ += limited(toWorld(bodies_[riddenBody_].pose, target_) - hip_, speed_m_per_s_ * kPeriod_s);
  const double depth = glm::distance(ihip, hip_);
  if (depth > kDeepest_m) hip_ += limited((ihip - hip_) * (1 - kDeepest_m / depth), kQuickest_m_per_s * kPeriod_s);
}

double RandomMotion::depthInside(Vec3 point) const {
  double depth = 0;
  for (const Moved& body : bodies_) {
    const Vec3 local = toLocal(body.pose, point);
    const double now = body.mesh.depthInside(local);
    const bool adopting = body.meshBefore && body.ticksSinceEdit < kTicksToAdopt;
    depth = std::max(depth, adopting ? std::min(now, body.meshBefore->depthInside(local)) : now);
  }
  return depth;
}

void leadThrough(Renderer& method, RandomMotion& motion, int ticks, Random& random, MotionCounts& counts) {
  Stage stage(method, random);
  for (const RandomMotion::Moved& body : motion.bodies()) stage.add(body.surface, body.pose);
  Vec3 ihip = motion.hip();
  stage.begin(ihip);
  for (int i = 0; i < ticks; ++i) {
    const Vec3 hipBefore = motion.hip();
    motion.next(ihip);
    if (const auto edited = motion.edited()) {
      stage.replace(static_cast<int>(*edited), motion.bodies()[*edited].surface);
      stage.edit(hipBefore);
    }
    for (std::size_t b = 0; b < motion.bodies().size(); ++b) stage.move(static_cast<int>(b), motion.bodies()[b].pose);
    const Felt felt = stage.tick(motion.hip());
    ++counts.ticks;
    counts.contact += felt.touching ? 1 : 0;
    const bool finite = isFinite(felt.ihip) && isFinite(felt.force_N);
    counts.notFinite += finite ? 0 : 1;
    ihip = finite ? felt.ihip : motion.hip();
    counts.inside.see(motion.depthInside(ihip));
    if (!finite) stage.place(motion.hip());
  }
}

}  // namespace haptics::eval
