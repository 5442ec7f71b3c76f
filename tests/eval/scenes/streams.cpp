// What comes in small steps while the hand rests: bodies driven against it, shapes and poses edited under it. S36 to S38, P5, P6.

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "tests/eval/closest_on_triangle.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kWide_m = 0.2;
const Vec3 kUp(0, 0, 1);

struct Wrong {
  int ticks = 0;
  int wrong = 0;
  double worst_N = 0;

  void see(double error_N, bool right) {
    ++ticks;
    worst_N = std::max(worst_N, error_N);
    wrong += right ? 0 : 1;
  }
};

/// A plate of 2 um to 0.5 mm, or an open sheet of either side, that is driven at 1 mm/s to 1 m/s past a hand at rest and
/// back, also turning: a sample of its pose comes in every tick. The exact place of the IHIP is on the face's plane.
void drivePast(Renderer& method, Random& random, Wrong& wrong) {
  constexpr double kOff_N = kSpring_N_per_m * 1e-6;
  const bool isSheet = random.below(2) == 0;
  const double thickness_m = isSheet ? 0 : 2e-6 * std::pow(250, random.between(0, 1));
  const Quat over = isSheet && random.below(2) == 0 ? Quat(0, 1, 0, 0) : Quat(1, 0, 0, 0);
  const double step_m = 1e-6 * std::pow(1000, random.between(0, 1));
  const double past_m = std::clamp(300 * step_m, 0.0002, 0.02);
  const Vec3 axis = glm::normalize(Vec3(random.between(-1, 1), random.between(-1, 1), 0));
  const double turn_rad = random.below(2) == 0 ? 0 : 0.002;
  const Vec3 hip(random.between(-0.01, 0.01), random.between(-0.01, 0.01), 0);

  Stage stage(method, random);
  const shapes::Shape shape = isSheet ? shapes::sheet(kWide_m, 3) : shapes::box({kWide_m, kWide_m, thickness_m}, 2);
  double height_m = -0.001 - random.between(0, step_m);
  double angle_rad = 0;
  const auto pose = [&] {
    const Quat turn = glm::angleAxis(angle_rad, axis);
    return Pose{turn * over, Vec3(hip.x, hip.y, height_m) - turn * kUp * (thickness_m / 2)};
  };
  const int body = stage.add(shape.build(), pose());
  stage.begin(hip);
  for (int i = 0; i < 5; ++i) (void)stage.drive(hip, true);
  int way = 1;
  while (way > 0 || height_m > -0.001) {
    height_m += way * step_m;
    if (height_m > -0.0005) angle_rad += way * turn_rad * std::min(1.0, step_m / 1e-4);
    if (height_m > past_m) way = -1;
    stage.move(body, pose());
    const Felt felt = stage.drive(hip, true);
    const Vec3 normal = glm::angleAxis(angle_rad, axis) * kUp;
    const double depth_m = glm::dot(normal, Vec3(hip.x, hip.y, height_m) - hip);
    const Vec3 exact_N = kSpring_N_per_m * std::max(depth_m, 0.0) * normal;
    const double error_N = glm::distance(felt.force_N, exact_N);
    const bool touchesRightly = felt.touching == (depth_m > 0) || std::abs(depth_m) < 1e-6;
    wrong.see(error_N, isFinite(felt.force_N) && error_N < kOff_N && touchesRightly);
  }
}

