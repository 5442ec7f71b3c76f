// Bodies that meet one another: S26, S27, S28, S30, S40. Beside ours springs between them.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/eval/scenes/put_bodies.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

using namespace put_bodies;

const Vec3 kBrick_m{0.06, 0.03, 0.02};

/// Open upwards, its foot at z = 0: part of a sphere of 80 mm, 5 mm thick.
constexpr double kInner_m = 0.08, kWall_m = 0.005, kHalfAngle_rad = 0.95;
TriMesh bowlMesh() {
  constexpr int kTurns = 48, kSteps = 14;
  std::vector<std::array<double, 2>> line;  // distance from the axis, height; from inside over the rim to outside
  for (int i = 0; i <= kSteps; ++i) {
    const double a = kHalfAngle_rad * i / kSteps;
    line.push_back({kInner_m * std::sin(a), -kInner_m * std::cos(a)});
  }
  for (int i = kSteps; i >= 0; --i) {
    const double a = kHalfAngle_rad * i / kSteps;
    line.push_back({(kInner_m + kWall_m) * std::sin(a), -(kInner_m + kWall_m) * std::cos(a)});
  }
  TriMesh mesh;
  const auto add = [&](double x, double y, double z) {
    mesh.vertices.emplace_back(Vec3(x, y, z + kInner_m + kWall_m));
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  const std::uint32_t top = add(0, 0, line.front()[1]), bottom = add(0, 0, line.back()[1]);
  const std::size_t rings = line.size() - 2;
  for (std::size_t r = 0; r < rings; ++r) {
    for (int i = 0; i < kTurns; ++i) {
      const double a = 2 * std::numbers::pi * i / kTurns;
      add(line[r + 1][0] * std::cos(a), line[r + 1][0] * std::sin(a), line[r + 1][1]);
    }
  }
  const auto corner = [](std::size_t ring, int i) {
    return static_cast<std::uint32_t>(2 + ring * kTurns + i % kTurns);
  };
  for (int i = 0; i < kTurns; ++i) {
    mesh.triangles.push_back({top, corner(0, i), corner(0, i + 1)});
    for (std::size_t r = 0; r + 1 < rings; ++r) {
      mesh.triangles.push_back({corner(r, i), corner(r + 1, i), corner(r + 1, i + 1)});
      mesh.triangles.push_back({corner(r, i), corner(r + 1, i + 1), corner(r, i + 1)});
    }
    mesh.triangles.push_back({bottom, corner(rings - 1, i + 1), corner(rings - 1, i)});
  }
  return mesh;
}

}  // namespace

/// Five bricks on one another stand for 60 s, fall asleep, and are poked.
SceneResult standOnOneAnother(Renderer& method, Random& random) {
  constexpr int kTicks = 60'000, kPoke = 1'500;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  addTable(*world);
  std::vector<std::uint64_t> bricks;
  std::vector<Vec3> begun;
  for (int i = 0; i < 5; ++i) {
    const Quat turned = glm::angleAxis(random.between(-0.2, 0.2), Vec3(0, 0, 1));
    begun.emplace_back(random.between(-0.002, 0.002), random.between(-0.002, 0.002), 0.01 + 0.02 * i);
    bricks.push_back(add(*world, boxMesh(kBrick_m), random.between(0.05, 0.2), {turned, begun.back()}, kGravity));
  }
  world->publish();
  for (int i = 0; i < kTicks; ++i) world->tick(kFarAway);
  double moved_m = 0;
  int awake = 0, notFinite = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    moved_m = std::max(moved_m, glm::distance(world->poseOf(bricks[i]).position, begun[i]));
    awake += world->stateOf(bricks[i]).condition == BodyCondition::kAsleep ? 0 : 1;
  }
  double given_N = 0;
  for (int i = 0; i < kPoke; ++i) {
    const TelemetrySample sample = world->tick({-0.05 + 4e-5 * i, 0, 0.09});
    given_N = std::max(given_N, glm::length(sample.force.contact));
    notFinite += isFinite(sample.force.contact) ? 0 : 1;
  }
  const double pushed_m = glm::distance(world->poseOf(bricks[4]).position, begun[4]);
  SceneResult result;
  result.measures = {{"moved_in_60_s_mm", 1e3 * moved_m},
                     {"awake_after_60_s", awake},
                     {"poked_N", given_N},
                     {"top_pushed_mm", 1e3 * pushed_m},
                     {"non_finite_ticks", notFinite}};
  result.pass = moved_m < 2e-4 && awake == 0 && pushed_m > 0.005 && notFinite == 0;
  return result;
}

