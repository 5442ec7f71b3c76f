// Bodies that the step itself moves: S18, S19.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/mesh/generators.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kMaxRatio = 1.1;
constexpr double kMaxExtra_N = 0.05;

Pose at(Vec3 position) { return {{1, 0, 0, 0}, position}; }

TriMesh boxMesh(Vec3 size_m, int segments = 3) { return makeBox(size_m, static_cast<std::uint32_t>(segments)).value(); }

/// What a still HIP sees of bodies that come at it.
struct Seen {
  int ticks = 0;
  int inside = 0;
  int undetected = 0;
  int notFinite = 0;
  double worst_N =
      0;  ///< Difference between the force's size and that of a spring as long as the HIP is deep below a face.
  double speed_m_per_s = 0;
};

/// Until it has passed, or for `most` ticks.
/// @param judgedBelow_m  Of a block that comes down square, whose force is judged: its lower face, in its frame. The HIP came
/// in there and is held there, also where it has come nearer to a side.
void watch(MovingWorld& world, std::uint64_t id, Vec3 hip, int most, std::optional<double> judgedBelow_m, Seen& seen) {
  for (int i = 0; i < most; ++i) {
    const Vec3 before = world.state().objects.count > 0 ? world.poseOf(id).position : Vec3(0);
    const TelemetrySample sample = world.tick(hip);
    const int index = world.indexOf(id);
    if (index < 0) continue;
    ++seen.ticks;
    if (i > 0) {
      seen.speed_m_per_s = std::max(seen.speed_m_per_s, glm::distance(world.poseOf(id).position, before) / kPeriod_s);
    }
    seen.notFinite += isFinite(sample.force.contact) && isFinite(world.poseOf(id)) ? 0 : 1;
    const double depth = world.depthIn(static_cast<std::size_t>(index), hip);
    if (depth <= kInside_m) continue;
    ++seen.inside;
    seen.undetected += sample.object == 0 ? 1 : 0;
    if (!judgedBelow_m) continue;
    const Body& body = world.state().bodies[static_cast<std::size_t>(index)];
    const double deep_m = body.frame.toLocal(hip).z - *judgedBelow_m;
    seen.worst_N = std::max(seen.worst_N, std::abs(glm::length(sample.force.contact) - kSpring_N_per_m * deep_m));
  }
}

/// A heavy block on a slider is driven up through the HIP, at this speed when it arrives.
void drive(double speed_m_per_s, double thickness, Random& random, Seen& seen) {
  constexpr double kRunUp = 0.02;
  MovingSolid block = solidFrom(boxMesh({0.04, 0.04, thickness}), 1000);
  block.body.freedom = Freedom::kSlider;
  block.body.joint.axis = {0, 0, 1};
  block.body.gravity_m_per_s2 = {0, 0, speed_m_per_s * speed_m_per_s / (2 * kRunUp)};
  MovingWorld world;
  const std::uint64_t id = world.add(block, at({0, 0, -kRunUp - thickness / 2}));
  world.publish();
  const Vec3 hip(random.between(-0.015, 0.015), random.between(-0.015, 0.015), 0);
  const double seconds = 2 * kRunUp / speed_m_per_s + thickness / speed_m_per_s;
  watch(world, id, hip, static_cast<int>(seconds / kPeriod_s) + 2, std::nullopt, seen);
}

/// A plate swings on a hinge, by its weight, onto the HIP: bounces, and comes to rest on it.
void swing(double gravity_m_per_s2, Random& random, Seen& seen) {
  const Vec3 size(0.1, 0.04, 0.0005);
  MovingSolid plate = solidFrom(boxMesh(size), 0.05);
  plate.body.freedom = Freedom::kHinge;
  plate.body.joint.anchor_m = {-0.05, 0, 0};
  plate.body.joint.axis = {0, 1, 0};
  plate.body.angularDamping_per_s = 2;
  plate.body.gravity_m_per_s2 = {0, 0, -gravity_m_per_s2};
  MovingWorld world;
  const std::uint64_t id = world.add(plate, at({0.05, 0, 0}));
  world.publish();
  const Vec3 hip(random.between(0.03, 0.08), random.between(-0.015, 0.015), -random.between(0.01, 0.03));
  watch(world, id, hip, 4000, std::nullopt, seen);
}

