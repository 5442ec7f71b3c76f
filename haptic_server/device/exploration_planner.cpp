#include "haptic_server/device/exploration_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "common/maths/elementary.h"
#include "haptic_server/device/stroke_choice.h"

namespace haptics {
namespace {

/// Metres by which the hand passes above the highest point: more than it overshoots a movement in the air.
constexpr double kClearance = 0.02;

constexpr int kPushDirections = 16;  // directions, all around, from which a push is tried
/// Of the object's height, where it is pushed: above its middle, so that what is tall tips over. Of its half width, how far
/// beside its middle: so that it turns.
constexpr double kPushHeight = 0.65;
constexpr double kPushAside = 0.3;
/// Metres: from beside the object to it, and how far it is then pushed. Points of a push are this far apart.
constexpr double kRunUp = 0.015;
constexpr double kPushWay = 0.04;
constexpr double kPushSpacing = 0.004;
constexpr double kClose = 1e-4;    // metres before the object where the way to it ends
constexpr double kSteepest = 0.8;  // cosine of the angle at which a side is still pushed and not slid along
/// How much a push across a thin object counts against one towards the middle of the scene.
constexpr double kThinBonus = 1.5;

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

bool isFree(const std::vector<Placed>& all, Vec3 from, Vec3 to) {
  return std::ranges::none_of(all, [&](const Placed& placed) {
    const Pose& pose = placed.object->pose;
    return bool(placed.object->surface->firstCrossing(toLocal(pose, from), toLocal(pose, to)));
  });
}

/// A push from a side that is free and faces the hand, towards the middle of the scene, across the object's thin way where
/// there is one. Empty where there is none.
std::vector<Vec3> choosePush(const std::vector<Placed>& all, const Placed& placed, Vec3 sceneMiddle,
                             double clearHeight) {
  const Pose& pose = placed.object->pose;
  const Vec3 middle = (placed.low + placed.high) / 2.0;
  const Vec3 half = placed.high - middle;
  Vec3 inwards = sceneMiddle - middle;
  inwards.z = 0;
  const double away = glm::length(inwards);
  std::vector<Vec3> best;
  double bestScore = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < kPushDirections; ++k) {
    const auto [sine, cosine] = elementary::sineCosine(2 * std::numbers::pi * k / kPushDirections);
    const Vec3 along(cosine, sine, 0);
    const Vec3 across(-along.y, along.x, 0);
    const double reach = glm::dot(half, glm::abs(along));
    const double score = (away > 0 ? glm::dot(along, inwards) / away : 0) - kThinBonus * reach / glm::length(half);
    if (score <= bestScore) continue;
    const Vec3 aim(middle.x, middle.y, std::lerp(placed.low.z, placed.high.z, kPushHeight));
    const Vec3 through = aim + kPushAside * glm::dot(half, glm::abs(across)) * across;
    const Vec3 from = through - (reach + kRunUp) * along;
    const Crossing hit = placed.object->surface->firstCrossing(toLocal(pose, from), toLocal(pose, through));
    if (!hit) continue;
    const Vec3 facing = pose.rotation * placed.object->surface->faceNormal(hit.triangle) * double(hit.side);
    const Vec3 met = glm::mix(from, through, hit.time);
    if (-glm::dot(facing, along) < kSteepest || !isFree(all, Vec3(from.x, from.y, clearHeight), from)) continue;
    if (!isFree(all, from, met - kClose * along)) continue;
    bestScore = score;
    const double length = glm::distance(from, met) + kPushWay;
    const auto steps = static_cast<std::size_t>(std::ceil(length / kPushSpacing));
    best.clear();
    for (std::size_t i = 0; i <= steps; ++i) best.push_back(from + length * double(i) / double(steps) * along);
  }
  return best;
}

}  // namespace

ExplorationPlan ExplorationPlanner::plan(std::span<const ExploredObject> objects) {
  std::vector<Placed> placed;
  placed.reserve(objects.size());
  std::ranges::transform(objects, std::back_inserter(placed), place);

  ExplorationPlan plan;
  std::map<std::uint64_t, Choice> choices;
  Vec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (const Placed& each : placed) {
    low = glm::min(low, each.low);
    high = glm::max(high, each.high);
  }
  if (!placed.empty()) plan.clearHeight_m = high.z + kClearance;
  for (const Placed& each : placed) {
    const auto hiding = above(placed, each);
    Choice choice{{*each.object}, {}, {}};
    for (const Placed* other : hiding) choice.from.push_back(*other->object);
    const auto last = choices_.find(each.object->id);
    if (last != choices_.end() && last->second.from == choice.from) {
      choice.points = last->second.points;  // not taken: this may be interrupted
    } else {
      const auto view = [&](double x, double y) { return visibleTop(hiding, each, x, y); };
      choice.points = chooseStroke(view, each.low, each.high);
    }
    if (each.object->moves) choice.push = choosePush(placed, each, (low + high) / 2.0, plan.clearHeight_m);
    if (!choice.points.empty()) plan.strokes.push_back({each.object->id, choice.points});
    if (!choice.push.empty()) plan.strokes.push_back({each.object->id, choice.push, true});
    choices[each.object->id] = std::move(choice);
  }
  choices_ = std::move(choices);
  return plan;
}

}  // namespace haptics
