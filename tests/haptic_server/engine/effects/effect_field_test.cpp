// Each kind of effect against its closed form, computed another way: by every segment instead of the hierarchy.
#include "haptic_server/engine/effects/effect_field.h"

#include <gtest/gtest.h>

#include "tests/haptic_server/engine/effects/effect_laws.h"

namespace haptics::effect_field_test {
namespace {

using namespace effect_laws;

TEST(EffectField, SpringsFollowTheirClosedForm) {
  Random random(1);
  for (const Kind kind : {Kind::kSpringToPoint, Kind::kSpringToLine, Kind::kSpringToPlane}) {
    int felt = 0;
    for (int i = 0; i < kStates; ++i) {
      const Effect effect = randomSpring(kind, random);
      EffectMemory memory;
      memory.holds = random.chance();
      const bool held = memory.holds;
      const Vec3 hip = random.vector(0.1), v = random.vector(0.5), n = effect.direction;
      const Vec3 from = hip - effect.point_m;
      const Vec3 along = glm::dot(from, n) * n, vAlong = glm::dot(v, n) * n;
      Vec3 expected;
      if (kind == Kind::kSpringToPoint) expected = springLaw(effect, -from, v, held);
      if (kind == Kind::kSpringToLine) expected = springLaw(effect, along - from, v - vAlong, held);
      if (kind == Kind::kSpringToPlane) expected = springLaw(effect, -along, vAlong, held);
      const Vec3 is = EffectField(effect).felt(memory, hip, v, kPeriod_s).force_N;
      felt += is != Vec3(0) ? 1 : 0;
      ASSERT_LE(glm::distance(is, expected), kClose_N) << static_cast<int>(kind) << " state " << i;
    }
    EXPECT_GT(felt, kStates / 2);
  }
}

struct Nearest {
  double squared = 1e300;
  std::size_t segment = 0;
  double part = 0;
  Vec3 point{0};
};

Nearest nearestOf(const std::vector<Vec3>& path, Vec3 x, std::size_t from = 0) {
  Nearest best;
  for (std::size_t i = from; i + 1 < path.size(); ++i) {
    const Vec3 way = path[i + 1] - path[i];
    const double part = std::min(std::max(glm::dot(x - path[i], way) / glm::dot(way, way), 0.0), 1.0);
    const Vec3 point = glm::mix(path[i], path[i + 1], part);
    const double squared = glm::dot(x - point, x - point);
    if (squared < best.squared) best = {squared, i, part, point};
  }
  return best;
}

Vec3 meanTangent(const std::vector<Vec3>& path, std::size_t point) {
  Vec3 sum(0);
  if (point > 0) sum += glm::normalize(path[point] - path[point - 1]);
  if (point + 1 < path.size()) sum += glm::normalize(path[point + 1] - path[point]);
  return glm::normalize(sum);
}

Vec3 across(const std::vector<Vec3>& path, std::size_t segment, double part, Vec3 v) {
  const Vec3 t = glm::normalize(glm::mix(meanTangent(path, segment), meanTangent(path, segment + 1), part));
  return v - glm::dot(v, t) * t;
}

TEST(EffectField, ASpringToAPathPullsToItsNearestPlace) {
  Random random(2);
  for (int paths = 0; paths < 100; ++paths) {
    Effect effect = randomSpring(Kind::kSpringToPath, random);
    effect.path_m = random.path(2 + paths * 3);
    const EffectField field(effect);
    EffectMemory memory;
    for (int i = 0; i < kStates / 100; ++i) {
      memory.holds = random.chance();
      const bool held = memory.holds;
      const Vec3 hip = effect.path_m[static_cast<std::size_t>(i) % effect.path_m.size()] + random.vector(0.02);
      const Vec3 v = random.vector(0.5);
      const Nearest nearest = nearestOf(effect.path_m, hip);
      const Vec3 is = field.felt(memory, hip, v, kPeriod_s).force_N;
      const Vec3 expected =
          springLaw(effect, nearest.point - hip, across(effect.path_m, nearest.segment, nearest.part, v), held);
      ASSERT_LE(glm::distance(is, expected), kClose_N) << "path " << paths << " state " << i;
    }
  }
}

/// A path that bends little near the hand has one nearest place there: the guide's, as far as it is not behind.
TEST(EffectField, AGuideHoldsTheHandAndDoesNotGoBack) {
  Random random(3);
  std::vector<Vec3> path;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.02 * i;
    path.emplace_back(0.1 * std::cos(t), 0.1 * std::sin(t), 0.002 * t);  // three turns and a bit, 12.6 mm apart
  }
  const Effect effect{
      .kind = Kind::kGuide, .path_m = path, .stiffness_N_per_m = 300, .damping_Ns_per_m = 1, .limit_N = 2};
  const EffectField field(effect);
  EffectMemory memory;
  double farthest = 0, along = 0;
  for (int i = 0; i < kStates; ++i) {
    along = std::clamp(along + random.number(-0.1, 0.11), 0.0, 998.0);
    const double t = 0.02 * along;
    const Vec3 hip = Vec3(0.1 * std::cos(t), 0.1 * std::sin(t), 0.002 * t) + random.vector(0.001);
    const Vec3 v = random.vector(0.2);
    Nearest nearest;
    const auto first = static_cast<std::size_t>(std::max(0.0, along - 40));
    for (std::size_t k = first; k < std::min<std::size_t>(999, static_cast<std::size_t>(along) + 40); ++k) {
      Nearest on = nearestOf({path[k], path[k + 1]}, hip);
      on.segment = k;
      if (on.squared < nearest.squared) nearest = on;
    }
    const double place = static_cast<double>(nearest.segment) + nearest.part;
    if (place < farthest) {
      nearest.segment = std::min<std::size_t>(static_cast<std::size_t>(farthest), path.size() - 2);
      nearest.part = farthest - static_cast<double>(nearest.segment);
      nearest.point = glm::mix(path[nearest.segment], path[nearest.segment + 1], nearest.part);
    }
    farthest = std::max(farthest, place);
    const Vec3 is = field.felt(memory, hip, v, kPeriod_s).force_N;
    const Vec3 expected = springLaw(effect, nearest.point - hip, across(path, nearest.segment, nearest.part, v), true);
    ASSERT_LE(glm::distance(is, expected), kClose_N) << "state " << i;
  }
  EXPECT_GT(farthest, 400) << "it went on";
}

TEST(EffectField, AGuideThatCrossesItselfStaysOnItsBranch) {
  std::vector<Vec3> path;
  for (int i = 0; i <= 400; ++i) {
    const double t = 2 * std::numbers::pi * i / 400;
    path.emplace_back(0.05 * std::sin(t), 0.05 * std::sin(t) * std::cos(t), 0);  // an eight, crossing at its middle
  }
  const EffectField field(Effect{.kind = Kind::kGuide, .path_m = path, .stiffness_N_per_m = 300});
  EffectMemory memory;
  for (std::size_t i = 0; i < path.size(); ++i) {
    static_cast<void>(field.felt(memory, path[i] + Vec3(0, 0, 0.001), Vec3(0), kPeriod_s));
    ASSERT_NEAR(static_cast<double>(memory.segment) + memory.part, static_cast<double>(i), 1.5) << "at point " << i;
  }
}

TEST(EffectField, ForbiddenSidesRegionsAndVibrationFollowTheirClosedForms) {
  Random random(4);
  double turns = 0;
  for (int i = 0; i < kStates; ++i) {
    const Vec3 hip = random.vector(0.1), v = random.vector(0.5), n = random.unit(), at = random.vector(0.05);
    const double k = random.number(10, 2000), b = random.number(0.1, 20), limit = random.chance() ? 1.5 : 0;
    EffectMemory memory;
    const double depth = glm::dot(at - hip, n);
    const double push = k * depth + std::min(std::max(-b * glm::dot(v, n), -k * depth), k * depth);
    const Effect side{.kind = Kind::kForbiddenSide,
                      .point_m = at,
                      .direction = n,
                      .stiffness_N_per_m = k,
                      .damping_Ns_per_m = b,
                      .limit_N = limit};
    ASSERT_LE(glm::distance(EffectField(side).felt(memory, hip, v, kPeriod_s).force_N,
                            depth > 0 ? atMost(push * n, limit) : Vec3(0)),
              kClose_N);

    Effect region{.point_m = at, .direction = n};
    region.region = static_cast<Effect::Region>(1 + i % 3);
    const Vec3 from = hip - at, size(random.number(0.05, 0.3), random.number(0.05, 0.3), random.number(0.05, 0.3));
    double weight = 1;
    if (region.region != Effect::Region::kEverywhere) {
      region.size_m = size;
      region.fade_m = random.chance() ? random.number(0.001, 0.05) : 0;
      const double inBox =
          std::min({size.x / 2 - std::abs(from.x), size.y / 2 - std::abs(from.y), size.z / 2 - std::abs(from.z)});
      const double inSphere = size.x / 2 - glm::length(from);
      weight = smooth(region.region == Effect::Region::kBox ? inBox : inSphere, region.fade_m);
    }
    region.kind = Kind::kViscosity;
    region.damping_Ns_per_m = b;
    region.limit_N = limit;
    memory = {};
    ASSERT_LE(
        glm::distance(EffectField(region).felt(memory, hip, v, kPeriod_s).force_N, weight * atMost(-b * v, limit)),
        kClose_N);
    region.kind = Kind::kConstant;
    region.amplitude_N = random.number(0.1, 3);
    ASSERT_LE(
        glm::distance(EffectField(region).felt(memory, hip, v, kPeriod_s).force_N, weight * region.amplitude_N * n),
        kClose_N);
    region.kind = Kind::kVibration;
    region.frequency_Hz = random.number(1, 300);
    region.phase_rad = random.number(-3, 3);
    memory.turns = turns - std::floor(turns);
    const Vec3 is = EffectField(region).felt(memory, hip, v, kPeriod_s).force_N;
    const double sine = std::sin(2 * std::numbers::pi * turns + region.phase_rad);
    ASSERT_LE(glm::distance(is, weight * region.amplitude_N * sine * n), kClose_N) << "the phase goes on";
    turns = std::fmod(turns + region.frequency_Hz * kPeriod_s, 1.0);
  }
}

TEST(EffectField, TubesFollowTheirClosedForm) {
  Random random(6);
  int felt = 0;
  for (int i = 0; i < kStates; ++i) {
    const Vec3 hip = random.vector(0.06), v = random.vector(0.5);
    const double k = random.number(10, 2000), b = random.number(0, 20), limit = random.chance() ? 1.5 : 0;
    const Effect tube{.kind = Kind::kTube,
                      .path_m = random.path(8),
                      .stiffness_N_per_m = k,
                      .damping_Ns_per_m = b,
                      .limit_N = limit,
                      .size_m = Vec3(random.number(0.001, 0.1), 0, 0)};
    const Nearest nearest = nearestOf(tube.path_m, hip);
    const double depth = std::sqrt(nearest.squared) - tube.size_m.x / 2;
    const Vec3 inward = glm::normalize(nearest.point - hip);
    const double push = k * depth + std::min(std::max(-b * glm::dot(v, inward), -k * depth), k * depth);
    EffectMemory memory;
    const Vec3 is = EffectField(tube).felt(memory, hip, v, kPeriod_s).force_N;
    felt += depth > 0 ? 1 : 0;
    ASSERT_LE(glm::distance(is, depth > 0 ? atMost(push * inward, limit) : Vec3(0)), kClose_N) << "state " << i;
  }
  EXPECT_GT(felt, kStates / 3);
  EXPECT_LT(felt, kStates * 19 / 20);
}

/// Of any kind that needs no mesh and is no matter of time.
Effect randomField(Random& random) {
  constexpr std::array kKinds{Kind::kConstant,      Kind::kSpringToPoint, Kind::kSpringToLine,
                              Kind::kSpringToPlane, Kind::kSpringToPath,  Kind::kGuide,
                              Kind::kForbiddenSide, Kind::kViscosity,     Kind::kTube};
  Effect effect = randomSpring(kKinds[static_cast<std::size_t>(random.number(0, 8.999))], random);
  if (effect.kind == Kind::kConstant || effect.kind == Kind::kViscosity) {
    effect.amplitude_N = random.number(0.1, 3);
    effect.region = random.chance() ? Effect::Region::kBox : Effect::Region::kSphere;
    effect.size_m = Vec3(random.number(0.05, 0.2), random.number(0.05, 0.2), random.number(0.05, 0.2));
    effect.fade_m = random.chance() ? random.number(0.001, 0.05) : 0;
  }
  if (effect.kind == Kind::kSpringToPath || effect.kind == Kind::kGuide || effect.kind == Kind::kTube)
    effect.path_m = random.path(10);
  if (effect.kind == Kind::kTube) effect.size_m.x = random.number(0.001, 0.05);
  return effect;
}

/// A hand that goes straight, with whatever velocity: from place to place the force changes by no more than its steepest law does.
TEST(EffectField, TheForceStepsNowhereWithoutSayingSo) {
  Random random(13);
  constexpr double kWay_m = 1e-6;
  constexpr int kPlaces = 2000;
  int jumps = 0;
  for (int i = 0; i < 2000; ++i) {
    const Effect effect = randomField(random);
    const EffectField field(effect);
    const Vec3 towards = kWay_m * random.unit(), v = random.vector(0.5);
    const Vec3 near = effect.path_m.empty() ? effect.point_m : effect.path_m[5];
    const double out = random.number(0, 1);
    Vec3 hip = near + out * std::max({effect.reach_m, effect.size_m.x / 2, 0.01}) * random.unit();
    if (random.chance()) hip = near + (effect.reach_m + 1e-4) * random.unit() - 100.0 * towards;
    EffectMemory memory;
    const double damping = effect.damping_Ns_per_m * glm::length(v),
                 reach_m = std::max(effect.reach_m, effect.release_m);
    const double strongest_N = effect.amplitude_N + damping + effect.stiffness_N_per_m * reach_m;
    double steepest = 3 * effect.stiffness_N_per_m + (effect.fade_m > 0 ? 1.5 * strongest_N / effect.fade_m : 0);
    if (!effect.path_m.empty()) steepest += 4 * damping * 2 / 1e-3;  // the tangent turns over a millimetre or more
    if (effect.kind == Kind::kForbiddenSide || effect.kind == Kind::kTube) steepest += effect.stiffness_N_per_m;
    Vec3 before = field.felt(memory, hip, v, kPeriod_s).force_N;
    for (int k = 0; k < kPlaces; ++k) {
      hip += towards;
      const EffectField::Felt felt = field.felt(memory, hip, v, kPeriod_s);
      jumps += felt.jumped ? 1 : 0;
      if (!felt.jumped) {
        ASSERT_LE(glm::distance(felt.force_N, before), 1.01 * steepest * kWay_m + 1e-12)
            << "kind " << static_cast<int>(effect.kind) << " effect " << i << " place " << k;
      }
      before = felt.force_N;
    }
  }
  EXPECT_GT(jumps, 100);
}

/// The slope has no step at either end of the fade: there a second difference falls with the square of the way.
TEST(EffectField, FadesHaveNoCorner) {
  Random random(14);
  constexpr double kWay_m = 1e-7;
  for (int i = 0; i < kStates / 10; ++i) {
    constexpr std::array kKinds{Kind::kSpringToPoint, Kind::kSpringToLine, Kind::kSpringToPlane, Kind::kConstant,
                                Kind::kViscosity};
    Effect effect = randomSpring(kKinds[static_cast<std::size_t>(i) % kKinds.size()], random);
    const bool isInRegion = i % 5 >= 3;
    effect.limit_N = 0;
    effect.amplitude_N = 1;
    effect.reach_m = isInRegion ? 0 : random.number(0.01, 0.1);
    effect.release_m = 0;
    effect.region = !isInRegion  ? Effect::Region::kEverywhere
                    : i % 2 == 0 ? Effect::Region::kBox
                                 : Effect::Region::kSphere;
    effect.size_m = Vec3(random.number(0.02, 0.2), 1, 1);
    effect.fade_m = (isInRegion ? effect.size_m.x / 2 : effect.reach_m) * random.number(0.1, 0.9);
    const double border_m = isInRegion ? effect.size_m.x / 2 : effect.reach_m;
    Vec3 out = isInRegion ? Vec3(random.chance() ? 1 : -1, 0, 0) : random.unit();
    if (effect.kind == Kind::kSpringToPlane) out = effect.direction;
    if (effect.kind == Kind::kSpringToLine) out = glm::normalize(glm::cross(out, effect.direction));
    const Vec3 v = random.vector(0.5);
    const EffectField field(effect);
    const auto forceAt = [&](double far_m) {
      EffectMemory memory;
      memory.holds = true;
      return field.felt(memory, effect.point_m + far_m * out, v, kPeriod_s).force_N;
    };
    const double strongest_N =
        effect.amplitude_N + effect.stiffness_N_per_m * border_m + effect.damping_Ns_per_m * glm::length(v);
    for (const double end_m : {border_m, border_m - effect.fade_m}) {
      const Vec3 bend = forceAt(end_m - kWay_m) - 2.0 * forceAt(end_m) + forceAt(end_m + kWay_m);
      const double t = kWay_m / effect.fade_m;
      ASSERT_LE(glm::length(bend), 8 * strongest_N * t * t + 1e-12)
          << "kind " << static_cast<int>(effect.kind) << " effect " << i;
    }
  }
}

/// The force on a hand at rest, of one that is held on.
std::function<Vec3(Vec3)> at(const EffectField& field) {
  return [field, memory = EffectMemory{}](Vec3 hip) mutable {
    return field.felt(memory, hip, Vec3(0), kPeriod_s).force_N;
  };
}

TEST(EffectField, ConservativeOnesGiveNothingRoundALoop) {
  Random random(5);
  constexpr int kLoops = 10'000;
  double worst_J = 0;
  for (int i = 0; i < kLoops; ++i) {
    Effect effect = randomSpring(static_cast<Kind>(2 + i % 4), random);
    effect.damping_Ns_per_m = effect.release_m = 0;
    if (effect.reach_m > 0) effect.fade_m = std::max(effect.fade_m, 0.2 * effect.reach_m);
    if (effect.kind == Kind::kSpringToPath) effect.path_m = random.path(10);
    if (i % 5 == 0) effect.kind = Kind::kForbiddenSide;
    effect.stiffness_N_per_m = std::min(effect.stiffness_N_per_m, 300.0);
    std::array<Vec3, 5> loop;
    for (Vec3& part : loop) part = random.vector(0.005);
    const double work_J = std::abs(workRound(at(EffectField(effect)), loop));
    ASSERT_LE(work_J, 10e-6) << "loop " << i << " kind " << static_cast<int>(effect.kind);
    worst_J = std::max(worst_J, work_J);
  }
  RecordProperty("worst_uJ", std::to_string(1e6 * worst_J));
}

TEST(EffectField, TubesGiveNothingRoundALoop) {
  Random random(8);
  double worst_J = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Effect tube{.kind = Kind::kTube,
                      .path_m = random.path(10),
                      .stiffness_N_per_m = random.number(10, 300),
                      .size_m = Vec3(random.number(0.001, 0.02), 0, 0)};
    std::array<Vec3, 5> loop;
    for (Vec3& part : loop) part = random.vector(0.005);
    const double work_J = std::abs(workRound(at(EffectField(tube)), loop));
    ASSERT_LE(work_J, 10e-6) << "loop " << i;
    worst_J = std::max(worst_J, work_J);
  }
  RecordProperty("worst_uJ", std::to_string(1e6 * worst_J));
}

