#include <algorithm>

#include "haptic_server/engine/step/effect_forces.h"
#include "haptic_server/engine/step/grasp.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/engine/step/rate_limited_pose.h"
#include "haptic_server/engine/step/varying_springs.h"

namespace haptics {
namespace {

/// A step of the contact force that may go with an adoption: with what RateLimitedStiffness adds in the same tick of
/// 1 ms it makes 0.05 N, which a hand notices. Larger makes more edits felt at once, smaller fades out more contacts.
constexpr double kMaxStep_N = 0.02;
/// A larger step that goes with an adoption where the object that is felt stays the same: EditSlew then lets it in within
/// 17 ms, and the contact is not let go. Larger leaves longer what was felt before where the hand lets go meanwhile.
constexpr double kMaxSlewed_N = 0.5;
/// Seconds for which an adoption waits until the contact has faded; 7.5 N fade in it. What is left then is a jump for
/// EditSlew.
constexpr double kLongestFade_s = 0.25;

/// What the next scene makes of the state, each of its objects from the one with the same id.
class StateTransfer {
 public:
  StateTransfer(const ServoScene& next, const HapticState& state) noexcept
      : state_(state), count_(std::min(next.objects.size(), kMaxServoObjects)) {
    if (!state.motion.follows) toolBody_ = toolOf(next);
    std::size_t before = 0;  // both lists are in order of id
    const bool anyReshaped = next.anyReshaped();
    for (std::size_t i = 0; i < count_; ++i) {
      const ServoObject& object = next.objects[i];
      while (before < state.objects.count && state.objects[before].id < object.id) ++before;
      const bool known = before < state.objects.count && state.objects[before].id == object.id;
      reshaped_[i] = {};
      if (known && anyReshaped) goOnReshaping(i, next.shapes[i], object, before);
      if (known) {
        follow(i, object, before);
      } else {
        begin(i, object);
      }
    }
    for (std::size_t i = 0; i < count_; ++i) {
      takeDetail(i, next.objects[i]);
      takeMotion(i, next.objects[i]);
      dropBakedDents(i, next.objects[i]);
      takeCollision(i, next.objects[i]);
    }
    contact_ = state.contact;
    if (state.features.tool || toolBody_ >= 0) resetContact(contact_, state.estimate.hip);
    broken_ = toolBody_ < 0 && reprojectContact(contact_, bodies(), {origins_.data(), count_}, allowance());
    if (state.features.varyingStiffness || features_.varyingStiffness) {
      for (std::size_t i = 0; i < count_; ++i) takeFactor(i, next.objects[i]);
    }
  }

  /// The contact could not be carried on as it was.
  [[nodiscard]] bool broken() const noexcept { return broken_; }

  /// Spring force (N, world) that would be felt at once, with every object's stiffness as it is felt now; `touched` is
  /// the body, -1 when free.
  [[nodiscard]] Vec3 springForce_N(int& touched) const noexcept {
    ContactState trial = contact_;
    ContactResult result;
    result.work.allowance = allowance();
    ContactCache none;
    followContact(bodies(), trial, trial.hip, result, none);
    touched = result.body;
    if (!result.touching) return Vec3(0);
    const Stiffness rateLimited = objects_[static_cast<std::size_t>(touched)].stiffness.value();
    return rateLimited.spring_N_per_m * (result.ihip - trial.hip);
  }

  /// What was edited, and what would be touched, is felt from nothing on.
  void fadeIn(int touched) noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (origins_[i].changed || static_cast<int>(i) == touched) objects_[i].stiffness = {};
    }
  }

