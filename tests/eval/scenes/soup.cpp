// Moving, yielding, edited bodies under a hand that wanders among them: S20.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "common/mesh/generators.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

/// Ticks of one run; ten seeds make a million.
constexpr int kTicks = 100'000;
constexpr int kBodies = 8;
/// Half of the cube in which hand and bodies are (m).
constexpr double kRoom = 0.12;
/// Ticks between edits, on average.
constexpr int kBetweenEdits = 400;
/// The hand goes up and away for so long, and leaves the bodies alone for so long (ticks).
constexpr int kLeaving = 500;
constexpr int kAlone = 10'000;
/// Energy that a body alone may seem to gain (J): what lifts 0.1 kg by a micrometre.
constexpr double kMaxGain_J = 1e-6;

/// The same for all seeds; 1 kg, without gravity.
const std::array<MovingSolid, 6>& shapes() {
  static const std::array<MovingSolid, 6> all{
      solidFrom(makeBox({0.06, 0.04, 0.03}, 3).value()),  solidFrom(makeSphere(0.03, 10).value()),
      solidFrom(makeTorus(0.03, 0.012, 24, 12).value()),  solidFrom(makeCylinder(0.02, 0.05, 24).value()),
      solidFrom(makeBox({0.08, 0.08, 0.001}, 4).value()), solidFrom(makeSphere(0.02, 24).value()),
  };
  return all;
}

/// A hand that makes for one place after another, faster and slower.
class RandomWalker {
 public:
  explicit RandomWalker(Random& random) : random_(random) {}

  Vec3 next() {
    if (--ticksLeft_ <= 0) {
      target_ = kRoom * Vec3(random_.between(-1, 1), random_.between(-1, 1), random_.between(-1, 1));
      speed_m_per_s_ = std::pow(10.0, random_.between(-2, 0));
      ticksLeft_ = 50 + random_.below(600);
    }
    const Vec3 wanted = target_ - hip_;
    const double far = glm::length(wanted);
    const Vec3 velocity = far > 0 ? std::min(speed_m_per_s_, far / 0.02) / far * wanted : Vec3(0);
    velocity_ += 0.05 * (velocity - velocity_);
    return hip_ += kPeriod_s * velocity_;
  }

 private:
  Random& random_;
  Vec3 hip_{0, 0, 0.2};
  Vec3 velocity_{0};
  Vec3 target_{0};
  double speed_m_per_s_ = 0.1;
  int ticksLeft_ = 0;
};

/// The scene and its edits.
class Soup {
 public:
  explicit Soup(Random& random) : random_(random) {
    for (int i = 0; i < kBodies; ++i) addBody();
    world_.publish();
  }

  MovingWorld& world() { return world_; }

  void edit() {
    const auto& objects = world_.objects();
    const std::uint64_t id = objects[static_cast<std::size_t>(random_.below(static_cast<int>(objects.size())))].id;
    ServoObject& object = world_.object(id);
    switch (random_.below(9)) {
      case 8:
        object.tissue = object.tissue ? nullptr : std::make_shared<const SoftTissue>(someTissue());
        break;
      case 0:
        world_.setPose(id, somewhere());
        break;
      case 1:
        world_.setPose(id, object.pose);
        break;
      case 2:
        world_.setPose(id, {object.pose.rotation, object.pose.position + 0.002 * random_.direction()});
        break;
      case 3:
        object.stiffness_N_per_m = random_.between(200, 2000);
        object.damping_Ns_per_m = random_.between(0, 2);
        break;
      case 4:
        world_.setBody(id, someMotion(shapeOf_.at(id)));
        break;
      case 5:
        object.motion = object.motion ? nullptr : std::make_shared<RigidBody>(someMotion(shapeOf_.at(id)));
        break;
      case 6: {
        const auto shape = static_cast<std::size_t>(random_.below(static_cast<int>(shapes().size())));
        shapeOf_[id] = shape;
        object.surface = shapes()[shape].surface;
        if (object.motion) world_.setBody(id, someMotion(shape));
        break;
      }
      default:
        world_.remove(id);
        addBody();
    }
    world_.publish();
  }

 private:
  [[nodiscard]] Pose somewhere() {
    return {random_.rotation(),
            0.8 * kRoom * Vec3(random_.between(-1, 1), random_.between(-1, 1), random_.between(-1, 1))};
  }

  void addBody() {
    const auto shape = static_cast<std::size_t>(random_.below(static_cast<int>(shapes().size())));
    MovingSolid solid = shapes()[shape];
    solid.body = someMotion(shape);
    shapeOf_[world_.add(solid, somewhere(), random_.below(8) != 0)] = shape;
  }

  [[nodiscard]] SoftTissue someTissue() {
    const double return_s = random_.below(2) == 0 ? 0 : random_.between(0.01, 0.3);
    return {Falloff(random_.between(0.005, 0.02), 2 + static_cast<unsigned>(random_.below(4))),
            std::pow(10.0, random_.between(1, 3)), return_s};
  }