/// A hysteresis takes energy and gives none.
TEST(EffectField, ReleaseFartherThanReachTakesEnergy) {
  const EffectField field(Effect{
      .kind = Kind::kSpringToPoint, .stiffness_N_per_m = 200, .reach_m = 0.01, .release_m = 0.02, .fade_m = 0.005});
  EffectMemory memory;
  double sum_J = 0;
  for (int i = -30'000; i < 30'000; ++i) {
    const Vec3 hip(1e-6 * (i + 0.5), 0, 0);
    sum_J += field.felt(memory, hip, Vec3(0), kPeriod_s).force_N.x * 1e-6;
  }
  EXPECT_LT(sum_J, -0.001);
}

/// Of the equations m du/dt = -F, F = k (y - x) + b (u - v) at the tick's end: solved for F.
Vec3 inertiaLaw(const Effect& effect, double weight, Vec3 lag, Vec3 mass, Vec3 v) {
  const double k = effect.stiffness_N_per_m, b = effect.damping_Ns_per_m, m = weight * effect.mass_kg;
  const double T = kPeriod_s;
  return atMost((k * (lag + T * mass) + b * (mass - v)) * m / (m + T * (b + T * k)), effect.limit_N);
}

Effect randomInertia(Random& random) {
  Effect effect{.kind = Kind::kInertia};
  effect.stiffness_N_per_m = random.number(10, 2000);
  effect.damping_Ns_per_m = random.chance() ? random.number(0, 20) : 0;
  effect.mass_kg = random.number(1e-3, 2);
  if (random.chance()) effect.limit_N = random.number(0.1, 5);
  if (random.chance()) {
    effect.region = Effect::Region::kSphere;
    effect.size_m.x = random.number(0.05, 0.3);
    effect.fade_m = random.chance() ? random.number(0.001, 0.05) : 0;
  }
  return effect;
}

