#include "haptic_server/recording/state_image.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics {
namespace {

[[nodiscard]] bool isPose(const Pose& pose) { return isWithinWorld(pose.position) && isRotation(pose.rotation); }
[[nodiscard]] bool isAmount(double value) { return std::isfinite(value) && value >= 0; }

[[nodiscard]] bool isContactOn(const ContactState& contact, const ServoScene& scene) {
  if (contact.holdingCount < 0 || contact.holdingCount > ContactState::kMaxHolding) return false;
  if (!(contact.reached >= 0 && contact.reached <= 1 && contact.stride > 0 && contact.stride <= 1)) return false;
  if (!isWithinWorld(contact.clear.centre) || !(contact.clear.radius_m >= 0 && contact.clear.radius_m <= kFarthest_m))
    return false;
  if (!isWithinWorld(contact.hip) || !isWithinWorld(contact.ihip) || !isWithinWorld(contact.local)) return false;
  return std::ranges::all_of(contact.surfaces(), [&](const ContactSurface& held) {
    const auto body = static_cast<std::size_t>(held.body);
    return held.body >= 0 && body < scene.objects.size() && (held.side == 1 || held.side == -1) &&
           held.triangle < scene.objects[body].surface->triangleCount();
  });
}

[[nodiscard]] bool isMotionOf(const RigidState& state, const RigidBody& body) {
  return isPose(state.rest) && isPose({state.axes, state.centre_m}) && isPose(state.still) &&
         std::ranges::all_of(state.touching.all(), [&](const PlanePoint& at) {
           return at.plane < body.planeCount && at.point < body.support.size();
         });
}

[[nodiscard]] bool isContactOf(const BodyContact& contact, const BodyPair& pair, const HapticState& state) {
  if (contact.second > 1) return false;
  const CollisionPoints &first = *state.colliding[pair.first].points, &second = *state.colliding[pair.second].points;
  const std::size_t points = first.polytope || second.polytope ? PolytopeContact::kIds
                             : contact.second == 0             ? first.points.size()
                                                               : second.points.size();
  return contact.point < points && isWithinWorld(contact.place) && isWithinWorld(contact.foot) &&
         isWithinWorld(contact.normal) && isFinite(contact.impulse_Ns);
}

[[nodiscard]] bool areCollisions(const HapticState& state) {
  const auto isPair = [&](const BodyPair& pair) {
    if (pair.used == 0) return true;
    const std::size_t count = state.collidingCount;
    return pair.used == 1 && pair.first < count && pair.second < count && state.colliding[pair.first].moving >= 0 &&
           isPose(pair.relative) && isFinite(pair.rolling_Nms) &&
           std::ranges::all_of(pair.contacts.all(),
                               [&](const BodyContact& contact) { return isContactOf(contact, pair, state); });
  };
  const BodyPairs& pairs = state.pairs;
  if (!std::ranges::all_of(pairs.all(), isPair) || (pairs.next != 0 && pairs.next >= pairs.places.count)) return false;
  const PairSearch& search = pairs.search;
  if (search.pair == 0) return true;
  if (search.pair > pairs.places.count || pairs.places[search.pair - 1U].used == 0) return false;
  return std::ranges::all_of(search.near.all(), [&](const NearPoint& near) {
    return isContactOf(near.contact, pairs.places[search.pair - 1U], state) && isWithinWorld(near.at) &&
           isWithinWorld(near.normal) && std::isfinite(near.gap_m);
  });
}

[[nodiscard]] bool isTool(const HapticState& state) {
  const ToolMemory& tool = state.tool.memory;
  const auto& jaws = state.toolScratch.tool->jaws;
  const std::size_t all = tool.clearTo.count + tool.sharpClearTo.count;
  const auto isTouch = [&](const ToolTouch& touch) {
    if (touch.ofBody > (jaws ? 2 : 1) || touch.body >= tool.bodies.count || (touch.side != 1 && touch.side != -1))
      return false;
    const ServoObject& object = state.scene->objects[touch.body];
    const CollisionMesh& own = touch.ofBody == 2 ? *jaws->lower : *state.toolScratch.tool->surface;
    const CollisionMesh& surface = touch.ofBody != 0 ? own : *object.surface;
    const std::size_t points =
        touch.ofBody != 0 ? state.toolScratch.sharp[touch.body].points.size() : tool.clearTo.count;
    return touch.triangle < surface.triangleCount() && touch.point < points && isWithinWorld(touch.place) &&
           isWithinWorld(touch.normal) && std::isfinite(touch.offset);
  };
  const auto isObstacle = [](const ToolObstacleState& body) { return isPose(body.at) && isAmount(body.travelled); };
  const auto isNumber = [](double value) { return std::isfinite(value); };
  const auto isToolPose = [](const ToolPose& pose) { return isPose(pose) && isAmount(pose.opening_rad); };
  return tool.cursor < all && isToolPose(tool.proxy) && tool.wayTested <= all && isToolPose(tool.way) &&
         isAmount(tool.moved) && isAmount(tool.travelled) && isAmount(tool.skin) && tool.bodiesPart > 0 &&
         tool.bodiesPart <= 1 && isAmount(tool.testCost) && tool.testCost > 0 &&
         std::ranges::all_of(tool.bodies.all(), isObstacle) && std::ranges::all_of(tool.touches.all(), isTouch) &&
         std::ranges::all_of(tool.clearTo.all(), isNumber) && std::ranges::all_of(tool.sharpClearTo.all(), isNumber);
}

[[nodiscard]] bool isGrasp(const HapticState& state) {
  const Grasp& grasp = state.grasp;
  if (!isWithinWorld(grasp.place) || !isRotation(grasp.turned) || !isRotation(grasp.device)) return false;
  return grasp.object == 0 ||
         (grasp.moving < state.moving.count && state.objects[state.moving[grasp.moving].body].id == grasp.object);
}

/// Of a connected state: what its scene has, as adoptScene() notes it.
[[nodiscard]] bool areFeaturesOf(const HapticState& state) {
  SceneFeatures features = state.features;
  bool detail = state.moving.count > 0 || state.features.tool || state.features.taps, soft = false, bumps = false,
       varies = false;
  bool taps = state.surface.tap.rings();
  for (const ServoObject& object : state.scene->objects) {
    taps = taps || (object.detail && object.detail->scalars.tap_Ns_per_m > 0);
    soft = soft || object.tissue != nullptr;
    detail = detail || object.detail != nullptr;
    bumps = bumps || (object.detail && object.detail->hasHeight());
    varies = varies || (object.detail && object.detail->stiffness);
  }
  features.detail = detail || soft;
  features.taps = taps || state.features.taps;  // what has rung out is forgotten at the next adoption
  features.soft = soft;
  features.bumps = bumps;
  features.varyingStiffness = varies;
  return firstDifference(features, state.features).empty() &&
         (state.bumps.count > 0) == (bumps && state.objects.count > 0);
}

/// Of a connected state: numbers by which the step finds something in its scene, or goes on counting.
[[nodiscard]] bool isOnItsScene(const HapticState& state) {
  const ServoScene& scene = *state.scene;
  const auto isObject = [](const ObjectState& object) {
    return isPose(object.scenePose) && isPose(object.previous) && isPose(object.current);
  };
  const auto isDent = [&](const BodyDent& dent) {
    return dent.body < scene.objects.size() && scene.objects[dent.body].tissue != nullptr &&
           std::ranges::all_of(std::array{dent.dent, dent.rest, dent.begun}, [](const Dent& place) {
             return isWithinWorld(Vec3(place.centre)) && isWithinWorld(Vec3(place.displacement));
           });
  };
  for (std::size_t i = 0; i < state.bumps.count; ++i) {
    const std::uint32_t triangle = state.bumps[i].triangle;
    if (triangle != kNoTriangle && triangle >= scene.objects[i].surface->triangleCount()) return false;
  }
  if ((state.driven.count > 0) != (scene.anyDriven() && state.objects.count > 0)) return false;
  return areFeaturesOf(state) && std::ranges::all_of(state.objects.all(), isObject) &&
         std::ranges::all_of(state.moving.all(),
                             [&](const MovingBody& body) { return isMotionOf(body.state, state.rigidBody(body)); }) &&
         (state.moving.count == 0 || state.motion.next < state.moving.count) && areCollisions(state) &&
         std::ranges::all_of(state.dents.all(), isDent) && isContactOn(state.contact, scene) &&
         state.energy.isWhole() && isGrasp(state) && (!state.features.tool || isTool(state));
}

}  // namespace

std::uint64_t stateLayout() noexcept { return layoutOf<StateFields>(); }

std::string stateImage(const StateFields& state) {
  std::string image;
  putFields(image, state);
  return image;
}

Result<std::unique_ptr<HapticState>> stateFrom(std::string_view image, const ServoScene& scene,
                                               const StepConfig& config) {
  auto state = std::make_unique<HapticState>(config);
  const auto begun = std::make_unique<const HapticState>(config);
  if (!takeFields(image, static_cast<StateFields&>(*state)) || !image.empty() || !state->connect(scene)) {
    return refused("state.image",
                   "is not that of a state on its scene, with " + std::to_string(scene.objects.size()) + " objects");
  }
  if (!begun->observer.couldBecome(state->observer) || !begun->tool.torque.couldBecome(state->tool.torque) ||
      !isOnItsScene(*state)) {
    return refused("state.image", "is none that a servo can have had: it names what its scene has not");
  }
  return state;
}

}  // namespace haptics