/// A block under the hand goes up and down, of which samples come some 60 times a second, early, late, or not at all. The
/// force has to be one that the path has had within two of the longest intervals, and must not step by more than three
/// times what the path's speed makes of a tick.
void streamUnder(Renderer& method, Random& random, Wrong& wrong) {
  constexpr int kStreamed = 2500, kRest = 300;
  constexpr int kLongest = 40;
  constexpr double kOff_N = 0.02;
  const double amplitude_m = random.between(0.002, 0.01);
  const double speed_m_per_s = random.between(0.05, 0.3);
  const double rate = speed_m_per_s / amplitude_m * kPeriod_s;
  const double sideways_m = random.between(0, 0.02);
  const double pressed_m = random.between(-0.002, 0.003);
  const Vec3 hip(random.between(-0.01, 0.01), random.between(-0.01, 0.01), 0);
  const auto topAt = [&](int tick) { return pressed_m + amplitude_m * std::sin(rate * std::max(0, tick - kRest)); };
  const auto poseAt = [&](int tick) {
    const double aside = sideways_m * std::sin(0.7 * rate * std::max(0, tick - kRest));
    return Pose{{1, 0, 0, 0}, {aside, -aside / 2, topAt(tick) - 0.05}};
  };
  Stage stage(method, random);
  const Pose away{{1, 0, 0, 0}, {0, 0, -0.06}};
  const int body = stage.add(shapes::box({kWide_m, kWide_m, 0.1}, 4).build(), away);
  stage.begin(hip);
  std::deque<double> depths_m;
  double before_N = 0;
  int due = 0;
  for (int tick = 0; tick < kStreamed; ++tick) {
    const bool comes = tick >= due;
    if (comes) {
      stage.move(body, poseAt(tick));
      due = tick + 12 + random.below(9) + (random.below(20) == 0 ? 16 : 0);
    }
    const Felt felt = stage.drive(hip, comes);
    depths_m.push_back(std::max(0.0, topAt(tick)));
    if (depths_m.size() > 2 * kLongest) depths_m.pop_front();
    if (tick >= kRest) {
      const auto [least, most] = std::ranges::minmax(depths_m);
      const double up_N = felt.force_N.z;
      const double off_N = std::max({kSpring_N_per_m * least - up_N, up_N - kSpring_N_per_m * most, 0.0});
      const double aside_N = std::hypot(felt.force_N.x, felt.force_N.y);
      const double step_N = std::abs(up_N - before_N) - 3 * kSpring_N_per_m * speed_m_per_s * kPeriod_s;
      const double worst_N = std::max({off_N, aside_N, step_N});
      wrong.see(worst_N, isFinite(felt.force_N) && worst_N < kOff_N);
    }
    before_N = felt.force_N.z;
  }
}

/// A block grows and shrinks under the hand, is lifted and lowered, or gets stiffer and softer, by an edit some tens of times
/// a second, each of less than 0.4 N, and together no faster than half of what is let in. The force has to be the exact one that the scene has had
/// within the last kLag ticks.
void editUnder(Renderer& method, Random& random, Wrong& wrong) {
  constexpr int kStreamed = 2500, kSettled = 400;
  constexpr int kLag = 60;
  constexpr double kOff_N = 0.03;
  constexpr double kMostAnEdit_N = 0.4;  // for more than 0.5 N the step lets the contact fade
  enum class Kind { kShape, kPose, kStiffness };
  const auto kind = static_cast<Kind>(random.below(3));
  const double pressed_m = random.between(0.001, 0.003);
  const int every = 10 + random.below(30);
  const double fastest_N_per_s =
      std::min(0.5 * std::pow(30, random.between(0, 1)), kMostAnEdit_N / (every * kPeriod_s));
  const double amplitude_m = random.between(0.2, 0.8) * pressed_m;
  const double rate = fastest_N_per_s / (kSpring_N_per_m * amplitude_m) * kPeriod_s;
  const Vec3 hip(random.between(-0.01, 0.01), random.between(-0.01, 0.01), -pressed_m);
  const shapes::Shape block = shapes::box({0.1, 0.1, 0.04}, 4);
  const shapes::Shape atRest = block.mapped([](Vec3 v) { return v - Vec3(0, 0, 0.02); });
  const auto surface = atRest.build();

  Stage stage(method, random);
  const int body = stage.add(surface);
  stage.begin(hip + Vec3(0, 0, 0.01));
  stage.lead(hip + Vec3(0, 0, 0.01), hip, 1e-4, [](const Felt&, Vec3) {});
  std::deque<double> exact_N{kSpring_N_per_m * pressed_m};
  for (int tick = 1; tick < kStreamed; ++tick) {
    double now_N = exact_N.back();
    if (tick > kSettled && tick % every == 0) {
      const double more_m = amplitude_m * std::sin(rate * (tick - kSettled));
      double spring_N_per_m = kSpring_N_per_m, top_m = 0;
      if (kind == Kind::kShape) {
        const auto moved = atRest.mapped([&](Vec3 v) { return Vec3(v.x, v.y, v.z > -1e-9 ? more_m : v.z); });
        top_m = static_cast<double>(static_cast<float>(more_m));
        stage.replace(body, refitCollisionMesh(*surface, moved.vertices));
      } else if (kind == Kind::kPose) {
        top_m = more_m;
        stage.move(body, {{1, 0, 0, 0}, {0, 0, more_m}});
      } else {
        spring_N_per_m *= 1 + more_m / pressed_m;
      }
      now_N = spring_N_per_m * (top_m + pressed_m);
      stage.edit(hip, spring_N_per_m);
    }
    exact_N.push_back(now_N);
    if (exact_N.size() > kLag) exact_N.pop_front();
    const Felt felt = stage.tick(hip);
    if (tick < kSettled) continue;
    const auto [least_N, most_N] = std::ranges::minmax(exact_N);
    const double off_N =
        std::max({least_N - felt.force_N.z, felt.force_N.z - most_N, std::hypot(felt.force_N.x, felt.force_N.y)});
    wrong.see(off_N, isFinite(felt.force_N) && off_N < kOff_N);
  }
}

