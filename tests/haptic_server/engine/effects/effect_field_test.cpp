// Each kind of effect against its closed form, computed another way: by every segment instead of the hierarchy.
#include "haptic_server/engine/effects/effect_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace haptics::effect_field_test {
namespace {

using Kind = Effect::Kind;
constexpr double kPeriod_s = 1e-3;
constexpr int kStates = 100'000;
constexpr double kClose_N = 1e-9;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Vec3 unit() {
    for (;;) {
      const Vec3 v = vector(1);
      if (glm::length(v) > 0.1) return glm::normalize(v);
    }
  }
  bool chance() { return number(0, 1) < 0.5; }
  /// A walk of so many points.
  std::vector<Vec3> path(int points) {
    std::vector<Vec3> path{vector(0.05)};
    for (int i = 1; i < points; ++i) path.push_back(path.back() + number(0.001, 0.01) * unit());
    return path;
  }

 private:
  std::mt19937 engine_;
};

/// 3 t^2 - 2 t^3 on the way inside.
double smooth(double inside, double fade) {
  if (inside <= 0) return 0;
  if (fade == 0 || inside >= fade) return 1;
  return 3 * std::pow(inside / fade, 2) - 2 * std::pow(inside / fade, 3);
}

Vec3 atMost(Vec3 force, double limit) {
  const double length = glm::length(force);
  return limit > 0 && length > limit ? force / length * limit : force;
}

Effect randomSpring(Kind kind, Random& random) {
  Effect effect{.kind = kind};
  effect.point_m = random.vector(0.05);
  effect.direction = random.unit();
  effect.stiffness_N_per_m = random.number(10, 2000);
  effect.damping_Ns_per_m = random.chance() ? random.number(0, 5) : 0;
  if (random.chance()) effect.limit_N = random.number(0.1, 5);
  if (random.chance()) {
    effect.reach_m = random.number(0.01, 0.1);
    if (random.chance()) effect.release_m = effect.reach_m * random.number(1, 2);
    if (random.chance()) effect.fade_m = effect.reach_m * random.number(0.01, 1);
  }
  return effect;
}

/// @param far  From the HIP to the target.
/// @param damped  The velocity that the damper sees.
Vec3 springLaw(const Effect& effect, Vec3 far, Vec3 damped, bool held) {
  double weight = 1;
  if (effect.reach_m > 0) {
    const double release = std::max(effect.reach_m, effect.release_m), r = glm::length(far);
    if (r >= (held ? release : effect.reach_m)) return Vec3(0);
    weight = smooth(release - r, effect.fade_m);
  }
  return weight * atMost(effect.stiffness_N_per_m * far - effect.damping_Ns_per_m * damped, effect.limit_N);
}

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
    ASSERT_LE(glm::distance(is, expected), 1e-8) << "state " << i;  // `farthest` has fewer digits than a part
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

/// Round a loop of two sines in each direction; where the nearest place leaps, the step is halved down to it.
double workRound(const EffectField& field, const std::array<Vec3, 5>& loop) {
  EffectMemory memory;
  const auto place = [&](double s) {
    Vec3 x = loop[0];
    for (std::size_t k = 1; k <= 2; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) * s;
      x += loop[2 * k - 1] * std::cos(angle) + loop[2 * k] * std::sin(angle);
    }
    return x;
  };
  const auto force = [&](double s) { return field.felt(memory, place(s), Vec3(0), kPeriod_s).force_N; };
  const std::function<double(double, double, Vec3, Vec3)> work = [&](double from, double to, Vec3 first, Vec3 last) {
    const double way = glm::distance(place(from), place(to));
    if (glm::distance(first, last) * way > 2e-6 && way > 1e-12) {
      const double middle = (from + to) / 2;
      const Vec3 between = force(middle);
      return work(from, middle, first, between) + work(middle, to, between, last);
    }
    return glm::dot((first + last) / 2.0, place(to) - place(from));
  };
  constexpr int kSteps = 200;
  static_cast<void>(force(0));
  double sum_J = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double from = static_cast<double>(i) / kSteps, to = static_cast<double>(i + 1) / kSteps;
    sum_J += work(from, to, force(from), force(to));
  }
  return sum_J;
}

TEST(EffectField, ConservativeOnesGiveNothingRoundALoop) {
  Random random(5);
  constexpr int kLoops = 10'000;
  for (int i = 0; i < kLoops; ++i) {
    Effect effect = randomSpring(static_cast<Kind>(2 + i % 4), random);
    effect.damping_Ns_per_m = effect.release_m = 0;
    if (effect.reach_m > 0) effect.fade_m = std::max(effect.fade_m, 0.2 * effect.reach_m);
    if (effect.kind == Kind::kSpringToPath) effect.path_m = random.path(10);
    if (i % 5 == 0) effect.kind = Kind::kForbiddenSide;
    effect.stiffness_N_per_m = std::min(effect.stiffness_N_per_m, 300.0);
    std::array<Vec3, 5> loop;
    for (Vec3& part : loop) part = random.vector(0.005);
    ASSERT_LE(std::abs(workRound(EffectField(effect), loop)), 10e-6)
        << "loop " << i << " kind " << static_cast<int>(effect.kind);
  }
}

TEST(EffectField, TubesGiveNothingRoundALoop) {
  Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const Effect tube{.kind = Kind::kTube,
                      .path_m = random.path(10),
                      .stiffness_N_per_m = random.number(10, 300),
                      .size_m = Vec3(random.number(0.001, 0.02), 0, 0)};
    std::array<Vec3, 5> loop;
    for (Vec3& part : loop) part = random.vector(0.005);
    ASSERT_LE(std::abs(workRound(EffectField(tube), loop)), 10e-6) << "loop " << i;
  }
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

}  // namespace
}  // namespace haptics::effect_field_test
