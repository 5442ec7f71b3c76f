#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/maths/vec.h"
#include "common/telemetry/motion_state.h"
#include "haptic_server/collision/collision_points.h"
#include "haptic_server/geometry/allowance.h"
#include "haptic_server/geometry/collision_mesh.h"
#include "haptic_server/motion/rigid_body.h"

namespace haptics {

/// A body that meets others, in a tick. World frame, metres.
struct Collider {
  const CollisionMesh* surface = nullptr;
  const CollisionPoints* points = nullptr;
  Pose pose;
  const RigidBody* what = nullptr;  ///< Null: it stands still.
  RigidState* state = nullptr;      ///< Likewise.
  Push push;
  bool absent = false;  ///< Meets nothing in this tick.
  bool isPut = false;   ///< It has not moved to where it is: it may be inside others.
};

/// At most so many bodies meet one another, those that stand still included.
inline constexpr std::size_t kMaxColliders = 256;
/// Pairs of bodies that are near each other; further ones pass through each other.
inline constexpr std::size_t kMaxPairs = 192;
inline constexpr std::size_t kPointsOfPair = 8;

/// A point of one body at the surface of another.
struct BodyContact {
  std::uint16_t point;   ///< Of the body's CollisionPoints.
  std::uint16_t second;  ///< 1: of the pair's second body, at the first one's surface; 0: the other way round.
  Vec3 place;            ///< The point; its body's frame.
  Vec3 foot;             ///< On the surface; the other's frame, as the next.
  Vec3 normal;           ///< Unit, out of the surface.
  Vec3 impulse_Ns;       ///< On the pair's first body in the last tick; world.
};

/// Two bodies whose spheres are near each other, and where they touch or may do so soon.
struct BodyPair {
  std::uint16_t first = 0, second = 0;  ///< Colliders.
  std::uint16_t count = 0;              ///< Of `contact`.
  std::uint16_t used = 0;               ///< 0: this place is free.
  double range_m = -1;                  ///< No other points were nearer when they were looked for; negative: never.
  double depth_m = 0;                   ///< Of the deepest point then; before, how deep it may be.
  Pose relative;                        ///< Of the first body in the second's frame then.
  Vec3 rolling_Nms{0};                  ///< What resistance to rolling gave the first one in the last tick.
  std::array<BodyContact, kPointsOfPair> contact;
};

/// A point near the other body's surface, of which contacts are chosen.
struct NearPoint {
  BodyContact contact;
  double gap_m;
  Vec3 at;      ///< In the second body's frame, as the next.
  Vec3 normal;  ///< On the first body.
};

/// The search for a pair's contacts, which may take several ticks.
struct PairSearch {
  std::uint16_t pair = 0;     ///< One more than its place; 0: none.
  std::uint16_t reverse = 0;  ///< 1: of the second body's points, at the first one's surface.
  std::uint32_t node = 0;     ///< Of the tree of points: the next one.
  std::uint32_t count = 0;    ///< Of `near`.
  Pose relative;              ///< As BodyPair::relative; where it is another one by now, the search begins anew.
  double range_m = 0;         ///< Farther points are not taken,
  double depth_m = 0;         ///< nor ones that are deeper inside.
  double clear_m = 0;         ///< No point is nearer to the other surface so far; range_m once one is within that.
  std::array<NearPoint, 96> near;

  [[nodiscard]] std::span<const NearPoint> found() const noexcept { return std::span(near).first(count); }
  void begin(std::size_t place, const Pose& of, double range, double depth, double clear) noexcept {
    pair = static_cast<std::uint16_t>(place + 1);
    relative = of;
    reverse = 0;
    node = count = 0;
    range_m = range;
    depth_m = depth;
    clear_m = clear;
  }
};

/// What bodies that meet leave from one tick to the next.
struct BodyPairs {
  std::size_t end = 0;   ///< Places of `pair` from here on are free.
  std::size_t next = 0;  ///< Whose contacts are looked for first in the next tick.
  bool isFull = false;   ///< In this tick there was no room for all pairs.
  bool isFound = false;  ///< The last tick found all contacts, and left the move to the next one.
  std::array<BodyPair, kMaxPairs> pair;
  PairSearch search;

  void copyInUse(const BodyPairs& other) noexcept {
    end = other.end;
    next = other.next;
    isFull = other.isFull;
    isFound = other.isFound;
    std::copy_n(other.pair.begin(), end, pair.begin());
    search = other.search;
  }
  [[nodiscard]] std::span<BodyPair> all() noexcept { return {pair.data(), end}; }
  [[nodiscard]] std::span<const BodyPair> all() const noexcept { return {pair.data(), end}; }
};
static_assert(std::is_trivially_copyable_v<BodyPairs>, "recorded, and copied to compare runs");

[[nodiscard]] inline bool isAwake(const Collider& body) noexcept {
  return body.state != nullptr && body.state->condition == BodyCondition::kAwake;
}

/// Finds the pairs of which one body is awake and which may touch within the tick, and the points at which they do. Those of
/// pairs that have hardly moved against each other since are kept. Wait-free.
/// @param bodies  With their momenta for the tick.
/// @return False: the allowance is spent before all pairs were looked at. The bodies are not to be moved, and the next call
/// goes on with the others.
[[nodiscard]] bool findBodyContacts(std::span<const Collider> bodies, BodyPairs& pairs, double period_s,
                                    Allowance& allowance) noexcept;

}  // namespace haptics
