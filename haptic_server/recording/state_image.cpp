#include "haptic_server/recording/state_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>
#include <type_traits>

#include "haptic_server/recording/image_bytes.h"
#include "haptic_server/recording/tool_image.h"

namespace haptics {
namespace {

/// Whether the bytes of flags that came from elsewhere are ones. To read them as flags before is undefined.
[[nodiscard]] bool areFlags(std::initializer_list<const bool*> flags) {
  return std::ranges::all_of(flags, [](const bool* flag) { return isFlag(*flag); });
}

[[nodiscard]] bool areFlagsWhole(const HapticState& state) {
  const Adoption& adoption = state.adoption;
  const SceneFeatures& features = state.features;
  bool whole =
      areFlags({&adoption.now, &adoption.contactBroken, &adoption.detailEdited, &adoption.fadingOut, &features.detail,
                &features.soft, &features.bumps, &features.varyingStiffness, &features.beingMoved,
                &features.pendingRemoval, &features.tool, &features.torqueFades, &state.supervision.attached,
                &state.groove.shaded, &state.motion.follows, &state.denting.isHeldUp});
  for (std::size_t i = 0; i < adoption.bodyCount; ++i) {
    whole = whole && areFlags({&state.bodies[i].pendingRemoval, &state.bodies[i].moving, &state.objects[i].beingMoved});
  }
  for (std::size_t i = 0; i < state.motion.count; ++i)
    whole = whole && areFlags({&state.moving[i].moved, &state.moving[i].collides});
  for (const BodyDent& dent : state.allDents()) whole = whole && areFlags({&dent.stays, &dent.pressed});
  return whole && state.surface.fade.how <= ShadingFade::How::kTogether;
}

[[nodiscard]] bool isContactOn(const ContactState& contact, const ServoScene& scene) {
  if (contact.mode > ContactState::Mode::kSeveralSurfaces || contact.feature > Feature::kVertex) return false;
  if (contact.holdingCount < 0 || contact.holdingCount > ContactState::kMaxHolding) return false;
  if (!areFlags({&contact.reprojected, &contact.unchecked})) return false;
  if (!(contact.reached >= 0 && contact.reached <= 1 && contact.stride > 0 && contact.stride <= 1)) return false;
  if (!isWithinWorld(contact.clear.centre) || !(contact.clear.radius_m >= 0 && contact.clear.radius_m <= kFarthest_m))
    return false;
  if (!isWithinWorld(contact.hip) || !isWithinWorld(contact.ihip) || !isWithinWorld(contact.local)) return false;
  for (const ContactSurface& held : contact.surfaces()) {
    const auto body = static_cast<std::size_t>(held.body);
    if (held.body < 0 || body >= scene.objects.size() || (held.side != 1 && held.side != -1)) return false;
    if (held.triangle >= scene.objects[body].surface->triangleCount()) return false;
  }
  return true;
}

[[nodiscard]] bool isMotionOf(const RigidState& state, const RigidBody& body) {
  if (state.touchingCount > state.touching.size() || state.condition > BodyCondition::kNonFinite) return false;
  if (!isPose(state.rest) || !isPose({state.axes, state.centre_m}) || !isPose(state.still)) return false;
  for (const PlanePoint& at : std::span(state.touching).first(state.touchingCount)) {
    if (at.plane >= body.planeCount || at.point >= body.support.size()) return false;
  }
  return true;
}

[[nodiscard]] bool isContactOf(const BodyContact& contact, const BodyPair& pair, const HapticState& state) {
  if (contact.second > 1) return false;
  const CollidingBody& on = state.colliding[contact.second == 0 ? pair.first : pair.second];
  if (contact.point >= on.points->points.size()) return false;
  return isWithinWorld(contact.place) && isWithinWorld(contact.foot) && isWithinWorld(contact.normal) &&
         isWithinWorld(contact.impulse_Ns);
}

/// Lists the bodies that collide as adoptScene() does. False: pairs name others.
[[nodiscard]] bool connectCollisions(HapticState& state, const ServoScene& scene) {
  std::size_t count = 0, moving = 0;
  for (std::size_t i = 0; i < state.adoption.bodyCount; ++i) {
    while (moving < state.motion.count && state.moving[moving].body < i) ++moving;
    const bool moves = moving < state.motion.count && state.moving[moving].body == i;
    const CollisionPoints* points = scene.objects[i].collision.get();
    if (moves && state.moving[moving].collides != (points != nullptr)) return false;
    if (points != nullptr) state.colliding[count++] = {i, moves ? static_cast<int>(moving) : -1, points};
  }
  if (count != state.motion.collidingCount) return false;
  for (const BodyPair& pair : state.pairs.all()) {
    if (pair.used == 0) continue;
    if (pair.used > 1 || pair.first >= count || pair.second >= count || pair.count > kPointsOfPair) return false;
    if (state.colliding[pair.first].moving < 0 || !isPose(pair.relative) || !isWithinWorld(pair.rolling_Nms))
      return false;
    if (!std::ranges::all_of(std::span(pair.contact).first(pair.count),
                             [&](const BodyContact& contact) { return isContactOf(contact, pair, state); }))
      return false;
  }
  const PairSearch& search = state.pairs.search;
  if (search.pair == 0) return true;
  if (search.pair > state.pairs.end || state.pairs.pair[search.pair - 1U].used == 0) return false;
  return std::ranges::all_of(search.found(), [&](const NearPoint& near) {
    return isContactOf(near.contact, state.pairs.pair[search.pair - 1U], state) && isWithinWorld(near.at) &&
           isWithinWorld(near.normal) && std::isfinite(near.gap_m);
  });
}

/// Gives the pointers back, and what follows from the rest. False: what they belong to is not in the scene.
[[nodiscard]] bool connect(HapticState& state, const ServoScene& scene) {
  for (std::size_t i = 0; i < state.adoption.bodyCount; ++i) {
    const ServoObject& object = scene.objects[i];
    Body& body = state.bodies[i];
    if (state.objects[i].id != object.id || !isPose(state.objects[i].scenePose)) return false;
    if (!isPose(body.previous) || !isPose(body.current)) return false;
    body.surface = object.surface.get();
    body.update();
    state.objects[i].detail = object.detail.get();
    state.objects[i].tissue = object.tissue.get();
    if (state.features.bumps && state.bumps[i].triangle != kNoTriangle &&
        state.bumps[i].triangle >= object.surface->triangleCount())
      return false;
  }
  for (std::size_t i = 0; i < state.motion.count; ++i) {
    MovingBody& moving = state.moving[i];
    if (moving.body >= state.adoption.bodyCount) return false;
    moving.what = scene.objects[moving.body].motion.get();
    if (moving.what == nullptr || !isMotionOf(moving.state, *moving.what)) return false;
  }
  if (!connectCollisions(state, scene)) return false;
  for (const BodyDent& dent : state.allDents()) {
    if (dent.body >= state.adoption.bodyCount || !scene.objects[dent.body].tissue) return false;
    for (const Dent& place : {dent.dent, dent.rest, dent.begun}) {
      if (!isWithinWorld(Vec3(place.centre)) || !isWithinWorld(Vec3(place.displacement))) return false;
    }
  }
  state.contact.polygon = {};
  return isContactOn(state.contact, scene);
}

/// @param torque  As it begins.
[[nodiscard]] bool takeTorque(std::string_view& image, DeviceTorque& torque) {
  const auto takeAll = [&](auto&... part) { return (take(image, part) && ...); };
  if (!std::apply(takeAll, DeviceTorque::partsOf(torque)) || !isRotation(torque.measured())) return false;
  return !torque.observer().active() || takeObserver(image, torque.observer());
}

[[nodiscard]] bool takeParts(std::string_view image, HapticState& state, const ServoScene& scene) {
  const auto takeAll = [&](auto&... part) { return (take(image, part) && ...); };
  if (!std::apply(takeAll, HapticState::partsOf(state)) || !take(image, state.contact)) return false;
  if (state.adoption.bodyCount != scene.objects.size() || state.adoption.bodyCount > state.bodies.size()) return false;
  if (state.motion.count > state.moving.size() || state.denting.count > state.dents.size()) return false;
  bool whole = true;
  for (std::size_t i = 0; i < state.adoption.bodyCount; ++i) {
    whole = whole && take(image, state.bodies[i]) && take(image, state.objects[i]) && take(image, state.bumps[i]);
  }
  for (std::size_t i = 0; i < state.motion.count; ++i) whole = whole && take(image, state.moving[i]);
  for (std::size_t i = 0; i < state.denting.count; ++i) whole = whole && take(image, state.dents[i]);
  whole = whole && take(image, state.pairs.end) && take(image, state.pairs.next);
  whole = whole && state.pairs.end <= kMaxPairs && (state.pairs.next == 0 || state.pairs.next < state.pairs.end);
  for (std::size_t i = 0; whole && i < state.pairs.end; ++i) whole = take(image, state.pairs.pair[i]);
  PairSearch& search = state.pairs.search;
  whole = whole && take(image, search.pair) && take(image, search.reverse) && take(image, search.node) &&
          take(image, search.count) && take(image, search.relative) && take(image, search.range_m) &&
          take(image, search.depth_m) && take(image, search.clear_m);
  whole = whole && search.count <= search.near.size();
  for (std::size_t i = 0; whole && i < search.count; ++i) whole = take(image, search.near[i]);
  if (!whole || !isFlag(state.features.tool) || !isFlag(state.features.torqueFades)) return false;
  if (state.features.tool && !ToolContactImage::takeFrom(image, scene, state.tool)) return false;
  if ((state.features.tool || state.features.torqueFades) && !takeTorque(image, state.tool.torque)) return false;
  if (!take(image, state.surface) || !take(image, state.energy) || !state.energy.isWhole()) return false;
  return (state.observer.active() ? takeObserver(image, state.observer) : true) && image.empty();
}

}  // namespace

std::uint64_t stateLayout() noexcept {
  using Parts = decltype(HapticState::partsOf(std::declval<const HapticState&>()));
  constexpr auto kSizes = []<class... Part>(std::type_identity<std::tuple<Part...>>) {
    return std::array{sizeof(Part)...,
                      sizeof(ContactState),
                      sizeof(Body),
                      sizeof(HapticState::ObjectState),
                      sizeof(BumpState),
                      sizeof(MovingBody),
                      sizeof(BodyPair),
                      sizeof(PairSearch),
                      sizeof(ToolContact),
                      sizeof(BodyDent),
                      sizeof(SurfaceMemory),
                      sizeof(EnergyAccount),
                      sizeof(PredictiveObserver),
                      sizeof(DeviceTorque)};
  }(std::type_identity<Parts>());
  std::uint64_t layout = 0;
  for (const std::size_t size : kSizes) layout = layout * 1'000'003 + size;
  return layout;
}

std::string stateImage(const HapticState& state) {
  static const BumpState kNoBumps{};  // static: what lies between their members is 0 too
  static const SurfaceMemory kNoMemory{};
  std::string image;
  std::apply([&](const auto&... part) { (put(image, part), ...); }, HapticState::partsOf(state));
  ContactState contact = state.contact;
  contact.polygon = {};  // follows from the scene
  put(image, contact);
  for (std::size_t i = 0; i < state.adoption.bodyCount; ++i) {
    Body body = state.bodies[i];
    body.surface = nullptr;
    HapticState::ObjectState object = state.objects[i];
    object.detail = nullptr;
    object.tissue = nullptr;
    put(image, body);
    put(image, object);
    put(image, state.features.bumps ? state.bumps[i] : kNoBumps);
  }
  for (std::size_t i = 0; i < state.motion.count; ++i) {
    MovingBody moving = state.moving[i];
    moving.what = nullptr;
    put(image, moving);
  }
  for (const BodyDent& dent : state.allDents()) put(image, dent);
  put(image, state.pairs.end);
  put(image, state.pairs.next);
  for (BodyPair pair : state.pairs.all()) {
    if (pair.used == 0) pair = {};
    std::fill(pair.contact.begin() + pair.count, pair.contact.end(), BodyContact{});
    put(image, pair);
  }
  const PairSearch& search = state.pairs.search;
  put(image, search.pair);
  put(image, search.reverse);
  put(image, search.node);
  put(image, search.count);
  put(image, search.relative);
  put(image, search.range_m);
  put(image, search.depth_m);
  put(image, search.clear_m);
  for (const NearPoint& near : search.found()) put(image, near);
  if (state.features.tool) ToolContactImage::append(state.tool, image);
  if (state.features.tool || state.features.torqueFades) {
    const DeviceTorque& torque = state.tool.torque;
    std::apply([&](const auto&... part) { (put(image, part), ...); }, DeviceTorque::partsOf(torque));
    if (torque.observer().active()) put(image, torque.observer());
  }
  put(image, state.features.detail ? state.surface : kNoMemory);
  put(image, state.energy);
  if (state.observer.active()) put(image, state.observer);
  return image;
}

Result<std::unique_ptr<HapticState>> stateFrom(std::string_view image, const ServoScene& scene,
                                               const StepConfig& config) {
  auto state = std::make_unique<HapticState>(config);
  if (!takeParts(image, *state, scene)) {
    return refused("state.image",
                   "is not that of a state on its scene, with " + std::to_string(scene.objects.size()) + " objects");
  }
  if (!areFlagsWhole(*state) || !connect(*state, scene)) {
    return refused("state.image", "is none that a servo can have had: it names what its scene has not");
  }
  return state;
}

}  // namespace haptics