  void apply(const ServoScene& next, HapticState& state) const noexcept {
    if (!state.now.adopted) state.effectsTaken_N = {};
    if (state.features.effects || !next.effects.empty()) {
      adoptEffects(next, {origins_.data(), count_}, bodies(), {moving_.data(), movingCount_}, state);
    }
    const bool feltThroughTool = state.features.tool || toolBody_ >= 0;
    state.features.torqueFades = toolBody_ < 0 && (state.features.tool || state.features.torqueFades);
    if (toolBody_ >= 0) takeTool(next, state);
    if (toolBody_ < 0 && state.features.tool) state.tool.memory.clear();
    state.features.tool = toolBody_ >= 0;
    state.scene = &next;
    state.contactCache = {};
    std::copy_n(bodies_.begin(), count_, state.bodies.begin());
    assign(state.objects, objects_, count_);
    for (std::size_t i = 0; i < count_; ++i) {
      state.objects[i].previous = bodies_[i].previous;
      state.objects[i].current = bodies_[i].current;
      state.objects[i].pendingRemoval = bodies_[i].pendingRemoval;
    }
    assign(state.bumps, bumps_, features_.bumps ? count_ : 0);
    state.contact = contact_;
    state.now.detailEdited = detailEdited_;
    if (!state.features.detail) state.surface = {};  // it was not kept
    if (detailEdited_) state.surface.object = state.report.object;
    assign(state.moving, moving_, movingCount_);
    std::copy_n(collides_.begin(), movingCount_, state.collides.begin());
    if (collidingCount_ + state.collidingCount > 0) applyCollisions(state);
    assign(state.dents, dents_, dentCount_);
    assign(state.driven, driven_, next.anyDriven() ? count_ : 0);
    assign(state.reshaped, reshaped_, next.anyReshaped() ? count_ : 0);
    state.now.contactBroken = broken_ || otherDetailEdited_ || feltThroughTool;
    if (toolBody_ >= 0) state.makeUntouchable(state.tool.body);  // it meets nothing but by what the hand does
    if (state.grasp.object != 0) takeGrasp(state);
    applyFeatures(state);
  }

 private:
  /// `items` are not initialised beyond the count.
  template <class Item, std::size_t kCapacity>
  static void assign(Sequence<Item, kCapacity>& to, const std::array<Item, kCapacity>& items,
                     std::size_t count) noexcept {
    to.count = count;
    std::copy_n(items.begin(), count, to.items.begin());
  }

  /// But for those of the tool. Last, as they follow from all else.
  void applyFeatures(HapticState& state) const noexcept {
    state.features.taps = features_.taps || state.surface.tap.rings();
    state.features.detail =
        features_.detail || movingCount_ > 0 || features_.soft || toolBody_ >= 0 || state.features.taps;
    const auto fades = [](const MovingBody& moving) { return moving.effectsRest_N != Vec3(0); };
    state.features.effects = state.effects.count > 0 || state.features.taps ||
                             (state.now.effectsEdited && state.moving.count > 0) ||
                             std::ranges::any_of(state.moving.all(), fades);
    if (!state.features.effects) state.effectsFelt = {};
    state.features.bumps = features_.bumps;
    state.features.soft = features_.soft;
    state.features.varyingStiffness = features_.varyingStiffness;
    state.features.beingMoved =
        state.driven.count + state.reshaped.count > 0 ||
        std::ranges::any_of(state.objects.all(), [](const ObjectState& object) { return object.beingMoved; });
    state.features.extras = state.hasExtras();
  }

  [[nodiscard]] std::span<const Body> bodies() const noexcept { return {bodies_.data(), count_}; }
  /// As the scene before has it.
  [[nodiscard]] const ServoObject& was(std::size_t before) const noexcept { return state_.scene->objects[before]; }
  /// For either of the adoption's two questions.
  [[nodiscard]] Allowance allowance() const noexcept { return Allowance(state_.allowance.left() / 6); }