TEST(EffectField, InertiaFollowsItsClosedForm) {
  Random random(9);
  int joined = 0;
  for (int i = 0; i < kStates; ++i) {
    const Effect effect = randomInertia(random);
    const Vec3 hip = random.vector(0.1), v = random.vector(0.5);
    const double weight =
        effect.region == Effect::Region::kSphere ? smooth(effect.size_m.x / 2 - glm::length(hip), effect.fade_m) : 1;
    EffectMemory memory;
    memory.holds = random.chance();
    memory.part = memory.holds ? random.number(0.01, 1) : 0;
    memory.target = hip + random.vector(0.005);
    memory.velocity = random.vector(0.5);
    const bool held = memory.holds;
    Vec3 lag = memory.target - hip, mass = memory.velocity;
    if (!held) lag = mass = Vec3(0);
    if (weight > memory.part) mass *= memory.part / weight;
    joined += weight > memory.part ? 1 : 0;
    const Vec3 is = EffectField(effect).felt(memory, hip, v, kPeriod_s).force_N;
    ASSERT_LE(glm::distance(is, weight > 0 ? inertiaLaw(effect, weight, lag, mass, v) : Vec3(0)), kClose_N)
        << "state " << i;
    if (weight > 0 && effect.limit_N > 0) {
      ASSERT_LE(glm::distance(memory.target, hip) * effect.stiffness_N_per_m, effect.limit_N * 1.000001);
    }
  }
  EXPECT_GT(joined, kStates / 4);
}

