#include "tests/eval/fuzz/contact_scene.h"

#include <algorithm>
#include <cmath>

#include "tests/eval/fuzz/contact_judge.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {
namespace {

constexpr int kMaxBodies = 5;

Pose poseIn(const Pose& frame, const Pose& local) {
  return {glm::normalize(frame.rotation * local.rotation), toWorld(frame, local.position)};
}

MeshKind someKind(bool plain, Random& random) {
  const int draw = random.below(20);
  if (!plain && draw < 3) return MeshKind::kFolded;
  if (!plain && draw < 6) return MeshKind::kScan;
  if (!plain && draw < 7) return MeshKind::kSheet;
  if (draw < 13) return MeshKind::kBox;
  return draw < 17 ? MeshKind::kBlob : MeshKind::kSpiky;
}

}  // namespace

ContactScene::ContactScene(std::uint64_t seed, ContactSceneKind kind)
    : kind_(kind), random_(seed), speed_m_per_s_(kind.speed_m_per_s) {
  switch (kind.world) {
    case ContactWorld::kWild: {
      const bool plain = random_.below(2) == 0;
      const int bodies = 1 + random_.below(kMaxBodies);
      for (int i = 0; i < bodies; ++i) addBody(someKind(plain, random_));
      break;
    }
    case ContactWorld::kFlush:
      addFloor(flushBoxes(1, random_));
      break;
    case ContactWorld::kCracked:
      addFloor(crackedMesh(1, random_));
      break;
    case ContactWorld::kMirrored:
      for (int i = 1 + random_.below(3); i > 0; --i) addBody(MeshKind::kMirrored);
      if (random_.below(2) == 0) addBody(someKind(true, random_));
      break;
    case ContactWorld::kThin:
      for (int i = 1 + random_.below(2); i > 0; --i) addBody(MeshKind::kPlate);
      if (random_.below(2) == 0) addBody(someKind(true, random_));
      break;
  }
  frame_.hip = somewhereOutside();
}

/// Away from every closed body.
Vec3 ContactScene::somewhereOutside() {
  constexpr double kNearest_m = 0.02;
  constexpr double kFarther = 1.1;
  Vec3 place = kNearest_m * random_.direction();
  while (!ContactJudge::isOutside(meshes_, {place, frame_.poses})) place *= kFarther;
  return place;
}

void ContactScene::addBody(MeshKind kind) {
  constexpr double kMovingPart = 0.7;
  meshes_.push_back(makeMesh(kind, random_));
  swings_.push_back(someSwing(kind_.moving && random_.between(0, 1) < kMovingPart));
  frame_.poses.push_back(swings_.back().middle);
}

/// Its bodies keep where they are to one another.
void ContactScene::addFloor(const Floor& floor) {
  swings_.push_back(someSwing(kind_.moving));
  for (const Tile& tile : floor.tiles) {
    FuzzMesh mesh{tile.shape.vertices, tile.shape.triangles, {}};
    mesh.missing = coneOverBoundary(mesh.vertices, mesh.triangles);
    meshes_.push_back(std::move(mesh));
    inFloor_.push_back(tile.pose);
    frame_.poses.push_back(poseIn(swings_.front().middle, tile.pose));
  }
  const Quat back = glm::conjugate(inFloor_.front().rotation);
  flat_ = {{back, back * -inFloor_.front().position}, floor.low, floor.high};
}

ContactScene::Swing ContactScene::someSwing(bool moves) {
  constexpr double kSpread_m = 0.02;
  Swing swing;
  swing.middle.rotation = random_.rotation();
  swing.middle.position = kSpread_m * normalVector(random_);
  if (moves) {
    swing.amplitude_m = kSpread_m * normalVector(random_);
    swing.axis = random_.direction();
    swing.rate_rad_per_s = kind_.haste * random_.between(2, 12);
    swing.spin_rad_per_s = kind_.haste * random_.between(0, 5);
  }
  return swing;
}

Pose ContactScene::poseAt(const Swing& swing) const {
  if (swing.spin_rad_per_s == 0) return swing.middle;
  return {glm::normalize(glm::angleAxis(swing.spin_rad_per_s * time_s_, swing.axis) * swing.middle.rotation),
          swing.middle.position + swing.amplitude_m * std::sin(swing.rate_rad_per_s * time_s_)};
}

/// A place near a triangle of some body, for a time, at some speed, or none.
void ContactScene::chooseTarget() {
  constexpr double kBeside_m = 0.005;
  constexpr double kMinDepth_m = 0.0005;
  constexpr double kMaxDepth_m = 0.0125;
  const auto body = static_cast<std::size_t>(random_.below(static_cast<int>(meshes_.size())));
  const FuzzMesh& mesh = meshes_[body];
  Vec3 place = mesh.middleOf(static_cast<std::size_t>(random_.below(static_cast<int>(mesh.triangles.size()))));
  constexpr double kFarthest_m = 0.08;  // of a sheet only the middle
  if (glm::length(place) > kFarthest_m) place *= kFarthest_m / glm::length(place);
  target_ = toWorld(frame_.poses[body], place) + kBeside_m * normalVector(random_);
  ticksToTarget_ = 20 + random_.below(300);
  speed_m_per_s_ = kind_.speed_m_per_s * std::pow(10, random_.between(-2, 0));
  const double depth = random_.between(0, 1);
  deepest_m_ = kMinDepth_m + (kMaxDepth_m - kMinDepth_m) * depth * depth;
  const int still = random_.below(10);
  if (still < (kind_.moving ? 3 : 1)) speed_m_per_s_ = 0;
}

const ContactFrame& ContactScene::next(Vec3 ihip) {
  constexpr double kInertia = 0.9;  // of the velocity, a tick
  constexpr double kTremor = 0.08;
  constexpr double kDrawBack = 1.5;
  time_s_ += kPeriod_s;
  for (std::size_t i = 0; i < meshes_.size(); ++i)
    frame_.poses[i] = inFloor_.empty() ? poseAt(swings_[i]) : poseIn(poseAt(swings_.front()), inFloor_[i]);
  if (ticksToTarget_-- <= 0) chooseTarget();
  const Vec3 way = target_ - frame_.hip;
  Vec3 wanted = way * (speed_m_per_s_ / std::max(glm::length(way), 1e-4));
  const Vec3 back = ihip - frame_.hip;
  const double depth = glm::length(back);
  if (depth > deepest_m_) wanted += back * (kDrawBack * speed_m_per_s_ / depth);
  velocity_m_per_s_ =
      kInertia * velocity_m_per_s_ + (1 - kInertia) * wanted + kTremor * speed_m_per_s_ * normalVector(random_);
  if (speed_m_per_s_ == 0) velocity_m_per_s_ = Vec3(0);
  const double speed = glm::length(velocity_m_per_s_);
  if (speed > kind_.speed_m_per_s) velocity_m_per_s_ *= kind_.speed_m_per_s / speed;
  frame_.hip += velocity_m_per_s_ * kPeriod_s;
  return frame_;
}

}  // namespace haptics::eval