  /// The tool that the hand held, or, where it is to take the next or that is gone, the one after it; -1: none.
  [[nodiscard]] int toolOf(const ServoScene& next) const noexcept {
    const std::uint64_t held = state_.features.tool ? state_.objects[state_.tool.body].id : 0;
    int first = -1;
    for (std::size_t i = 0; i < count_; ++i) {
      const ServoObject& object = next.objects[i];
      if (object.tool == nullptr || object.pendingRemoval) continue;
      if (first < 0) first = static_cast<int>(i);
      if (state_.now.takesNextTool ? object.id > held : object.id >= held) return static_cast<int>(i);
    }
    return first;
  }

  void begin(std::size_t i, const ServoObject& object) noexcept {
    objects_[i].id = object.id;
    put(i, object);
    origins_[i] = {-1, true};
  }

  /// Its vertices are moved as they were.
  void goOnReshaping(std::size_t i, const KinematicShape& shape, const ServoObject& object,
                     std::size_t before) noexcept {
    const bool goesOn = shape.number != 0 && state_.isReshaped(before) && state_.reshaped[before].number >= shape.first;
    if (!goesOn || was(before).surface != object.surface) return;
    reshaped_[i] = state_.reshaped[before];
  }

  /// Of an object that is known where its vertices go on being moved, else as the scene has it.
  [[nodiscard]] const CollisionMesh* surfaceOf(std::size_t i, const ServoObject& object) const noexcept {
    return reshaped_[i].number != 0 ? bodies_[i].surface : object.surface.get();
  }

  void follow(std::size_t i, const ServoObject& object, std::size_t before) noexcept {
    const bool isReset = state_.isReshaped(before) && reshaped_[i].number == 0;
    const bool sameSurface = was(before).surface == object.surface && !isReset;
    const bool tookDents = !sameSurface && hasBakedDents(object, before);
    // What no longer moves goes back to where the scene has it.
    const bool letGo = state_.features.tool && state_.tool.body == before && static_cast<int>(i) != toolBody_;
    const bool stopped = letGo || (object.motion == nullptr && movingBefore(static_cast<int>(before)) != nullptr);
    const bool samePose = isAsSet(object, before) && !stopped;
    bodies_[i] = state_.bodies[before];
    bodies_[i].deforming = false;
    bodies_[i].shift = Vec3(0);
    driven_[i] = state_.isDriven(before) ? state_.driven[before] : KinematicMotion{};
    objects_[i] = state_.objects[before];
    objects_[i].poseRevision = object.poseRevision;
    bodies_[i].pendingRemoval = leaves(i, object);
    bool changed = !sameSurface;
    if (samePose) {
      bodies_[i].surface = surfaceOf(i, object);
      bodies_[i].previous = lastTestedPose(state_, state_.bodies[before]);
      bodies_[i].update();
    } else if (sameSurface && isCarried(object, before)) {
      objects_[i].scenePose = object.pose;
      objects_[i].beingMoved = true;
      driven_[i] = {};
      bodies_[i].previous = lastTestedPose(state_, state_.bodies[before]);
      bodies_[i].update();
    } else {
      put(i, object);
      changed = true;
    }
    origins_[i] = {static_cast<int>(before), changed, changed && samePose && tookDents};
  }

  /// It is not to be touched anew: also a tool that this hand does not hold.
  [[nodiscard]] bool leaves(std::size_t i, const ServoObject& object) const noexcept {
    return object.pendingRemoval || (object.tool != nullptr && static_cast<int>(i) != toolBody_);
  }

  /// Of a known object.
  [[nodiscard]] BumpState bumpsOf(int before) const noexcept {
    return state_.features.bumps ? state_.bumps[static_cast<std::size_t>(before)] : BumpState{};
  }

  /// Did a known object hold the IHIP, or reach it with a bump?
  [[nodiscard]] bool isFeltBeside(int before) const noexcept {
    if (before < 0) return false;
    const BumpState bumps = bumpsOf(before);
    return (bumps.triangle != kNoTriangle && bumps.clear_m == 0) || state_.contact.holds(before);
  }

