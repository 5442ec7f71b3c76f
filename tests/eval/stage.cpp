#include "tests/eval/stage.h"

#include <algorithm>

namespace haptics::eval {

Stage::Stage(Renderer& method, Random& random) : method_(method) {
  frame_.rotation = random.rotation();
  frame_.position = random.direction() * random.between(0, 0.1);
}

int Stage::add(std::shared_ptr<const CollisionMesh> surface, const Pose& pose) {
  ids_.push_back(++lastId_);
  surfaces_.push_back(std::move(surface));
  poses_.push_back(inWorld(pose));
  return static_cast<int>(surfaces_.size()) - 1;
}

void Stage::begin(Vec3 hip) { method_.begin(surfaces_, poses_, toWorld(frame_, hip)); }

void Stage::edit(Vec3 hip, double spring_N_per_m) {
  method_.edit({ids_, surfaces_, poses_, spring_N_per_m}, toWorld(frame_, hip));
}

void Stage::remove(int body) {
  ids_.erase(ids_.begin() + body);
  surfaces_.erase(surfaces_.begin() + body);
  poses_.erase(poses_.begin() + body);
}

Felt Stage::tick(Vec3 hip) {
  ++ticks_;
  return inFrame(method_.tick(poses_, toWorld(frame_, hip)));
}

Felt Stage::drive(Vec3 hip, bool samplesHaveCome) {
  ++ticks_;
  return inFrame(method_.drive(poses_, samplesHaveCome, toWorld(frame_, hip)));
}

Felt Stage::inFrame(Felt felt) const {
  felt.ihip = toLocal(frame_, felt.ihip);
  felt.force_N = glm::conjugate(frame_.rotation) * felt.force_N;
  if (felt.written_N) felt.written_N = glm::conjugate(frame_.rotation) * *felt.written_N;
  return felt;
}

double Stage::depthIn(int body, Vec3 point) const {
  const auto i = static_cast<std::size_t>(body);
  const CollisionMesh& surface = *surfaces_[i];
  if (!surface.closed()) return 0;
  const Vec3 local = toLocal(poses_[i], toWorld(frame_, point));
  if (glm::any(glm::lessThan(local, surface.low())) || glm::any(glm::greaterThan(local, surface.high()))) return 0;
  int spent = 0;
  const ClosestPoint foot = surface.closestFoot(local, static_cast<int>(surface.triangleCount()) + 1, spent);
  return surface.isOutside(foot, local) ? 0 : std::sqrt(foot.squaredDistance);
}

double Stage::depthInside(Vec3 point) const {
  double depth = 0;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) depth = std::max(depth, depthIn(static_cast<int>(i), point));
  return depth;
}

}  // namespace haptics::eval
