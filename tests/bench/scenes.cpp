#include "tests/bench/scenes.h"

#include <cmath>
#include <map>
#include <numbers>

#include "common/mesh/generators.h"

namespace haptics::bench {
namespace {

/// Aslant to the mesh's own axes, so that nothing is met at a special angle.
const Vec3 kUp = glm::normalize(Vec3(0.36, 0.48, 0.8));

Body bodyAt(std::uint32_t segments, Vec3 position) {
  Body body;
  body.surface = sphere(segments).get();
  body.previous = body.current = {{1, 0, 0, 0}, position};
  body.update();
  return body;
}

Scene sceneOf(std::vector<Body> bodies, std::vector<Vec3> path, Vec3 outside) {
  std::vector<Vec3> approach = wayTo(path.front(), outside);
  return {std::move(bodies), std::move(approach), std::move(path)};
}

}  // namespace

TriMesh sphereMesh(std::uint32_t segments) { return makeSphere(kRadius_m, segments).value(); }

std::shared_ptr<const CollisionMesh> sphere(std::uint32_t segments) {
  static std::map<std::uint32_t, std::shared_ptr<const CollisionMesh>> built;
  auto& surface = built[segments];
  if (!surface) {
    const TriMesh mesh = sphereMesh(segments);
    surface = buildCollisionMesh(mesh.vertices, mesh.triangles);
  }
  return surface;
}

std::string nameOf(const char* what, const Trajectory& trajectory, std::uint32_t segments) {
  return std::string(what) + "/" + trajectory.name + "/triangles:" + std::to_string(triangleCount(segments));
}

std::vector<Vec3> circle(Vec3 centre, Vec3 axis, double radius_m) {
  const Vec3 u = glm::normalize(glm::cross(axis, Vec3(0, 1, 0)));
  const Vec3 v = glm::cross(axis, u);
  const int count = static_cast<int>(std::ceil(2 * std::numbers::pi * radius_m / kStep_m));
  std::vector<Vec3> path;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    path.push_back(centre + (u * std::cos(angle) + v * std::sin(angle)) * radius_m);
  }
  return path;
}

std::vector<Vec3> wayTo(Vec3 place, Vec3 outside) {
  const int count = static_cast<int>(std::ceil(glm::distance(outside, place) / kStep_m));
  std::vector<Vec3> way;
  for (int i = 0; i < count; ++i) way.push_back(glm::mix(outside, place, 1.0 * i / count));
  return way;
}

Scene rubbing(std::uint32_t segments) {
  const Crossing top = sphere(segments)->firstCrossing(kUp * (2 * kRadius_m), Vec3(0));
  const double height_m = 2 * kRadius_m * (1 - top.time);
  return sceneOf({bodyAt(segments, Vec3(0))}, circle(kUp * (height_m - kDepth_m), kUp, kRubbingRadius_m),
                 kUp * (kRadius_m + kGap_m / 2));
}

Scene slide(std::uint32_t segments) {
  const auto path = circle(Vec3(0), kUp, kRadius_m - kDepth_m);
  return sceneOf({bodyAt(segments, Vec3(0))}, path, path.front() * 1.1);
}

Scene freeSpace(std::uint32_t segments) {
  const auto path = circle(Vec3(0), kUp, kRadius_m + kDepth_m);
  return sceneOf({bodyAt(segments, Vec3(0))}, path, path.front() * 1.1);
}

Scene secondBodyNear(std::uint32_t segments) {
  Scene scene = rubbing(segments);
  scene.bodies.push_back(bodyAt(segments, kUp * (2 * kRadius_m + kGap_m)));
  return scene;
}

Scene lineContact(std::uint32_t segments) {
  const double half_m = 0.8 * kRadius_m;  // of the distance of the centres
  const double groove_m = std::sqrt(kRadius_m * kRadius_m - half_m * half_m);
  const auto path = circle(Vec3(0), kUp, groove_m - kDepth_m);
  return sceneOf({bodyAt(segments, kUp * half_m), bodyAt(segments, kUp * -half_m)}, path, path.front() * 1.2);
}

Replay::Replay(Scene scene) : scene_(std::move(scene)) {
  resetContact(state_, scene_.approach.front());
  for (const Vec3 hip : scene_.approach) static_cast<void>(followContact(scene_.bodies, state_, hip, cache_));
  for (std::size_t i = 0; i < scene_.path.size(); ++i) static_cast<void>(tick());
}

Search::Search(Scene scene)
    : replay_(std::move(scene)),
      hip_(replay_.state().hip),
      foot_(heldFoot(*replay_.scene().bodies.front().surface, replay_.state(), hip_)) {}

void Search::searchFurther(const HipMotion& motion) noexcept {
  SearchRun run;
  double now = 0;
  for (int number = 1; now < 1; ++number) {
    const CollisionMesh& surface = *replay_.scene().bodies.front().surface;
    const HipStep step = followHip(surface, motion, 1, foot_, now, number, run);
    now = step.end;
    foot_ = step.found.foot;
  }
}

}  // namespace haptics::bench
