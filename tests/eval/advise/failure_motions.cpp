#include "tests/eval/advise/failure_motions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic_server/engine/step/haptic_step.h"
#include "tests/eval/winding.h"

namespace haptics::eval {
namespace {

constexpr double kPushed_m = 5e-4;  // a tick
constexpr double kStroked_m = 2e-3;
constexpr double kBeyond_m = 3e-3;  // where a push begins above the surface, and ends below the object

using Places = std::vector<Vec3>;

/// In steps of about this length, the last one at the end.
void append(Places& places, Vec3 to, double step_m) {
  const Vec3 from = places.back();
  const int steps = std::max(1, static_cast<int>(std::lround(glm::distance(from, to) / step_m)));
  for (int i = 1; i <= steps; ++i) places.push_back(glm::mix(from, to, static_cast<double>(i) / steps));
}

Places thereAndBack(Vec3 from, Vec3 to) {
  Places places{from};
  append(places, to, kPushed_m);
  append(places, from, kPushed_m);
  return places;
}

double lowestOf(const LoadedObject& object) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vec3f v : object.mesh->vertices) lowest = std::min(lowest, toWorld(object.pose, Vec3(v)).z);
  return lowest;
}

/// The vertex about which the triangles take the least of the full angle; object frame.
Vec3 sharpestCorner(const TriMesh& mesh) {
  std::vector<double> angle(mesh.vertices.size(), 0);
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 here(mesh.vertices[t[k]]);
      const Vec3 a = Vec3(mesh.vertices[t[(k + 1) % 3]]) - here, b = Vec3(mesh.vertices[t[(k + 2) % 3]]) - here;
      angle[t[k]] += std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    }
  }
  const auto isUsed = [&](double sum) { return sum > 0; };
  std::size_t sharpest = static_cast<std::size_t>(std::ranges::find_if(angle, isUsed) - angle.begin());
  for (std::size_t v = 0; v < angle.size(); ++v) {
    if (isUsed(angle[v]) && angle[v] < angle[sharpest]) sharpest = v;
  }
  return Vec3(mesh.vertices[sharpest]);
}

std::vector<Places> pressedThrough(const LoadedObject& object, const std::vector<HandStroke>& strokes) {
  std::vector<Places> all;
  const double below = lowestOf(object) - kBeyond_m;
  for (const HandStroke& hand : strokes) {
    const Vec3 middle = hand.stroke[hand.stroke.size() / 2];
    all.push_back(thereAndBack(middle + Vec3(0, 0, 2 * kBeyond_m), {middle.x, middle.y, below}));
  }
  return all;
}

std::vector<Places> pushedAtACorner(const LoadedObject& object) {
  const Vec3 corner = toWorld(object.pose, sharpestCorner(*object.mesh));
  const Vec3 middle = toWorld(object.pose, object.surface->centre());
  if (!(glm::distance(corner, middle) > 0)) return {};
  return {thereAndBack(corner + kBeyond_m * glm::normalize(corner - middle), middle)};
}

std::vector<Places> strokedFast(const std::vector<HandStroke>& strokes) {
  std::vector<Places> all;
  for (const HandStroke& hand : strokes) {
    Places& places = all.emplace_back(Places{hand.down.front()});
    append(places, hand.stroke.front(), kPushed_m);
    Vec3 last = places.back();
    for (const Vec3 place : hand.stroke) {
      if (glm::distance(place, last) < kStroked_m) continue;
      places.push_back(last = place);
    }
    append(places, hand.up.back(), kPushed_m);
  }
  return all;
}

FailureMotion judged(std::string name, const std::vector<Places>& motions, const ServoScene& scene,
                     const LoadedObject& object, const WindingMesh& inside) {
  const StepConfig config{.period_s = 1e-3, .maxForce_N = 1e9};
  FailureMotion result{.name = std::move(name)};
  for (const Places& places : motions) {
    HapticState state(config);
    (void)adoptScene(scene, state, 0);  // the first is always taken
    InsideTicks ticks;
    for (std::size_t tick = 0; tick < places.size(); ++tick) {
      const Vec3 ihip = hapticStep(scene, state, config, {tick, 0, {places[tick], DeviceState::kReady}}).ihip;
      ticks.see(inside.depthInside(glm::conjugate(object.pose.rotation) * (ihip - object.pose.position)));
    }
    result.insideTicks += ticks.all();
    result.longestInside = std::max(result.longestInside, ticks.longest());
    result.deepestInside_mm = std::max(result.deepestInside_mm, 1e3 * ticks.deepest_m());
  }
  return result;
}

}  // namespace

std::vector<FailureMotion> failureMotionsOf(const ServoScene& scene, const LoadedObject& object,
                                            const std::vector<HandStroke>& strokes) {
  if (!object.surface->closed()) return {};
  const WindingMesh inside(object.mesh->vertices, object.mesh->triangles);
  const auto judge = [&](const char* name, const std::vector<Places>& motions) {
    return judged(name, motions, scene, object, inside);
  };
  return {judge("pressed through", pressedThrough(object, strokes)),
          judge("pushed at its sharpest corner", pushedAtACorner(object)),
          judge("stroked at 2 m/s", strokedFast(strokes))};
}

}  // namespace haptics::eval
