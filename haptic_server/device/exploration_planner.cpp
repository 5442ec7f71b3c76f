#include "haptic_server/device/exploration_planner.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
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

/// Those that may hide parts of one object from above.
std::vector<const Placed*> above(const std::vector<Placed>& all, const Placed& placed) {
  std::vector<const Placed*> above;
  for (const Placed& other : all) {
    const bool beside = other.low.x > placed.high.x || other.high.x < placed.low.x || other.low.y > placed.high.y ||
                        other.high.y < placed.low.y;
    if (&other != &placed && !beside && other.high.z > placed.low.z) above.push_back(&other);
  }
  return above;
}

std::optional<TopPoint> visibleTop(const std::vector<const Placed*>& above, const Placed& placed, double x, double y) {
  const auto top = topOf(placed, x, y);
  if (!top) return top;
  for (const Placed* other : above) {
    if (other->high.z <= top->position.z || !covers(*other, x, y)) continue;
    const auto hiding = topOf(*other, x, y);
    if (hiding && hiding->position.z > top->position.z) return std::nullopt;
  }
  return top;
}

}  // namespace

ExplorationPlan makeExplorationPlan(std::span<const ExploredObject> objects) {
  return ExplorationPlanner().plan(objects);
}

ExplorationPlan ExplorationPlanner::plan(std::span<const ExploredObject> objects) {
  std::vector<Placed> placed;
  placed.reserve(objects.size());
  std::ranges::transform(objects, std::back_inserter(placed), place);

  ExplorationPlan plan;
  std::map<std::uint64_t, Choice> choices;
  double highest = -std::numeric_limits<double>::infinity();
  for (const Placed& each : placed) {
    highest = std::max(highest, each.high.z);
    const auto hiding = above(placed, each);
    Choice choice{{*each.object}, {}};
    for (const Placed* other : hiding) choice.from.push_back(*other->object);
    const auto last = choices_.find(each.object->id);
    if (last != choices_.end() && last->second.from == choice.from) {
      choice.points = std::move(last->second.points);
    } else {
      const auto view = [&](double x, double y) { return visibleTop(hiding, each, x, y); };
      choice.points = chooseStroke(view, each.low, each.high);
    }
    if (!choice.points.empty()) plan.strokes.push_back({each.object->id, choice.points});
    choices[each.object->id] = std::move(choice);
  }
  if (!placed.empty()) plan.clearHeight_m = highest + kClearance;
  choices_ = std::move(choices);
  return plan;
}

}  // namespace haptics