  /// May its bumps, as they are now, reach the IHIP?
  [[nodiscard]] bool mayBeFelt(std::size_t i, const SurfaceDetail* detail) const noexcept {
    if (detail == nullptr || !(detail->reach_m > 0)) return false;
    const double reach_m = bodies_[i].surface->radius_m() + detail->reach_m;
    return glm::distance(bodies_[i].centre, state_.contact.ihip) <= reach_m;
  }

  /// Is its surface another one only for the dents that it holds now?
  [[nodiscard]] bool hasBakedDents(const ServoObject& object, std::size_t before) const noexcept {
    return object.baked.shape == was(before).baked.shape && object.baked.upTo > was(before).baked.upTo;
  }

  /// Was a known object's pose not set since?
  [[nodiscard]] bool isAsSet(const ServoObject& object, std::size_t before) const noexcept {
    const ObjectState& was = state_.objects[before];
    const bool stays = object.motion == nullptr && !state_.isDriven(before);
    return was.scenePose == object.pose && (stays || was.poseRevision == object.poseRevision);
  }

  /// Does a known object go to its new pose as a motion, with the contact on it?
  [[nodiscard]] bool isCarried(const ServoObject& object, std::size_t before) const noexcept {
    const Stiffness k =
        stiffer(state_.objects[before].stiffness.value(), {object.stiffness_N_per_m, object.damping_Ns_per_m});
    const RateLimitedPose pose(state_.contact.hip, state_.contact.ihip, k);
    return state_.contact.holds(static_cast<int>(before)) && !state_.bodies[before].pendingRemoval &&
           pose.follows(state_.bodies[before].current, object.pose);
  }

  void takeDetail(std::size_t i, const ServoObject& object) noexcept {
    const SurfaceDetail* detail = object.detail.get();
    const int before = origins_[i].before;
    bumps_[i] = before >= 0 ? bumpsOf(before) : BumpState{};
    const ServoObject* const its = before >= 0 ? &was(static_cast<std::size_t>(before)) : nullptr;
    const bool edited = (its != nullptr ? its->detail.get() : nullptr) != detail ||
                        (origins_[i].changed && detail != nullptr) ||
                        (detail != nullptr && detail->stiffness && its->highestFactor != object.highestFactor);
    factorEdited_[i] = edited;
    if (edited || origins_[i].changed)
      bumps_[i] = {.blendWeight = bumps_[i].blendWeight, .height_m = bumps_[i].height_m};
    detailEdited_ = detailEdited_ || (edited && objects_[i].id == state_.report.object);
    const bool leaves =
        before >= 0 && bodies_[i].pendingRemoval && !state_.bodies[static_cast<std::size_t>(before)].pendingRemoval;
    otherDetailEdited_ = otherDetailEdited_ || ((edited || leaves) && (isFeltBeside(before) || mayBeFelt(i, detail)));
    features_.detail = features_.detail || detail != nullptr;
    features_.taps = features_.taps || (detail != nullptr && detail->scalars.tap_Ns_per_m > 0);
    features_.bumps = features_.bumps || (detail != nullptr && detail->hasHeight());
    features_.varyingStiffness = features_.varyingStiffness || (detail != nullptr && detail->stiffness);
  }

  /// What holds the IHIP is as stiff as it was, whatever its stiffness follows from here on.
  void takeFactor(std::size_t i, const ServoObject& object) noexcept {
    if (!factorEdited_[i]) return;
    const bool varies = object.detail && object.detail->stiffness;
    const auto holding = contact_.surfaces();
    const auto held = std::ranges::find(holding, static_cast<int>(i), &ContactSurface::body);
    RateLimitedStiffness& rateLimited = objects_[i].stiffness;
    if (held == holding.end()) {
      if (!varies) rateLimited.vary(1);
      return;
    }
    const double factor = varies ? stiffnessFactorAt(object, bodies_[i], held->triangle, contact_.ihip).value : 1;
    if (factor > 0) rateLimited.varyByEdit(factor);
  }

