#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "common/deform/dent.h"
#include "common/maths/vec.h"

namespace haptics {

/// Values equal those of the wire's enum (telemetry.proto).
enum class BodyCondition : std::uint8_t {
  kAwake = 0,
  kAsleep = 1,       ///< At rest; costs nothing until it is pushed.
  kOutOfBounds = 2,  ///< Stopped at the world's end until its pose is set anew.
  kNonFinite = 3,    ///< Stopped at its last good pose, because a tick gave a pose that is not finite.
};
[[nodiscard]] constexpr BodyCondition lastOf(BodyCondition) noexcept { return BodyCondition::kNonFinite; }
/// Stopped for good, until its pose is set anew: it fades from under the hand and cannot be touched.
[[nodiscard]] constexpr bool isStopped(BodyCondition condition) noexcept {
  return condition == BodyCondition::kOutOfBounds || condition == BodyCondition::kNonFinite;
}

/// How many objects of a scene may have a motion; a transaction that would pass it is rejected.
inline constexpr std::size_t kMaxMovingBodies = 32;

/// Where a body is.
struct BodyState {
  std::uint64_t object = 0;
  Pose pose;  ///< Of the object, world.
  BodyCondition condition = BodyCondition::kAwake;

  bool operator==(const BodyState&) const = default;
};

/// How the tool that the hand holds is held itself. World.
struct ToolState {
  /// A point that a surface holds.
  struct Point {
    Vec3 place{0};
    Vec3 force_N{0};  ///< On the tool.
    bool operator==(const Point&) const = default;
  };
  /// Of its jaws.
  struct Grip {
    double opening_rad = 0;  ///< What is between them keeps them open.
    double moment_Nm = 0;    ///< On the hand's gripper: above 0 it opens it.
    double written_Nm = 0;   ///< Sent to the device, as ToolState::written_Nm.
    bool operator==(const Grip&) const = default;
  };
  static constexpr std::size_t kMaxPoints = 7;  ///< That decide where it is: a pose with an opening has seven freedoms.

  std::uint64_t object = 0;                 ///< Its id; 0: there is none.
  Vec3 torque_Nm{0};                        ///< On the hand, about the tool's origin.
  Vec3 written_Nm{0};                       ///< Sent to the device: within its limit, none to one that gives no torque.
  Quat deviceRotation{1, 0, 0, 0};          ///< As the device measured it, from how the scene has the tool turned.
  std::optional<Grip> grip = std::nullopt;  ///< None: it has no jaws.
  std::size_t pointCount = 0;
  std::array<Point, kMaxPoints> point;

  [[nodiscard]] std::span<const Point> points() const noexcept { return std::span(point).first(pointCount); }
};

/// Poses of moving objects and dents of yielding ones: as of `tick`, and of every later one until there is a newer state.
struct MotionState {
  std::uint64_t tick = 0;
  std::uint64_t sceneRevision = 0;  ///< Adopted then, by a servo in whose scene something yields.
  std::size_t bodyCount = 0;
  std::array<BodyState, kMaxMovingBodies> body;  ///< In order of object id.
  ToolState tool;
  std::size_t dentCount = 0;
  /// An object's come one after another in this order.
  std::array<ObjectDent, kMaxDentsOfAll> dent;
  /// Its number, for a dent that stays as it is until its object's surface holds it (ServoObject::baked); else 0.
  std::array<std::uint64_t, kMaxDents> staying{};

  [[nodiscard]] std::span<const BodyState> bodies() const noexcept { return std::span(body).first(bodyCount); }
  [[nodiscard]] std::span<const ObjectDent> dents() const noexcept { return std::span(dent).first(dentCount); }
};

/// The state of a scene that two hands touch: the first hand's state with the dents of the second after its own.
[[nodiscard]] inline MotionState ofBothHands(const MotionState& first, const MotionState& second) noexcept {
  MotionState all = first;
  for (const ObjectDent& dent : second.dents()) {
    if (all.dentCount < all.dent.size()) all.dent[all.dentCount++] = dent;
  }
  return all;
}

static_assert(std::is_trivially_copyable_v<MotionState>, "crosses threads by copy");

}  // namespace haptics
