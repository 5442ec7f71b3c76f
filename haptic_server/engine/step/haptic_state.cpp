#include "haptic_server/engine/step/haptic_state.h"

#include <type_traits>

#include "haptic_server/engine/step/kinematic_motion.h"

namespace haptics {
namespace {

/// What a rehearsal does without: it belongs to objects at rest, to bodies that meet, or to a tool.
template <class T>
inline constexpr bool kIsLeftOut = std::is_same_v<T, Sequence<ObjectState, kMaxServoObjects>> ||
                                   std::is_same_v<T, Sequence<BumpState, kMaxServoObjects>> ||
                                   std::is_same_v<T, Sequence<MovingBody, kMaxMovingBodies>> ||
                                   std::is_same_v<T, Sequence<KinematicMotion, kMaxServoObjects>> ||
                                   std::is_same_v<T, Sequence<ShapeMotion, kMaxServoObjects>> ||
                                   std::is_same_v<T, BodyPairs> || std::is_same_v<T, ToolInHand>;

}  // namespace

bool HapticState::connect(const ServoScene& adopted) noexcept {
  const std::vector<ServoObject>& all = adopted.objects;
  if (objects.count != all.size() || (bumps.count != 0 && bumps.count != objects.count)) return false;
  if (driven.count != 0 && driven.count != objects.count) return false;
  if (reshaped.count != 0 && (reshaped.count != objects.count || adopted.shapes.size() != objects.count)) return false;
  if (effects.count != adopted.effects.size()) return false;
  for (std::size_t i = 0; i < effects.count; ++i) {
    if (!adopted.effects[i].field->isPlaceOf(effects[i])) return false;
  }
  scene = &adopted;
  contactCache = {};
  effectsFelt = {};
  now = {};
  otherHand.any = false;
  toolFelt = {};
  graspTorque_Nm = Vec3(0);
  collidingCount = 0;
  std::size_t next = 0;  // of the bodies that move, which are in the order of the objects
  for (std::size_t i = 0; i < objects.count; ++i) {
    const ObjectState& object = objects[i];
    if (object.id != all[i].id) return false;
    Body& body = bodies[i];
    body.surface = all[i].surface.get();
    body.deforming = false;
    body.shift = Vec3(0);
    if (isReshaped(i)) {
      const KinematicShape& shape = adopted.shapes[i];
      if (shape.number != reshaped[i].number || shape.memory[motion.follows ? 1 : 0] == nullptr) return false;
      const double along = reshaped[i].along;  // of an untrusted state, may be no number
      if (!(along >= shape.samples.oldest() && along <= ShapeSamples::kNewest)) return false;
      body.surface = memoryOf(shape, *this).moveTo(shape.samples, along, body.surface).surface;
    }
    body.pendingRemoval = object.pendingRemoval;
    place(i, Pose(object.previous), Pose(object.current));
    const bool moves = next < moving.count && moving[next].body == i;
    if (moves && all[i].motion == nullptr) return false;
    const CollisionPoints* const points = all[i].collision.get();
    if (points != nullptr) colliding[collidingCount++] = {i, moves ? static_cast<int>(next) : -1, points};
    if (moves) collides[next++] = points != nullptr;
  }
  if (next != moving.count) return false;
  if (!features.tool) return true;
  if (tool.body >= objects.count || all[tool.body].tool == nullptr) return false;
  std::array<ToolContact::Obstacle, kMaxServoObjects> obstacles;
  for (std::size_t i = 0; i < objects.count; ++i)
    obstacles[i].sharp = all[i].sharp ? std::span<const Vec3>(*all[i].sharp) : std::span<const Vec3>();
  return ToolContact(tool.memory, toolScratch).connect(*all[tool.body].tool, {obstacles.data(), objects.count});
}

void HapticState::copyInUse(const HapticState& other) noexcept {
  haptics::copyInUse<StateFields>(*this, other);
  scene = other.scene;
  allowance = other.allowance;
  std::copy_n(other.bodies.begin(), objects.count, bodies.begin());
  contactCache = other.contactCache;
  std::copy_n(other.colliding.begin(), other.collidingCount, colliding.begin());
  collidingCount = other.collidingCount;
  std::copy_n(other.collides.begin(), moving.count, collides.begin());
  now = other.now;
  effectsFelt = other.effectsFelt;
  std::copy_n(other.effectsTaken_N.begin(), moving.count, effectsTaken_N.begin());
  if (!features.tool) return;
  toolScratch.tool = other.toolScratch.tool;
  std::copy_n(other.toolScratch.sharp.begin(), objects.count, toolScratch.sharp.begin());
}

void HapticState::copyForRehearsal(const HapticState& other) noexcept {
  fields::forEachMember(
      []<class T>(std::size_t, T& to, const T& from) {
        if constexpr (!kIsLeftOut<T> && !std::is_same_v<T, SurfaceMemory>) haptics::copyInUse(to, from);
      },
      static_cast<StateFields&>(*this), static_cast<const StateFields&>(other));
  if (features.detail) surface = other.surface;
  allowance = other.allowance;
  contactCache = other.contactCache;
  now = other.now;
  for (std::size_t i = 0; i < moving.count; ++i) {
    moving[i].copyMotion(other.moving[i]);
    bodies[moving[i].body] = other.bodies[moving[i].body];
  }
}

}  // namespace haptics