/// A brick between the hand and a wall: it goes no farther, and the hand feels its own spring.
SceneResult squeezeAgainstWall(Renderer& method, Random& random) {
  constexpr int kTicks = 4'000, kSettled = 2'500;
  const double depth_m = random.between(0.002, 0.01), gap_m = random.between(0, 0.01);
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  add(*world, boxMesh({0.02, 0.2, 0.2}), 0, at({0.04 + gap_m, 0, 0}), Vec3(0));
  const std::uint64_t brick = add(*world, boxMesh(kBrick_m), 0.1, at(Vec3(0)), Vec3(0));
  world->publish();
  const Vec3 aside(0, random.between(-0.01, 0.01), random.between(-0.006, 0.006));
  double entered_m = -1, change_N = 0, error_N = 0;
  Vec3 before_N(0);
  for (int i = 0; i < kTicks; ++i) {
    const double x = std::min(-0.035 + 2e-5 * i, -0.03 + gap_m + depth_m);
    const TelemetrySample sample = world->tick(Vec3(x, 0, 0) + aside);
    entered_m = std::max(entered_m, world->poseOf(brick).position.x - gap_m);
    if (i >= kSettled) {
      change_N = std::max(change_N, glm::distance(sample.force.contact, before_N));
      error_N = std::max(error_N, std::abs(-sample.force.contact.x - kSpring_N_per_m * depth_m));
    }
    before_N = sample.force.contact;
  }
  SceneResult result;
  result.measures = {{"entered_wall_um", 1e6 * entered_m}, {"change_of_force_N", change_N}, {"force_error_N", error_N}};
  result.pass = entered_m < 1e-4 && change_N < 0.01 && error_N < 0.05;
  return result;
}

/// Bricks that float, pushed one into the next: what the hand gives, but in ticks in which bodies wait, they have together.
SceneResult passMomentumOn(Renderer& method, Random& random) {
  constexpr int kTicks = 1'500;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  std::vector<std::uint64_t> bricks;
  for (int i = 0; i < 4; ++i) {
    const Pose pose{glm::angleAxis(random.between(-0.3, 0.3), Vec3(0, 0, 1)),
                    {0.075 * i, random.between(-0.01, 0.01), 0}};
    bricks.push_back(add(*world, boxMesh(kBrick_m), random.between(0.05, 0.3), pose, Vec3(0)));
  }
  world->publish();
  Vec3 given(0);
  const double y = random.between(-0.005, 0.005);
  for (int i = 0; i < kTicks; ++i) {
    const std::uint64_t waited = world->waitedTicks();
    const TelemetrySample sample = world->tick({-0.05 + 1.2e-4 * i, y, 0});
    if (world->waitedTicks() == waited) given -= kPeriod_s * sample.force.contact;
  }
  Vec3 momentum(0);
  int moving = 0;
  for (const std::uint64_t brick : bricks) {
    momentum += world->stateOf(brick).momentum_Ns;
    moving += glm::length(world->stateOf(brick).momentum_Ns) > 1e-4 ? 1 : 0;
  }
  const double error = glm::distance(momentum, given) / glm::length(given);
  SceneResult result;
  result.measures = {{"given_Ns", glm::length(given)},
                     {"momentum_error", error},
                     {"bricks_that_move", moving},
                     {"ticks_that_waited", world->waitedTicks()}};
  result.pass = error < 1e-3 && moving >= 2;
  return result;
}

