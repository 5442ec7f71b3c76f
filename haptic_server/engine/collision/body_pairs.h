#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/motion_state.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/geometry/allowance.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/motion/rigid_body.h"

namespace haptics {

/// A body that meets others, in a tick. World frame, metres.
struct Collider {
  const CollisionMesh* surface = nullptr;
  const CollisionPoints* points = nullptr;
  Pose pose;
  const RigidBody* rigidBody = nullptr;  ///< Null: it stands still, or is driven.
  RigidState* state = nullptr;           ///< Likewise.
  Push push;
  bool absent = false;     ///< Meets nothing in this tick.
  bool isPut = false;      ///< It has not moved to where it is: it may be inside others.
  bool isDriven = false;   ///< It has no state, and moves all the same: as `before` says, whatever it meets.
  RigidVelocity before{};  ///< What the last tick left it, before this one's forces; of pivot().

  /// The centre of mass; of one without a state its origin. World.
  [[nodiscard]] Vec3 pivot() const noexcept {
    return state == nullptr ? pose.position : toWorld(pose, rigidBody->mass.centre);
  }
  /// Of a place of the world, m/s.
  [[nodiscard]] Vec3 velocityBefore(Vec3 place) const noexcept {
    return before.linear + glm::cross(before.angular, place - pivot());
  }
};

/// At most so many bodies meet one another, those that stand still included.
inline constexpr std::size_t kMaxColliders = 256;
/// Pairs of bodies that are near each other; further ones pass through each other.
inline constexpr std::size_t kMaxPairs = 192;
inline constexpr std::size_t kPointsOfPair = 8;

/// A point of one body at the surface of another.
struct BodyContact {
  std::uint32_t point;   ///< Of the body's CollisionPoints; of two polytopes PolytopeContact::Point::id.
  std::uint32_t second;  ///< 1: of the pair's second body, at the first one's surface; 0: the other way round.
  Vec3 place;            ///< The point; its body's frame.
  Vec3 foot;             ///< On the surface; the other's frame, as the next.
  Vec3 normal;           ///< Unit, out of the surface.
  Vec3 impulse_Ns;       ///< On the pair's first body in the last tick; world.

  HAPTICS_FIELDS(self.point, self.second, self.place, self.foot, self.normal, self.impulse_Ns);
};

/// Two bodies whose spheres are near each other, and where they touch or may do so soon.
struct BodyPair {
  std::uint16_t first = 0, second = 0;  ///< Colliders.
  std::uint32_t used = 0;               ///< 0: this place is free.
  double range_m = -1;                  ///< No other points were nearer when they were looked for; negative: never.
  double depth_m = 0;                   ///< Of the deepest point then; before, how deep it may be.
  Pose relative;                        ///< Of the first body in the second's frame then.
  Vec3 rolling_Nms{0};                  ///< What resistance to rolling gave the first one in the last tick.
  std::uint64_t units = 0;              ///< Of the allowance, that the last search took.
  Sequence<BodyContact, kPointsOfPair> contacts;

  HAPTICS_FIELDS(self.first, self.second, self.used, self.range_m, self.depth_m, self.relative, self.rolling_Nms,
                 self.units, self.contacts);
};

/// A point near the other body's surface, of which contacts are chosen.
struct NearPoint {
  BodyContact contact;
  double gap_m;
  Vec3 at;      ///< In the second body's frame, as the next.
  Vec3 normal;  ///< On the first body.

  HAPTICS_FIELDS(self.contact, self.gap_m, self.at, self.normal);
};

/// The search for a pair's contacts, which may take several ticks.
struct PairSearch {
  std::uint32_t pair = 0;     ///< One more than its place; 0: none.
  std::uint32_t reverse = 0;  ///< 1: of the second body's points, at the first one's surface.
  std::uint64_t node = 0;     ///< Of the tree of points: the next one.
  std::uint64_t units = 0;    ///< Spent so far.
  Pose relative;              ///< As BodyPair::relative: the bodies may have moved on since, by less than the range.
  double range_m = 0;         ///< Farther points are not taken,
  double depth_m = 0;         ///< nor ones that are deeper inside.
  double clear_m = 0;         ///< No point is nearer to the other surface so far; range_m once one is within that.
  Sequence<NearPoint, 96> near;

  HAPTICS_FIELDS(self.pair, self.reverse, self.node, self.units, self.relative, self.range_m, self.depth_m,
                 self.clear_m, self.near);

  void begin(std::size_t place, const Pose& of, double range, double depth, double clear) noexcept {
    pair = static_cast<std::uint32_t>(place + 1);
    relative = of;
    reverse = 0;
    node = units = near.count = 0;
    range_m = range;
    depth_m = depth;
    clear_m = clear;
  }
};

/// What bodies that meet leave from one tick to the next.
struct BodyPairs {
  std::uint64_t next = 0;      ///< Whose contacts are looked for first in the next tick.
  Word<bool> isFound = false;  ///< The last tick found all contacts, and left the move to the next one.
  double heaviestLoad = 0;     ///< What a body bore at one place in the last tick, at most, in its own weights.
  Sequence<BodyPair, kMaxPairs> places;
  PairSearch search;

  HAPTICS_FIELDS(self.next, self.isFound, self.heaviestLoad, self.places, self.search);

  [[nodiscard]] std::span<BodyPair> all() noexcept { return places.all(); }
  [[nodiscard]] std::span<const BodyPair> all() const noexcept { return places.all(); }
};
static_assert(std::is_trivially_copyable_v<BodyPairs>, "recorded, and copied to compare runs");

[[nodiscard]] inline bool isAwake(const Collider& body) noexcept {
  return body.state != nullptr && body.state->condition == BodyCondition::kAwake;
}

/// Something may happen to the pair: one of its bodies is awake, or a driven one may wake the other.
[[nodiscard]] inline bool isActive(const Collider& first, const Collider& second) noexcept {
  return isAwake(first) || isAwake(second) || first.isDriven || second.isDriven;
}

struct FoundContacts {
  /// Else the allowance was spent before all pairs were looked at. The bodies are not to be moved, and the next call goes on
  /// with the others.
  bool areAll = true;
  bool areAllPairs = true;  ///< Else there was no room for some.
};

/// Finds the pairs of which one body is awake and which may touch within the tick, and the points at which they do. Those of
/// pairs that have hardly moved against each other since are kept. Wait-free.
/// @param bodies  With their momenta for the tick.
[[nodiscard]] FoundContacts findBodyContacts(std::span<const Collider> bodies, BodyPairs& pairs, double period_s,
                                             Allowance& allowance) noexcept;

/// Goes on, after findBodyContacts(), with searches that take more than a tick, for the pairs that will need one soon: bodies
/// that are fast on fine meshes need not wait for theirs. Wait-free.
void searchAhead(std::span<const Collider> bodies, BodyPairs& pairs, double period_s, Allowance& allowance) noexcept;

}  // namespace haptics