TEST(EffectField, InertiaIsMassTimesAcceleration) {
  const EffectField field(
      Effect{.kind = Kind::kInertia, .stiffness_N_per_m = 500, .damping_Ns_per_m = 10, .mass_kg = 0.2});
  const Vec3 acceleration(1, -2, 0.5);
  EffectMemory memory;
  Vec3 force_N(0);
  for (int i = 0; i < 2000; ++i) {
    const double t = kPeriod_s * i;
    force_N = field.felt(memory, acceleration * (t * t / 2), acceleration * t, kPeriod_s).force_N;
  }
  EXPECT_LT(glm::distance(force_N, -0.2 * acceleration), 1e-6);
}

/// In and out of its region, with whatever limit.
TEST(EffectField, InertiaGivesNoMoreThanItWasGiven) {
  Random random(10);
  for (int runs = 0; runs < 200; ++runs) {
    Effect effect = randomInertia(random);
    effect.limit_N = 0;
    const EffectField field(effect);
    EffectMemory memory;
    Vec3 hip(0), speed(0);
    double given_J = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 before = hip;
      speed = 0.99 * speed + random.vector(0.05) - 0.01 * hip;
      hip += kPeriod_s * speed;
      given_J += glm::dot(field.felt(memory, hip, speed, kPeriod_s).force_N, hip - before);
      ASSERT_LE(given_J, 1e-12) << "run " << runs << " tick " << i;
    }
    EXPECT_LT(given_J, -1e-6);
  }
}

