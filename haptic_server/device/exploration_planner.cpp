#include "haptic_server/device/exploration_planner.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "haptic_server/device/stroke_choice.h"

namespace haptics {
namespace {

/// Metres by which the hand passes above the highest point: more than it overshoots a movement in the air.
constexpr double kClearance = 0.02;

/// An object with its box in the world.
struct Placed {
  const ExploredObject* object;
  Vec3 low;
  Vec3 high;
};

Placed place(const ExploredObject& object) {
  const Vec3 half = (object.surface->high() - object.surface->low()) / 2.0;
  const glm::dmat3 axes = glm::mat3_cast(object.pose.rotation);
  Vec3 reach(0);
  for (int axis = 0; axis < 3; ++axis) reach += glm::abs(axes[axis]) * half[axis];
  const Vec3 middle = toWorld(object.pose, object.surface->centre());
  return {&object, middle - reach, middle + reach};
}

bool covers(const Placed& placed, double x, double y) {
  return x >= placed.low.x && x <= placed.high.x && y >= placed.low.y && y <= placed.high.y;
}

/// The first thing that a finger finds that comes down on one object alone.
std::optional<TopPoint> topOf(const Placed& placed, double x, double y) {
  const double beyond = (placed.high.z - placed.low.z) / 2;  // starts and ends well off the box, also for a flat object
  const double margin = beyond > 0 ? beyond : kClearance;
  const Vec3 from(x, y, placed.high.z + margin), to(x, y, placed.low.z - margin);
  const Pose& pose = placed.object->pose;
  const Crossing crossing = placed.object->surface->firstCrossing(toLocal(pose, from), toLocal(pose, to));
  if (!crossing) return std::nullopt;
  const Vec3 outward = pose.rotation * placed.object->surface->faceNormal(crossing.triangle);
  return TopPoint{glm::mix(from, to, crossing.time), outward * static_cast<double>(crossing.side)};
}

std::optional<TopPoint> visibleTop(const std::vector<Placed>& all, const Placed& placed, double x, double y) {
  const auto top = topOf(placed, x, y);
  if (!top) return top;
  for (const Placed& other : all) {
    if (&other == &placed || other.high.z <= top->position.z || !covers(other, x, y)) continue;
    const auto above = topOf(other, x, y);
    if (above && above->position.z > top->position.z) return std::nullopt;
  }
  return top;
}

}  // namespace

ExplorationPlan makeExplorationPlan(std::span<const ExploredObject> objects) {
  std::vector<Placed> placed;
  placed.reserve(objects.size());
  std::ranges::transform(objects, std::back_inserter(placed), place);

  ExplorationPlan plan;
  double highest = -std::numeric_limits<double>::infinity();
  for (const Placed& each : placed) {
    highest = std::max(highest, each.high.z);
    const auto view = [&](double x, double y) { return visibleTop(placed, each, x, y); };
    auto points = chooseStroke(view, each.low, each.high);
    if (!points.empty()) plan.strokes.push_back({each.object->id, std::move(points)});
  }
  if (!placed.empty()) plan.clearHeight_m = highest + kClearance;
  return plan;
}

}  // namespace haptics