  /// The object stays dented as it is, unless its surface is another one. Dents that the surface holds now end here, and
  /// the shape stays bit-identical.
  void dropBakedDents(std::size_t i, const ServoObject& object) noexcept {
    features_.soft = features_.soft || object.tissue != nullptr;
    if (origins_[i].before < 0) return;
    const auto before = static_cast<std::size_t>(origins_[i].before);
    const bool edited = was(before).tissue != object.tissue;
    detailEdited_ = detailEdited_ || (edited && object.id == state_.report.object);
    otherDetailEdited_ = otherDetailEdited_ || (edited && isFeltBeside(origins_[i].before));
    if (!object.tissue || (was(before).surface != object.surface && !hasBakedDents(object, before))) return;
    for (BodyDent dent : state_.dents.all()) {
      if (dent.body != before || dent.number <= object.baked.upTo) continue;
      if (dent.number <= object.baked.releasedUpTo && dent.stays) {
        dent.rest.displacement = Vec3f(0);
        dent.stays = false;
      }
      dent.body = i;
      dents_[dentCount_++] = dent;
    }
  }

  [[nodiscard]] const MovingBody* movingBefore(int before) const noexcept {
    const auto all = state_.moving.all();
    const auto at = std::ranges::find(all, before, [](const MovingBody& m) { return static_cast<int>(m.body); });
    return at == all.end() ? nullptr : &*at;
  }

  /// Goes on moving as it did; from rest when its pose was edited, or what moves it.
  void takeMotion(std::size_t i, const ServoObject& object) noexcept {
    const RigidBody* const body = object.motion.get();
    if (body == nullptr || movingCount_ == moving_.size()) return;
    MovingBody& moving = moving_[movingCount_++];
    const int before = origins_[i].before;
    const MovingBody* known = movingBefore(before);
    const bool samePose = known != nullptr && isAsSet(object, static_cast<std::size_t>(before));
    if (samePose && &state_.rigidBody(*known) == body) {
      moving = *known;
    } else if (samePose && state_.rigidBody(*known).freedom == body->freedom) {
      moving = {.state = restingAt(*body, bodies_[i].current)};
      moving.state.rest = objects_[i].scenePose;
      moving.state.coordinate = known->state.coordinate;
    } else {
      moving = {.state = restingAt(*body, samePose ? bodies_[i].current : objects_[i].scenePose)};
    }
    moving.body = i;
    moving.effectsRest_N = known != nullptr ? known->effectsRest_N : Vec3(0);
    bodies_[i].pendingRemoval = bodies_[i].pendingRemoval || isStopped(moving.state.condition);
  }

  void takeCollision(std::size_t i, const ServoObject& object) noexcept {
    const bool moves = object.motion != nullptr && movingCount_ > 0 && moving_[movingCount_ - 1].body == i;
    if (moves) collides_[movingCount_ - 1] = object.collision != nullptr;
    if (object.collision == nullptr) return;
    colliding_[collidingCount_++] = {i, moves ? static_cast<int>(movingCount_ - 1) : -1, object.collision.get(),
                                     origins_[i].changed};
  }