/// A plate, or a sheet where it is of no thickness, that is lifted in steps onto a hand at rest, 2 mm farther, and stays there.
void setThrough(Renderer& method, double thickness_m, double step_m, int every, Random& random, Wrong& wrong) {
  constexpr double kLifted_m = 0.002, kOff_N = 0.02;
  constexpr int kLag = 80, kRest = 300;
  const Vec3 hip(random.between(-0.01, 0.01), random.between(-0.01, 0.01), 0);
  const shapes::Shape shape =
      thickness_m == 0 ? shapes::sheet(kWide_m, 3) : shapes::box({kWide_m, kWide_m, thickness_m}, 2);
  const auto poseAt = [&](double top_m) { return Pose{{1, 0, 0, 0}, {0, 0, top_m - thickness_m / 2}}; };
  double top_m = -0.01;
  Stage stage(method, random);
  const int body = stage.add(shape.build(), poseAt(top_m));
  stage.begin(hip);
  std::deque<double> depths_m;
  for (int tick = 0, rested = 0; rested < kRest; ++tick) {
    const bool comes = tick % every == 0;
    if (comes) {
      top_m = std::min(top_m + step_m, kLifted_m);
      stage.move(body, poseAt(top_m));
    }
    rested += top_m == kLifted_m ? 1 : 0;
    const Felt felt = stage.drive(hip, comes);
    depths_m.push_back(std::max(0.0, top_m));
    if (depths_m.size() > kLag) depths_m.pop_front();
    const auto [least, most] = std::ranges::minmax(depths_m);
    const double up_N = felt.force_N.z;
    const double off_N = std::max({kSpring_N_per_m * least - up_N, up_N - kSpring_N_per_m * most,
                                   std::hypot(felt.force_N.x, felt.force_N.y), 0.0});
    wrong.see(off_N, isFinite(felt.force_N) && off_N < kOff_N);
  }
}

/// A hand that goes 50 mm beyond the upper face of a plate of 0.5 mm: the face holds it.
void throwAgainst(Renderer& method, double speed_m_per_s, Random& random, Wrong& wrong) {
  constexpr double kThickness_m = 0.0005, kOff_N = kSpring_N_per_m * 1e-6;
  const Vec3 from(random.between(-0.02, 0.02), random.between(-0.02, 0.02), 0.02);
  Stage stage(method, random);
  stage.add(shapes::box({kWide_m, kWide_m, kThickness_m}, 2), {0, 0, -kThickness_m / 2});
  stage.begin(from);
  stage.lead(from, {from.x, from.y, -0.05}, speed_m_per_s * kPeriod_s, [&](const Felt& felt, Vec3 hip) {
    const double off_N = glm::distance(felt.force_N, Vec3(0, 0, kSpring_N_per_m * std::max(0.0, -hip.z)));
    wrong.see(off_N, isFinite(felt.force_N) && off_N < kOff_N);
  });
}

/// How long the force is that a ball's triangles give: to the nearest of them.
double pressOn(const shapes::Shape& ball, Vec3 hip) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
    const Vec3 on = closestOnTriangle(hip, {ball.corner(t, 0), ball.corner(t, 1), ball.corner(t, 2)});
    nearest_m = std::min(nearest_m, glm::distance(on, hip));
  }
  return kSpring_N_per_m * nearest_m;
}

