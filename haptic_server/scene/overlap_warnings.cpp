#include "haptic_server/scene/overlap_warnings.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/collision/moving_together.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {
namespace {

constexpr double kOverlap_m = 1e-4;           // bodies that rest on each other lie less deep
constexpr std::size_t kPointsOfBody = 256;    // of a body, evenly among its points
constexpr int kTrianglesOfEdit = 200'000;     // some milliseconds
constexpr int kTrianglesOfPoint = 1'000'000;  // as many as it takes

struct Meeting {
  const PlacedObject* object;
  const CollisionMesh* surface;
  const CollisionPoints* points;
  Pose pose;
  bool moves;

  [[nodiscard]] Vec3 centre() const { return toWorld(pose, surface->centre()); }
};

/// Colliding objects at known poses.
std::vector<Meeting> meetingOnes(std::span<const PlacedObject> objects) {
  std::vector<Meeting> meeting;
  for (const PlacedObject& object : objects) {
    const auto& motion = object.record->motion;
    const auto& body = object.assets->derived.body;
    if (!motion || !motion->collision || !body || !*body || !(*body)->collision) continue;
    if (!object.isPut && !motion->fixed) continue;
    const auto& shape = object.assets->derived.shape;
    const CollisionMesh* surface = shape ? shape.get() : object.assets->mesh->surface.get();
    if (surface == nullptr) continue;
    meeting.push_back({&object, surface, (*body)->collision.get(), object.record->pose, !motion->fixed});
  }
  return meeting;
}

/// How deep the deepest of a's points lies in b.
double depthOf(const Meeting& a, const Meeting& b, int& left) {
  if (!b.surface->closed()) return 0;
  const auto& points = a.points->points;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kPointsOfBody);
  double deepest_m = 0;
  for (std::size_t i = 0; i < points.size() && left > 0; i += stride) {
    const Vec3 in = toLocal(b.pose, toWorld(a.pose, points[i].place));
    if (glm::distance(in, b.surface->centre()) > b.surface->radius_m()) continue;
    int looked = 0;
    const ClosestPoint foot = b.surface->closestFoot(in, kTrianglesOfPoint, looked);
    left -= looked;
    if (!b.surface->isOutside(foot, in)) deepest_m = std::max(deepest_m, std::sqrt(foot.squaredDistance));
  }
  return deepest_m;
}

/// `a` moves.
std::string warningOf(const Meeting& a, const Meeting& b, double depth_m) {
  std::ostringstream text;
  text << a.object->record->name << ": warning: lies " << millimetres(depth_m) << " inside " << b.object->record->name
       << "; the two are pushed apart, by no more than " << kPushApart_m_per_s
       << " m/s, or jam where they are pushed both ways: put them beside each other, or let one meet no others (no "
          "collision)";
  return text.str();
}

}  // namespace

std::vector<std::string> overlapWarnings(std::span<const PlacedObject> objects) {
  const std::vector<Meeting> meeting = meetingOnes(objects);
  std::vector<std::string> warnings;
  int left = kTrianglesOfEdit;
  for (std::size_t i = 0; i < meeting.size(); ++i) {
    for (std::size_t k = i + 1; k < meeting.size(); ++k) {
      const Meeting& a = meeting[i];
      const Meeting& b = meeting[k];
      if (!(a.moves || b.moves) || !(a.object->isPut || b.object->isPut)) continue;
      if (glm::distance(a.centre(), b.centre()) > a.surface->radius_m() + b.surface->radius_m()) continue;
      const double depth_m = std::max(depthOf(a, b, left), depthOf(b, a, left));
      if (depth_m > kOverlap_m) warnings.push_back(a.moves ? warningOf(a, b, depth_m) : warningOf(b, a, depth_m));
      if (left <= 0 || warnings.size() == kMaxOverlapWarnings) return warnings;
    }
  }
  return warnings;
}

}  // namespace haptics