  /// Free on a spring, or on a floor; on a hinge or a slider; heavier or lighter.
  [[nodiscard]] RigidBody someMotion(std::size_t shape) {
    RigidBody body = shapes()[shape].body;
    const double mass_kg = std::pow(10.0, random_.between(-1.5, 0));
    body.mass.moments *= mass_kg / body.mass.mass_kg;
    body.mass.mass_kg = mass_kg;
    body.linearDamping_per_s = random_.between(0, 3);
    body.angularDamping_per_s = random_.between(0, 3);
    body.spring = {random_.between(20, 500), 0, random_.between(0.01, 0.3), 0};
    switch (random_.below(4)) {
      case 0:
        body.freedom = Freedom::kHinge;
        body.joint = {0.02 * random_.direction(), random_.direction(), -1, 1};
        break;
      case 1:
        body.freedom = Freedom::kSlider;
        body.joint = {Vec3(0), random_.direction(), -0.03, 0.03};
        break;
      case 2:
        body.gravity_m_per_s2 = {0, 0, -9.81};
        body.planes[0] = {.normal = {0, 0, 1}, .offset_m = -kRoom, .friction = random_.between(0, 1)};
        body.planeCount = 1;
        break;
      default:
        break;
    }
    return body;
  }

  Random& random_;
  MovingWorld world_;
  std::map<std::uint64_t, std::size_t> shapeOf_;
};

struct Counts {
  int touching = 0;
  int undetected = 0;
  int falseExits = 0;
  int ihipInside = 0;
  int notFinite = 0;
  int stopped = 0;
};

/// The hand may be in the hollow that a viscous body has not filled yet.
bool hasDent(const HapticState& state, std::size_t body) {
  return std::ranges::any_of(state.allDents(), [&](const BodyDent& dent) { return dent.body == body; });
}

void look(const MovingWorld& world, const TelemetrySample& sample, Vec3 hip, bool touched, Counts& counts) {
  const HapticState& state = world.state();
  counts.touching += sample.object != 0 ? 1 : 0;
  counts.notFinite += isFinite(sample.force.contact) && isFinite(sample.ihip) ? 0 : 1;
  for (std::size_t i = 0; i < state.moving.count; ++i) {
    counts.notFinite += isFinite(state.bodies[state.moving[i].body].current) ? 0 : 1;
    counts.stopped += isStopped(state.moving[i].state.condition) ? 1 : 0;
  }
  if (sample.object != 0) {
    for (std::size_t i = 0; i < state.objects.count; ++i) {
      if (hasDent(state, i)) continue;  // the IHIP is on it
      counts.ihipInside += world.depthIn(i, sample.ihip) > kInside_m && !state.bodies[i].pendingRemoval ? 1 : 0;
    }
    return;
  }
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    if (state.bodies[i].pendingRemoval || world.depthIn(i, hip) <= kInside_m || hasDent(state, i)) continue;
    ++counts.undetected;
    counts.falseExits += touched ? 1 : 0;
    return;
  }
}

/// The hand leaves; from then on no body is to gain energy. An integrator of second order lets it swing within a period:
/// what counts is by how much the peak of the second half of the time is above that of the first (J, the worst body's).
double largestGain(MovingWorld& world, Vec3 hip) {
  for (int tick = 0; tick < kLeaving; ++tick) {
    hip.z += kPeriod_s;
    (void)world.tick(hip);
  }
  std::map<std::uint64_t, std::array<double, 2>> peaks;
  for (int tick = 0; tick < kAlone; ++tick) {
    (void)world.tick(hip);
    for (const ServoObject& object : world.objects()) {
      if (!object.motion) continue;
      const double energy_J = world.energyOf(object.id);
      auto& peak = peaks.try_emplace(object.id, std::array{energy_J, energy_J}).first->second;
      double& now = peak[tick < kAlone / 2 ? 0 : 1];
      now = tick == kAlone / 2 ? energy_J : std::max(now, energy_J);
    }
  }
  double largest_J = -std::numeric_limits<double>::infinity();
  for (const auto& [id, peak] : peaks) largest_J = std::max(largest_J, peak[1] - peak[0]);
  return largest_J;
}

}  // namespace

SceneResult wanderAmongMovingBodies(Renderer& /*ours*/, Random& random) {
  Soup soup(random);
  RandomWalker hand(random);
  Counts counts;
  bool touched = false;
  int edits = 0;
  Vec3 hip(0);
  for (int tick = 0; tick < kTicks; ++tick) {
    if (random.below(kBetweenEdits) == 0) {
      soup.edit();
      ++edits;
    }
    hip = hand.next();
    const TelemetrySample sample = soup.world().tick(hip);
    look(soup.world(), sample, hip, touched, counts);
    touched = sample.object != 0;
  }
  const double gain_J = largestGain(soup.world(), hip);
  SceneResult result;
  result.measures = {{"ticks", kTicks},
                     {"edits", edits},
                     {"contact_ticks", counts.touching},
                     {"undetected_ticks", counts.undetected},
                     {"false_exits", counts.falseExits},
                     {"ihip_inside_ticks", counts.ihipInside},
                     {"non_finite_ticks", counts.notFinite},
                     {"stopped_body_ticks", counts.stopped},
                     {"energy_gain_alone_uJ", 1e6 * gain_J}};
  result.pass = counts.undetected == 0 && counts.falseExits == 0 && counts.notFinite == 0 &&
                counts.touching > kTicks / 100 && gain_J <= kMaxGain_J;
  return result;
}

}  // namespace haptics::eval