/// Of the mean over the tick, by places that lie a sample apart at most, on straight lines between samples.
TEST(EffectField, SamplesAreFeltAtTheirRate) {
  Random random(12);
  for (int i = 0; i < 100; ++i) {
    Effect effect{.kind = Kind::kSamples, .direction = random.unit(), .amplitude_N = random.number(0.1, 3)};
    effect.sample_rate_Hz = random.chance() ? random.number(1, 1000) : random.number(1000, 192'000);
    effect.samples.resize(2 + static_cast<std::size_t>(random.number(0, 3000)));
    for (float& sample : effect.samples) sample = static_cast<float>(random.number(-1, 1));
    if (random.chance()) effect.trigger = Effect::Trigger::kButton;
    const bool once = effect.trigger == Effect::Trigger::kButton;
    const auto count = static_cast<double>(effect.samples.size());
    const auto valueAt = [&](double place) {
      const double from = std::floor(place);
      const auto sampleAt = [&](double k) -> double {
        if (once && k >= count) return 0;
        return static_cast<double>(effect.samples[static_cast<std::size_t>(std::fmod(k, count))]);
      };
      return sampleAt(from) + (place - from) * (sampleAt(from + 1) - sampleAt(from));
    };
    const double step = effect.sample_rate_Hz * kPeriod_s, places = std::ceil(step);
    const EffectField field(effect);
    EffectMemory memory;
    double turns = 0, last = 0;
    for (int tick = 0; tick < kStates / 100; ++tick) {
      double mean = 0;
      for (double k = 0; k < places; ++k) mean += valueAt(turns + k * step / places) / places;
      const EffectField::Felt felt = field.felt(memory, random.vector(0.1), Vec3(0), kPeriod_s);
      ASSERT_LE(glm::distance(felt.force_N, effect.amplitude_N * mean * effect.direction), kClose_N)
          << i << " tick " << tick;
      if (tick > 0) {
        ASSERT_NEAR(felt.byTime_N, effect.amplitude_N * std::abs(mean - last), kClose_N) << i << " tick " << tick;
      }
      last = mean;
      turns = once ? std::min(turns + step, count) : std::fmod(turns + step, count);
    }
    if (!once) continue;
    memory.holds = false;  // let go, and pressed again
    const Vec3 again = field.felt(memory, Vec3(0), Vec3(0), kPeriod_s).force_N;
    if (places > 1) continue;
    EXPECT_EQ(again, effect.amplitude_N * double{effect.samples[0]} * effect.direction);
  }
}

}  // namespace
}  // namespace haptics::effect_field_test