/// A free block falls on the HIP beside its middle, tumbles over it, and is gone.
void drop(double height, Random& random, bool square, Seen& seen) {
  constexpr double kHalf = 0.02;
  MovingSolid block = solidFrom(boxMesh(Vec3(2 * kHalf)), 0.2);
  block.body.gravity_m_per_s2 = {0, 0, -9.81};
  if (square) {
    block.body.freedom = Freedom::kSlider;
    block.body.joint.axis = {0, 0, 1};
  }
  MovingWorld world;
  const Quat turned = square ? Quat(1, 0, 0, 0) : random.rotation();
  const std::uint64_t id = world.add(block, {turned, {0, 0, height + (square ? kHalf : 0.035)}});
  world.publish();
  const double aside = square ? 0.01 : 0.015;
  const Vec3 hip(random.between(-aside, aside), random.between(-aside, aside), 0);
  watch(world, id, hip, square ? 1500 : 300, square ? std::optional(-kHalf) : std::nullopt, seen);
}

// ---- Edits of a body in motion ----

constexpr double kRadius = 0.05;
constexpr double kDepth = 0.002;
constexpr int kEditTick = 500;
constexpr int kTicks = kEditTick + 700;

TriMesh ballMesh(int n, double radius = kRadius) { return makeSphere(radius, static_cast<std::uint32_t>(n)).value(); }

/// The same for all runs.
struct Balls {
  MovingSolid fine = solidFrom(ballMesh(64), 0.5);
  MovingSolid coarser = solidFrom(ballMesh(48), 0.5);
  MovingSolid larger = solidFrom(ballMesh(64, kRadius + 0.001), 0.5);
};
const Balls& balls() {
  static const Balls all;
  return all;
}

/// On a spring, so that the hand moves it and it does not leave.
RigidBody sprung(RigidBody body) {
  body.spring = {400, 3, 0.5, 0.002};
  return body;
}

struct Edit {
  const char* name;
  void (*apply)(MovingWorld& world);  ///< Of the ball, which is 1.
};

void reshape(MovingWorld& world, const MovingSolid& solid) {
  world.object(1).surface = solid.surface;
  world.setBody(1, sprung(solid.body));
}

constexpr std::array kEdits{
    Edit{"stiffer", [](MovingWorld& world) { world.object(1).stiffness_N_per_m = 2500; }},
    Edit{"softer", [](MovingWorld& world) { world.object(1).stiffness_N_per_m = 200; }},
    Edit{"moved",
         [](MovingWorld& world) {
           world.setPose(1, {glm::angleAxis(0.02, Vec3(0, 1, 0)), Vec3(0.001, 0, -0.001)});
         }},
    Edit{"pose_set_to_the_same", [](MovingWorld& world) { world.setPose(1, Pose{}); }},
    Edit{"moved_far",
         [](MovingWorld& world) {
           world.setPose(1, at({0, 0, -0.3}));
         }},
    Edit{"removed", [](MovingWorld& world) { world.remove(1); }},
    Edit{"remeshed", [](MovingWorld& world) { reshape(world, balls().coarser); }},
    Edit{"reshaped", [](MovingWorld& world) { reshape(world, balls().larger); }},
    Edit{"made_heavier", [](MovingWorld& world) { world.setBody(1, sprung(solidFrom(ballMesh(64), 2).body)); }},
    Edit{"made_to_stand", [](MovingWorld& world) { world.object(1).motion = nullptr; }},
};

