#include "tests/eval/correction_figures/side_by_side.h"

#include <utility>

namespace haptics::eval {

SideBySide::SideBySide(std::unique_ptr<Renderer> without, std::unique_ptr<Renderer> with, Look look)
    : without_(std::move(without)), with_(std::move(with)), look_(std::move(look)) {}

void SideBySide::next(std::vector<std::shared_ptr<const CollisionMesh>> bodies) {
  before_ = std::exchange(now_, {std::move(bodies), {}});
}

void SideBySide::begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
                       Vec3 hip) {
  without_->begin(bodies, poses, hip);
  with_->begin(bodies, poses, hip);
  next({bodies.begin(), bodies.end()});
}

void SideBySide::place(Vec3 hip) {
  without_->place(hip);
  with_->place(hip);
  next(now_.bodies);
}

Felt SideBySide::tick(std::span<const Pose> poses, Vec3 hip) {
  const Felt without = without_->tick(poses, hip);
  now_.ticks.push_back({{poses.begin(), poses.end()}, hip, without, with_->tick(poses, hip)});
  look_(now_, before_);
  return without;
}

}  // namespace haptics::eval