  /// Pairs go on with their contacts where both bodies are the same. Where anything that others may lie on has changed, all
  /// bodies that collide wake.
  void applyCollisions(HapticState& state) const noexcept {
    std::array<int, kMaxColliders> now;  // of those before
    std::fill_n(now.begin(), state.collidingCount, -1);
    bool changed = collidingCount_ != state.collidingCount;
    for (std::size_t i = 0; i < collidingCount_; ++i) {
      const CollidingBody& is = colliding_[i];
      const auto end = state.colliding.begin() + static_cast<std::ptrdiff_t>(state.collidingCount);
      const auto was = std::find_if(state.colliding.begin(), end, [&](const CollidingBody& c) {
        return static_cast<int>(c.body) == origins_[is.body].before && c.points == is.points &&
               (c.moving < 0) == (is.moving < 0);
      });
      if (was != end) now[static_cast<std::size_t>(was - state.colliding.begin())] = static_cast<int>(i);
      changed = changed || was == end || origins_[is.body].changed;
    }
    for (BodyPair& pair : state.pairs.all()) {
      if (pair.used == 0) continue;
      const int first = now[pair.first], second = now[pair.second];
      pair.used = first >= 0 && second >= 0 ? 1 : 0;
      if (pair.used == 0) continue;
      pair.first = static_cast<std::uint16_t>(first);
      pair.second = static_cast<std::uint16_t>(second);
      if (origins_[colliding_[pair.first].body].changed || origins_[colliding_[pair.second].body].changed)
        pair.range_m = -1;
    }
    state.pairs.search.pair = 0;
    std::copy_n(colliding_.begin(), collidingCount_, state.colliding.begin());
    state.collidingCount = collidingCount_;
    if (!changed) return;
    for (std::size_t i = 0; i < movingCount_; ++i) {
      RigidState& moving = state.moving[i].state;
      if (!state.collides[i] || moving.condition != BodyCondition::kAsleep) continue;
      moving.condition = BodyCondition::kAwake;
      moving.still_s = 0;
    }
  }

  /// The tool goes on where it is; one that was not held before comes to where the device is.
  void takeTool(const ServoScene& next, HapticState& state) const noexcept {
    const auto body = static_cast<std::size_t>(toolBody_);
    const Tool& tool = *next.objects[body].tool;
    ToolContact contact(state.tool.memory, state.toolScratch);
    const bool wasHeld = state.features.tool;
    const bool isSame = wasHeld && was(state.tool.body).tool.get() == &tool;
    std::array<ToolContact::Obstacle, kMaxServoObjects> obstacles;
    for (std::size_t i = 0; i < count_; ++i) {
      const ServoObject& object = next.objects[i];
      const int before = origins_[i].before;
      const bool isKnown = isSame && before >= 0 && was(static_cast<std::size_t>(before)).surface == object.surface &&
                           (i == body || !state_.bodies[static_cast<std::size_t>(before)].pendingRemoval);
      obstacles[i] = {bodies_[i].current, object.sharp ? std::span<const Vec3>(*object.sharp) : std::span<const Vec3>(),
                      isKnown ? before : -1};
    }
    ToolPose from =
        wasHeld ? state.tool.memory.proxy : ToolPose{objects_[body].scenePose.rotation, state.estimate.measured};
    if (!tool.jaws) from.opening_rad = 0;
    if (!isSame) contact.hold(tool);
    contact.adopt({obstacles.data(), count_});
    if (!isSame) contact.reset(from, bodies());
    state.tool.body = body;
    state.tool.isNew = !wasHeld;
  }

  /// What the hand holds it goes on holding, unless an edit has another shape of it, or puts it elsewhere.
  void takeGrasp(HapticState& state) const noexcept {
    const auto all = state.moving.all();
    const auto held = std::ranges::find_if(
        all, [&](const MovingBody& moving) { return objects_[moving.body].id == state.grasp.object; });
    if (toolBody_ < 0 && held != all.end() && !origins_[held->body].changed && !objects_[held->body].beingMoved &&
        !bodies_[held->body].pendingRemoval) {
      state.grasp.moving = static_cast<std::uint64_t>(held - all.begin());
    } else {
      letGo(state);
    }
  }

  /// At its place in the scene, at rest.
  void put(std::size_t i, const ServoObject& object) noexcept {
    objects_[i].scenePose = object.pose;
    objects_[i].poseRevision = object.poseRevision;
    objects_[i].beingMoved = false;
    driven_[i] = {};
    bodies_[i].surface = surfaceOf(i, object);
    bodies_[i].pendingRemoval = leaves(i, object);
    bodies_[i].previous = bodies_[i].current = object.pose;
    bodies_[i].update();
  }