/// The ball pressed 2 mm, let swing, and stroked at 20 mm/s.
Vec3 strokingHip(int tick) {
  const double height = std::max(0.01 - 0.1 * kPeriod_s * tick, -kDepth);
  const double along = 0.02 * kPeriod_s * std::max(0, tick - 200);
  return (kRadius + height) * Vec3(std::sin(along / kRadius), 0, std::cos(along / kRadius));
}

struct Watched {
  double step_N = 0;  ///< Largest from the edit on.
  int notFinite = 0;
};

Watched stroke(void (*edit)(MovingWorld&)) {
  MovingSolid ball = balls().fine;
  ball.body = sprung(ball.body);
  MovingWorld world;
  world.add(ball, Pose{});
  world.publish();
  Watched watched;
  Vec3 last_N(0);
  for (int tick = 0; tick < kTicks; ++tick) {
    if (tick == kEditTick && edit != nullptr) {
      edit(world);
      world.publish();
    }
    const TelemetrySample sample = world.tick(strokingHip(tick));
    const Vec3 force_N = sample.force.contact;
    if (tick >= kEditTick) watched.step_N = std::max(watched.step_N, glm::distance(force_N, last_N));
    watched.notFinite += isFinite(force_N) ? 0 : 1;
    last_N = force_N;
  }
  return watched;
}

}  // namespace

/// S4 and S17's body on a still hand, with bodies that are driven, swing and fall instead of being led.
SceneResult meetMovingBodies(Renderer& /*ours*/, Random& random) {
  Seen driven;
  Seen plate;
  Seen swung;
  Seen dropped;
  Seen tumbled;
  for (const double speed_m_per_s : {0.01, 0.1, 1.0, 5.0}) drive(speed_m_per_s, 0.04, random, driven);
  for (const double speed_m_per_s : {0.05, 0.3, 1.0, 2.0}) drive(speed_m_per_s, 0.0005, random, plate);
  for (const double gravity_m_per_s2 : {1.0, 10.0, 60.0}) swing(gravity_m_per_s2, random, swung);
  for (const double height : {0.001, 0.005, 0.02}) drop(height, random, true, dropped);
  for (int i = 0; i < 10; ++i) drop(0.02, random, false, tumbled);
  SceneResult result;
  int undetected = 0;
  int notFinite = 0;
  bool any = true;
  for (const auto& [name, seen] : {std::pair{"driven", &driven},
                                   {"plate", &plate},
                                   {"swung", &swung},
                                   {"dropped", &dropped},
                                   {"tumbled", &tumbled}}) {
    result.measures[std::string(name) + "_inside_ticks"] = seen->inside;
    result.measures[std::string(name) + "_undetected_ticks"] = seen->undetected;
    undetected += seen->undetected;
    notFinite += seen->notFinite;
    any = any && seen->inside > 0;
  }
  result.measures["driven_speed_m_per_s"] = driven.speed_m_per_s;
  result.measures["dropped_force_error_N"] = dropped.worst_N;
  result.measures["non_finite_ticks"] = notFinite;
  result.pass = undetected == 0 && notFinite == 0 && any && dropped.worst_N <= kMaxExtra_N;
  return result;
}

/// S17 on a body in motion: no edit makes the force step by more than it does without, but for what no hand notices.
SceneResult editMovingBodies(Renderer& /*ours*/, Random& /*random*/) {
  SceneResult result;
  const Watched without = stroke(nullptr);
  result.measures["unedited_force_step_N"] = without.step_N;
  double excess_N = -std::numeric_limits<double>::infinity();
  int notFinite = without.notFinite;
  for (const Edit& edit : kEdits) {
    const Watched with = stroke(edit.apply);
    result.measures[std::string(edit.name) + "_force_step_N"] = with.step_N;
    excess_N = std::max(excess_N, with.step_N - (kMaxRatio * without.step_N + kMaxExtra_N));
    notFinite += with.notFinite;
  }
  result.measures["excess_force_step_N"] = excess_N;
  result.measures["non_finite_ticks"] = notFinite;
  result.pass = excess_N <= 0 && notFinite == 0;
  return result;
}

}  // namespace haptics::eval