/// 32 marbles and blocks are let into a bowl.
SceneResult fillBowl(Renderer& method, Random& random) {
  constexpr int kTicks = 12'000;
  constexpr double kRadius_m = 0.008;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  add(*world, bowlMesh(), 0, at(Vec3(0)), Vec3(0));
  std::vector<std::uint64_t> bodies;
  for (int i = 0; i < 32; ++i) {
    const bool round = random.below(2) == 0;
    const TriMesh mesh = round ? makeSphere(kRadius_m, 16).value() : boxMesh(Vec3(0.011, 0.009, 0.008));
    const Vec3 place(0.02 * (i % 3 - 1) + random.between(-1e-3, 1e-3), 0.02 * (i / 3 % 3 - 1), 0.06 + 0.02 * (i / 9));
    bodies.push_back(add(*world, mesh, 0.01, {random.rotation(), place}, kGravity));
  }
  world->publish();
  world->tick(kFarAway);
  const auto energy = [&] {
    double sum = 0;
    for (const std::uint64_t body : bodies) sum += world->energyOf(body);
    return sum;
  };
  const double begun_J = energy();
  double gained_J = 0, deepest_m = 0;
  int notFinite = 0, through = 0;
  for (int i = 0; i < kTicks; ++i) {
    world->tick(kFarAway);
    if (i % 50 != 0) continue;
    gained_J = std::max(gained_J, energy() - begun_J);
    for (const std::uint64_t body : bodies) {
      const Vec3 place = world->poseOf(body).position;
      notFinite += isFinite(place) ? 0 : 1;
      const Vec3 fromMiddle = place - Vec3(0, 0, kInner_m + kWall_m);
      const bool over = std::atan2(std::hypot(fromMiddle.x, fromMiddle.y), -fromMiddle.z) < kHalfAngle_rad;
      const double beyond_m = glm::length(fromMiddle) + 0.004 - kInner_m;  // the thinnest body's half width
      if (!over) continue;
      deepest_m = std::max(deepest_m, beyond_m);
      through += beyond_m > 0.002 && glm::length(fromMiddle) < kInner_m + 0.02 ? 1 : 0;
    }
  }
  int awake = 0;
  for (const std::uint64_t body : bodies) awake += world->stateOf(body).condition == BodyCondition::kAwake ? 1 : 0;
  SceneResult result;
  result.measures = {{"energy_gained_uJ", 1e6 * gained_J},
                     {"deepest_um", 1e6 * deepest_m},
                     {"through_the_bowl", through},
                     {"awake_at_the_end", awake},
                     {"ticks_that_waited", world->waitedTicks()},
                     {"non_finite_ticks", notFinite}};
  result.pass = gained_J < 1e-6 && through == 0 && deepest_m < 5e-4 && notFinite == 0;
  return result;
}