/// A ball of 20 mm grows by a tenth within a second and shrinks again, by 40 um an edit, under a hand 2 mm deep: the force
/// goes from 2 to 4 N and back, and points away from the ball's middle to within what facets turn it.
void growUnder(Renderer& method, Random& random, Wrong& wrong) {
  constexpr int kEvery = 20, kSettled = 300, kLag = 60, kGrowing = 50, kFacets = 12;
  constexpr double kRadius_m = 0.02, kPressed_m = 0.002, kGrown_m = 4e-5;
  constexpr double kOff_N = 0.03, kAside = 0.15;
  const Vec3 up = random.direction();
  const Vec3 hip = up * (kRadius_m - kPressed_m);
  shapes::Shape ball = shapes::sphere(kRadius_m, kFacets);
  Stage stage(method, random);
  const int body = stage.add(ball);
  stage.begin(up * (kRadius_m + 0.005));
  stage.lead(up * (kRadius_m + 0.005), hip, 1e-4, [](const Felt&, Vec3) {});
  std::deque<double> exact_N{pressOn(ball, hip)};
  for (int tick = 1; tick < kSettled + 2 * kGrowing * kEvery + kSettled; ++tick) {
    double now_N = exact_N.back();
    const int edits = (tick - kSettled) / kEvery;
    if (tick > kSettled && (tick - kSettled) % kEvery == 0 && edits <= 2 * kGrowing) {
      ball = shapes::sphere(kRadius_m + kGrown_m * (kGrowing - std::abs(kGrowing - edits)), kFacets);
      stage.replace(body, ball.build());
      stage.edit(hip);
      now_N = pressOn(ball, hip);
    }
    exact_N.push_back(now_N);
    if (exact_N.size() > kLag) exact_N.pop_front();
    const Felt felt = stage.tick(hip);
    if (tick < kSettled) continue;
    const auto [least_N, most_N] = std::ranges::minmax(exact_N);
    const double felt_N = glm::length(felt.force_N);
    const double aside_N = glm::length(felt.force_N - glm::dot(felt.force_N, up) * up) - kAside * felt_N;
    const double off_N = std::max({least_N - felt_N, felt_N - most_N, aside_N});
    wrong.see(off_N, isFinite(felt.force_N) && off_N < kOff_N);
  }
}

SceneResult resultOf(const Wrong& wrong) {
  return {{{"ticks", wrong.ticks}, {"wrong_ticks", wrong.wrong}, {"force_error_max_N", wrong.worst_N}},
          wrong.wrong == 0};
}

SceneResult run(void (*one)(Renderer&, Random&, Wrong&), Renderer& method, Random& random) {
  constexpr int kRuns = 12;
  Wrong wrong;
  for (int i = 0; i < kRuns; ++i) one(method, random, wrong);
  return resultOf(wrong);
}

}  // namespace

SceneResult drivePastStillHip(Renderer& method, Random& random) { return run(drivePast, method, random); }
SceneResult streamUnderStillHip(Renderer& method, Random& random) { return run(streamUnder, method, random); }
SceneResult editInSmallSteps(Renderer& method, Random& random) { return run(editUnder, method, random); }

SceneResult meetThinWalls(Renderer& method, Random& random) {
  Wrong wrong;
  for (const double thickness_m : {0.0, 1e-4, 5e-4, 0.002, 0.01}) {
    for (const auto& [step_m, every] : {std::pair{3e-4, 16}, {5e-4, 16}, {1e-4, 4}, {3e-5, 1}})
      setThrough(method, thickness_m, step_m, every, random, wrong);
  }
  for (const double speed_m_per_s : {0.5, 2.0, 5.0, 20.0}) throwAgainst(method, speed_m_per_s, random, wrong);
  return resultOf(wrong);
}

SceneResult growUnderTheHand(Renderer& method, Random& random) {
  Wrong wrong;
  for (int i = 0; i < 4; ++i) growUnder(method, random, wrong);
  return resultOf(wrong);
}

}  // namespace haptics::eval