  const HapticState& state_;
  std::size_t count_;
  std::array<Body, kMaxServoObjects> bodies_;
  std::array<ObjectState, kMaxServoObjects> objects_;
  std::array<BodyOrigin, kMaxServoObjects> origins_;
  std::array<BumpState, kMaxServoObjects> bumps_;
  std::array<KinematicMotion, kMaxServoObjects> driven_;
  std::array<ShapeMotion, kMaxServoObjects> reshaped_;
  std::array<MovingBody, kMaxMovingBodies> moving_;
  std::array<bool, kMaxMovingBodies> collides_{};
  std::size_t movingCount_ = 0;
  std::array<CollidingBody, kMaxColliders> colliding_;
  std::size_t collidingCount_ = 0;
  std::array<BodyDent, kMaxDents> dents_;
  std::size_t dentCount_ = 0;
  SceneFeatures features_;  // of the next scene's objects
  ContactState contact_;
  int toolBody_ = -1;  // the one that the hand holds
  bool detailEdited_ = false;
  bool otherDetailEdited_ = false;
  std::array<bool, kMaxServoObjects> factorEdited_;
  bool broken_ = false;
};

/// What is driven and has no sample in the scene that waits comes to rest at once.
void stopDriven(const ServoScene& next, HapticState& state) noexcept {
  if (state.driven.count + state.reshaped.count == 0) return;
  std::size_t n = 0;  // both are in order of the objects' ids
  const auto isDriven = [&](const auto& samples) noexcept { return n < samples.size() && samples[n].number != 0; };
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    const std::uint64_t id = state.objects[i].id;
    while (n < next.objects.size() && next.objects[n].id < id) ++n;
    const bool isThere = n < next.objects.size() && next.objects[n].id == id;
    if (i < state.driven.count && !(isThere && isDriven(next.kinematic))) state.driven[i].left = 0;
    if (i < state.reshaped.count && !(isThere && isDriven(next.shapes))) state.reshaped[i].left = 0;
  }
}

}  // namespace

bool adoptScene(const ServoScene& next, HapticState& state, std::uint64_t tick) noexcept {
  state.groove.shaded = false;
  // While a fault lasts the contact stays as it was, and nobody feels it.
  const bool isFelt = state.supervision.fault == Fault::kNone;
  const Vec3 now_N = isFelt ? heldSpring_N(state, state.contact.ihip - state.contact.hip) : Vec3(0);
  const bool mayWait = glm::length(now_N) > kMaxStep_N && state.adoption.fadeOut_s < kLongestFade_s;
  const auto wait = [&]() noexcept {
    stopDriven(next, state);
    return false;
  };
  if (state.adoption.fadingOut && mayWait) return wait();
  StateTransfer transfer(next, state);
  if (transfer.broken()) {
    int touched = -1;
    const Vec3 then_N = transfer.springForce_N(touched);
    const bool sameObject = touched >= 0 && next.objects[static_cast<std::size_t>(touched)].id == state.report.object;
    if (glm::distance(now_N, then_N) > (sameObject ? kMaxSlewed_N : kMaxStep_N)) {
      state.adoption.fadingOut = mayWait;
      if (mayWait) return wait();
      transfer.fadeIn(touched);
      const Vec3 penetration_m = state.contact.ihip - state.contact.hip;
      state.energy.attribute(state.report.object, EnergyFeature::kEdit, -glm::dot(now_N, penetration_m) / 2);
    }
  }
  transfer.apply(next, state);
  if (next.revision != state.adoption.revision) state.adoption.tick = tick;  // not when a removed object has left
  state.adoption.revision = next.revision;
  state.now.adopted = true;
  state.adoption.fadingOut = false;
  state.adoption.fadeOut_s = 0;
  return true;
}

}  // namespace haptics