namespace {

struct Put {
  double hovering_m = 0;  ///< By how much what is weightless and touches nothing has moved, at most.
  double beyond_m = 0;    ///< By how much bodies that overlapped went farther than to touch.
  double overlap_m = 0;   ///< That is left of their overlap.
  double fastest_m_per_s = 0;
  double left_m_per_s = 0;  ///< Of their speed, in the end.
  double sunk_m = 0;        ///< By how much a stack is lower than its parts are high, or a part has slipped aside.
  int notFinite = 0;
};

Vec3 someSize(Random& random, double low_m, double high_m) {
  return {random.between(low_m, high_m), random.between(low_m, high_m), random.between(low_m, high_m)};
}

/// No polytope: it meets others by its points.
TriMesh dented(Vec3 size_m) {
  TriMesh mesh = makeBox(size_m, 2).value();
  for (Vec3f& v : mesh.vertices) {
    if (v.x == 0 && v.y == 0 && v.z > 0) v.z *= 0.5F;
  }
  return mesh;
}

/// 1 to 50 mm above or beside something, however thin that is.
void hover(const Renderer& method, Random& random, Put& put) {
  constexpr int kTicks = 400;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  const Vec3 under_m(random.between(0.1, 0.5), random.between(0.1, 0.5), random.between(0.003, 0.05));
  const Vec3 board_m(random.between(0.03, 0.2), random.between(0.03, 0.2), random.between(0.004, 0.02));
  const double gap_m = 0.001 * std::pow(50, random.between(0, 1));
  const Quat all = random.rotation();
  const Vec3 place(random.between(-0.02, 0.02), random.between(-0.02, 0.02), under_m.z / 2 + gap_m + board_m.z / 2);
  const Vec3 beside(under_m.x / 2 + gap_m + board_m.x / 2, random.between(-0.02, 0.02), random.between(-0.02, 0.02));
  const Vec3 begun = all * (random.below(3) == 0 ? beside : place);
  add(*world, boxMesh(under_m), random.below(2) * 0.2, {all, Vec3(0)}, Vec3(0));
  const std::uint64_t board = add(*world, boxMesh(board_m), random.between(0.05, 0.5), {all, begun}, Vec3(0));
  world->publish();
  for (int i = 0; i < kTicks; ++i) world->tick(kFarAway);
  put.hovering_m = std::max(put.hovering_m, glm::distance(world->poseOf(board).position, begun));
}

/// A brick, with or without a dent in its top, 0.2 to 3 mm deep in something that is wider, which stands still or floats.
void overlap(const Renderer& method, Random& random, Put& put) {
  constexpr int kTicks = 300;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  const Vec3 brick_m = someSize(random, 0.02, 0.04);
  const Vec3 under_m(brick_m.x * random.between(1.2, 4), brick_m.y * random.between(1.2, 4),
                     random.between(0.02, 0.05));
  const double depth_m = random.between(0.0002, 0.003);
  const Quat all = random.rotation();
  const bool floats = random.below(2) == 0;
  const std::uint64_t under =
      add(*world, boxMesh(under_m), floats ? random.between(0.05, 0.5) : 0, {all, Vec3(0)}, Vec3(0));
  const Vec3 begun = all * Vec3(0, 0, (under_m.z + brick_m.z) / 2 - depth_m);
  const TriMesh mesh = random.below(2) == 0 ? dented(brick_m) : boxMesh(brick_m);
  const std::uint64_t brick = add(*world, mesh, random.between(0.05, 0.5), {all, begun}, Vec3(0));
  world->publish();
  Vec3 before = begun;
  double speed_m_per_s = 0;
  for (int i = 0; i < kTicks; ++i) {
    world->tick(kFarAway);
    const Vec3 apart = world->poseOf(brick).position - world->poseOf(under).position;
    put.notFinite += isFinite(apart) ? 0 : 1;
    speed_m_per_s = glm::distance(apart, before) / kPeriod_s;
    put.fastest_m_per_s = std::max(put.fastest_m_per_s, speed_m_per_s);
    before = apart;
  }
  const Vec3 moved = glm::conjugate(all) * (before - begun);
  put.beyond_m = std::max({put.beyond_m, moved.z - depth_m, std::hypot(moved.x, moved.y)});
  put.overlap_m = std::max(put.overlap_m, depth_m - moved.z);
  put.left_m_per_s = std::max(put.left_m_per_s, speed_m_per_s);
}

/// A board on a block on a table, wider than the block or not, begun in touch or just above.
void stack(const Renderer& method, Random& random, Put& put) {
  constexpr int kTicks = 1'500;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  addTable(*world);
  const Vec3 block_m(random.between(0.02, 0.06), random.between(0.02, 0.06), random.between(0.015, 0.04));
  const Vec3 board_m(random.between(0.03, 0.2), random.between(0.03, 0.2), random.between(0.005, 0.02));
  const double gap_m = random.below(2) * random.between(0, 0.002);
  const Vec3 blockAt(0, 0, block_m.z / 2), boardAt(0, 0, block_m.z + gap_m + board_m.z / 2);
  const std::uint64_t block = add(*world, boxMesh(block_m), random.between(0.05, 0.3), at(blockAt), kGravity);
  const std::uint64_t board = add(*world, boxMesh(board_m), random.between(0.05, 0.3), at(boardAt), kGravity);
  world->publish();
  for (int i = 0; i < kTicks; ++i) world->tick(kFarAway);
  const Vec3 rests = world->poseOf(board).position;
  put.notFinite += isFinite(rests) ? 0 : 1;
  put.sunk_m = std::max({put.sunk_m, glm::distance(world->poseOf(block).position, blockAt),
                         glm::distance(rests, boardAt - Vec3(0, 0, gap_m))});
}

}  // namespace

/// Bodies are put beside, into and upon one another, as edits put them. What overlaps comes apart at no more than the speed
/// that the solver allows, until it touches, and no farther; what touches nothing stays; a stack stands.
SceneResult putBodies(Renderer& method, Random& random) {
  constexpr int kRuns = 8;
  constexpr double kApart_m_per_s = 0.1;
  Put put;
  for (int i = 0; i < kRuns; ++i) {
    hover(method, random, put);
    overlap(method, random, put);
    stack(method, random, put);
  }
  SceneResult result;
  result.measures = {{"hovering_moved_um", 1e6 * put.hovering_m},
                     {"beyond_touch_um", 1e6 * put.beyond_m},
                     {"overlap_left_um", 1e6 * put.overlap_m},
                     {"apart_max_m_per_s", put.fastest_m_per_s},
                     {"speed_left_mm_per_s", 1e3 * put.left_m_per_s},
                     {"stack_moved_um", 1e6 * put.sunk_m},
                     {"non_finite_ticks", put.notFinite}};
  result.pass = put.hovering_m < 1e-9 && put.beyond_m < 5e-5 && put.overlap_m < 5e-5 && put.left_m_per_s < 1e-4 &&
                put.fastest_m_per_s < 1.1 * kApart_m_per_s && put.sunk_m < 2e-4 && put.notFinite == 0;
  return result;
}

}  // namespace haptics::eval
