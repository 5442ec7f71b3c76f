#include <gmock/gmock.h>

#include <deque>
#include <vector>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/moving_together.h"
#include "haptic_server/engine/motion/rigid_motion.h"
#include "tests/haptic_server/engine/motion/bodies.h"

namespace haptics::test::collision_test {
namespace {

/// Bodies that meet one another, in ticks of 1 ms.
class World {
 public:
  std::size_t add(const TriMesh& mesh, double mass_kg, const Pose& pose, double friction = 0.5) {
    Part& part = parts_.emplace_back();
    part.surface = buildCollisionMesh(mesh.vertices, mesh.triangles);
    part.points = makeCollisionPoints(*part.surface);
    part.points.friction = friction;
    part.pose = pose;
    if (mass_kg > 0) {
      part.body = bodyOf(mesh, mass_kg);
      part.state = restingAt(part.body, pose);
    }
    part.moves = mass_kg > 0;
    return parts_.size() - 1;
  }
  RigidBody& body(std::size_t i) { return parts_[i].body; }
  RigidState& state(std::size_t i) { return parts_[i].state; }
  [[nodiscard]] Pose pose(std::size_t i) const {
    return parts_[i].moves ? poseOf(parts_[i].body, parts_[i].state) : parts_[i].pose;
  }
  void put(std::size_t i, const Pose& pose) { parts_[i].pose = pose; }
  void push(std::size_t i, const Push& push) { parts_[i].push = push; }
  void tick() {
    std::vector<Collider> colliders;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      Part& p = parts_[i];
      colliders.push_back({p.surface.get(), &p.points, pose(i), p.moves ? &p.body : nullptr,
                           p.moves ? &p.state : nullptr, p.push, false, isNew_});
    }
    isNew_ = false;
    CollisionAllowance allowance{search_, {motion_, {}}};
    waits_ += moveTogether(colliders, pairs_, kPeriod_s, allowance) ? 0 : 1;
    searched_ = search_.left() - allowance.search.left();
  }
  /// In the next tick all are where an edit has put them.
  void putAll() { isNew_ = true; }
  void allowForSearch(std::int64_t units) { search_ = Allowance(units); }
  void allowForMotion(std::int64_t units) { motion_ = Allowance(units); }
  void run(double seconds) {
    for (int i = 0; i < std::lround(seconds / kPeriod_s); ++i) tick();
  }
  [[nodiscard]] bool allAsleep() const {
    return std::ranges::all_of(parts_,
                               [](const Part& p) { return !p.moves || p.state.condition == BodyCondition::kAsleep; });
  }
  [[nodiscard]] double energy() const {
    double sum = 0;
    for (const Part& p : parts_) sum += p.moves ? energyOf(p.body, p.state) : 0;
    return sum;
  }
  [[nodiscard]] Vec3 momentum() const {
    Vec3 sum(0);
    for (const Part& p : parts_) sum += p.state.momentum_Ns;
    return sum;
  }
  [[nodiscard]] int waits() const { return waits_; }
  [[nodiscard]] std::int64_t searched() const { return searched_; }  ///< In the last tick, units.
  [[nodiscard]] const BodyPairs& pairs() const { return pairs_; }

 private:
  struct Part {
    std::shared_ptr<const CollisionMesh> surface;
    CollisionPoints points;
    Pose pose;
    bool moves = false;
    RigidBody body;
    RigidState state;
    Push push;
  };
  std::deque<Part> parts_;
  BodyPairs pairs_;
  Allowance search_, motion_;
  std::int64_t searched_ = 0;
  int waits_ = 0;
  bool isNew_ = false;
};

[[nodiscard]] Pose at(Vec3 place) { return {{1, 0, 0, 0}, place}; }
const TriMesh kBrick = makeBox({0.06, 0.03, 0.02}, 2).value();
const TriMesh kTable = makeBox({0.5, 0.5, 0.02}, 1).value();

TEST(Collision, BrickComesToRestOnATable) {
  World world;
  world.add(kTable, 0, at({0, 0, -0.01}));
  const std::size_t brick = world.add(kBrick, 0.1, at({0.003, 0, 0.03}));
  world.run(2);
  EXPECT_NEAR(world.pose(brick).position.z, 0.01, 2e-5);
  EXPECT_LT(glm::distance(world.pose(brick).position, Vec3(0.003, 0, 0.01)), 1e-4);
  EXPECT_TRUE(world.allAsleep());
}

TEST(Collision, WeightlessPlateStaysWhereItIsPutOutsideOfOthersHoweverThin) {
  for (const double thick : {0.0005, 0.002, 0.02}) {
    for (const Vec3 beside : {Vec3(0, 0, 0.001), Vec3(0, 0, 0.03), Vec3(0.3, 0, -0.001), Vec3(0, 0.301, 0)}) {
      World world;
      world.add(makeBox({0.5, 0.5, thick}, 1).value(), 0, at({0, 0, -thick / 2}));
      const Vec3 place = beside + Vec3(0, 0, 0.005);
      const std::size_t plate = world.add(makeBox({0.1, 0.1, 0.01}, 1).value(), 0.1, at(place));
      world.body(plate).gravity_m_per_s2 = Vec3(0);
      world.putAll();
      world.run(0.1);
      EXPECT_EQ(world.pose(plate).position, place) << thick << ' ' << beside.z;
    }
  }
}

TEST(Collision, BoardsAndThinPlatesStandOnWhatIsSmallerOrThinner) {
  const TriMesh block = makeBox({0.03, 0.03, 0.03}, 1).value();
  World world;
  world.add(kTable, 0, at({0, 0, -0.01}));
  std::vector<std::pair<std::size_t, double>> all{{world.add(block, 0.1, at({0, 0, 0.015})), 0.015}};
  for (int i = 0; i < 4; ++i) {
    const double z = 0.0315 + 0.003 * i;
    all.emplace_back(world.add(makeBox({0.15, 0.15, 0.003}, 1).value(), 0.05, at({0, 0, z})), z);
  }
  world.putAll();
  world.run(3);
  for (const auto& [body, z] : all) EXPECT_NEAR(world.pose(body).position.z, z, 1e-4);
}

constexpr double kPull_m_per_s2 = 0.5, kSlide_s = 0.6;
constexpr double kWay_m = 0.5 * kPull_m_per_s2 * kSlide_s * kSlide_s;
/// How far a body is pulled aside without friction over a ground whose top is z = 0, m.
double wayOver(World& ground, const TriMesh& body, Vec3 from) {
  const std::size_t added = ground.add(body, 0.05, at(from), 0);
  ground.body(added).gravity_m_per_s2 = {kPull_m_per_s2, 0, -9.81};
  ground.putAll();
  ground.allowForSearch(2'000'000);  // of what is put on many tiles, all in one tick
  ground.run(kSlide_s);
  EXPECT_EQ(ground.waits(), 0);
  EXPECT_NEAR(ground.pose(added).position.y, from.y, 1e-4);
  return ground.pose(added).position.x - from.x;
}
const TriMesh kCube = makeBox(Vec3(0.02), 1).value(), kPuck = makeCylinder(0.01, 0.02, 64).value();

TEST(Collision, SlidesOverFlushTilesAndFineGroundAsOverOne) {
  for (const TriMesh& body : {kCube, kPuck}) {
    World tiles;
    for (int i = -2; i <= 2; ++i) tiles.add(makeBox({0.0303, 0.1, 0.02}, 1).value(), 0, at({0.0303 * i, 0, -0.01}), 0);
    EXPECT_NEAR(wayOver(tiles, body, {-0.06, 0.003, 0.01}), kWay_m, 3e-4);
    World fine;
    fine.add(makeBox({0.2, 0.1, 0.02}, 40).value(), 0, at({0, 0, -0.01}), 0);
    EXPECT_NEAR(wayOver(fine, body, {-0.06, 0.003, 0.01}), kWay_m, 3e-4);
  }
}

TEST(Collision, IsNotHeldByTheTilesBesideOneOfItsOwnSize) {
  for (const TriMesh& body : {kCube, kPuck}) {
    for (const double before_m : {0.0, 1e-5, 2e-5, 1e-4}) {
      World tiles;
      for (int i = -1; i <= 5; ++i) {
        for (int j = -1; j <= 1; ++j) tiles.add(kCube, 0, at({0.02 * i, 0.02 * j, -0.01}), 0);
      }
      EXPECT_NEAR(wayOver(tiles, body, {-before_m, 0, 0.01}), kWay_m, 3e-4) << before_m;
    }
  }
}

/// A closed box whose top is in strips, each divided otherwise, so that vertices lie on others' edges.
TriMesh boxWithJunctions(const std::vector<int>& parts) {
  TriMesh mesh = makeBox({0.2, 0.1, 0.02}, 1).value();
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return std::ranges::all_of(t, [&](std::uint32_t v) { return mesh.vertices[v].z > 0; });
  });
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto xOf = [&](std::size_t k) {
      return static_cast<float>(0.2 * static_cast<double>(k) / static_cast<double>(parts.size()) - 0.1);
    };
    for (int j = 0; j < parts[i]; ++j) {
      const auto yOf = [&](int k) { return static_cast<float>(0.1 * k / parts[i] - 0.05); };
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const auto& [x, y] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}})
        mesh.vertices.emplace_back(xOf(x), yOf(y), 0.01F);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  return mesh;
}

TEST(Collision, SlidesOverVerticesThatLieOnEdges) {
  for (const TriMesh& body : {kCube, kPuck}) {
    for (const std::vector<int>& parts : {std::vector{1, 2, 3, 2, 1}, {1, 2}, {3, 4, 3, 4, 5, 6}}) {
      World world;
      world.add(boxWithJunctions(parts), 0, at({0, 0, -0.01}), 0);
      EXPECT_NEAR(wayOver(world, body, {-0.06, 0.003, 0.01}), kWay_m, 3e-4)
          << parts.size() << " strips, " << body.vertices.size() << " vertices";
    }
  }
}

/// An L, upright prism within +-side_m / 2.
TriMesh angle(float side_m, float height_m) {
  const std::array<glm::vec2, 6> outline{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
  TriMesh mesh;
  for (const float z : {-height_m / 2, height_m / 2}) {
    for (const glm::vec2 at : outline) mesh.vertices.emplace_back(side_m / 2 * (at - 1.0F), z);
  }
  for (std::uint32_t i = 1; i + 1 < 6; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({6, 6 + i, 7 + i});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t next = (i + 1) % 6;
    mesh.triangles.push_back({i, next, next + 6});
    mesh.triangles.push_back({i, next + 6, i + 6});
  }
  return mesh;
}

TEST(Collision, WhatIsNotConvexSlidesOverFlushTilesOfAnyThickness) {
  for (const double width_m : {0.03, 0.05, 0.06, 0.1}) {
    World tiles;
    for (int i = -3; i <= 3; ++i) {
      for (int j = -1; j <= 1; ++j) {
        const double thick_m = (i + j) % 2 == 0 ? 0.02 : 0.01;
        tiles.add(makeBox({width_m, width_m, thick_m}, 1).value(), 0, at({width_m * i, width_m * j, -thick_m / 2}), 0);
      }
    }
    EXPECT_NEAR(wayOver(tiles, angle(0.05F, 0.012F), {-0.06, 0, 0.006}), kWay_m, 1.5e-3) << width_m;
  }
}

TEST(Collision, FiveBricksStandOnOneAnother) {
  World world;
  world.add(kTable, 0, at({0, 0, -0.01}));
  std::vector<std::size_t> bricks;
  for (int i = 0; i < 5; ++i) bricks.push_back(world.add(kBrick, 0.1, at({0.001 * (i % 2), 0, 0.01 + 0.02 * i})));
  world.run(5);
  for (int i = 0; i < 5; ++i) {
    const Vec3 place = world.pose(bricks[static_cast<std::size_t>(i)]).position;
    EXPECT_NEAR(place.z, 0.01 + 0.02 * i, 1e-4);
    EXPECT_NEAR(place.x, 0.001 * (i % 2), 1e-4);
  }
  EXPECT_TRUE(world.allAsleep());
}

TEST(Collision, SlidesDownAPlankThatIsSteeperThanItsFriction) {
  for (const double friction : {0.3, 0.7}) {
    World world;
    const double angle = 0.5;  // tan: 0.546
    const Quat tilt = rotationBy({0, angle, 0});
    world.add(makeBox({1, 0.5, 0.02}, 1).value(), 0, {tilt, tilt * Vec3(0, 0, -0.01)}, friction);
    const std::size_t brick = world.add(kBrick, 0.1, {tilt, tilt * Vec3(-0.2, 0, 0.01)}, friction);
    world.run(0.5);
    const double way = glm::distance(world.pose(brick).position, tilt * Vec3(-0.2, 0, 0.01));
    const double slides = 9.81 * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(way, slides > 0 ? 0.5 * slides * 0.25 : 0, 1e-3) << friction;
  }
}

TEST(Collision, MarblesPassTheirMomentumOn) {
  World world;
  const TriMesh marble = makeSphere(0.01, 16).value();
  const std::size_t a = world.add(marble, 0.02, at({0, 0, 0})), b = world.add(marble, 0.02, at({0.03, 0.004, 0}));
  world.body(a).gravity_m_per_s2 = world.body(b).gravity_m_per_s2 = Vec3(0);
  world.state(a).momentum_Ns = {0.01, 0, 0};
  const double before = world.energy();
  world.run(0.3);
  EXPECT_LT(glm::distance(world.momentum(), Vec3(0.01, 0, 0)), 1e-12);
  EXPECT_GT(world.state(b).momentum_Ns.x, 0.004);
  EXPECT_LE(world.energy(), before);
}

/// Two bricks whose faces are 20 mm apart, without weight.
struct TwoApart {
  World world;
  std::size_t a, b;
  explicit TwoApart(const TriMesh& mesh = kBrick)
      : a(world.add(mesh, 0.1, at({0, 0, 0}))), b(world.add(kBrick, 0.1, at({0, 0, 0.04}))) {
    for (const std::size_t i : {a, b}) world.body(i).gravity_m_per_s2 = Vec3(0);
  }
  [[nodiscard]] const BodyPair& pair() const { return world.pairs().places[0]; }
};

TEST(Collision, APairThatIsApartIsLookedAtAgainOnlyWhereItMayHaveMet) {
  TwoApart two;
  two.world.state(two.a).momentum_Ns = {0, 0, 0.1 * 0.1};
  two.world.tick();
  const Pose looked = two.pair().relative;
  EXPECT_GT(two.pair().range_m, 0.01);
  EXPECT_LT(two.pair().range_m, 0.0201);
  two.world.run(0.09);
  EXPECT_EQ(two.pair().relative, looked);
  two.world.run(0.3);
  EXPECT_GT(two.world.state(two.b).momentum_Ns.z, 0.004);
  EXPECT_LT(glm::distance(two.world.momentum(), Vec3(0, 0, 0.1 * 0.1)), 1e-12);
}

TEST(Collision, ABarThatTurnsIntoWhatWasApartMeetsIt) {
  TwoApart two(makeBox({0.08, 0.01, 0.004}, 2).value());
  two.world.state(two.a).angularMomentum_Nms = {0, 2e-4, 0};
  two.world.tick();
  EXPECT_GT(two.pair().range_m, 0.01);
  two.world.run(0.3);
  EXPECT_GT(glm::length(two.world.state(two.b).momentum_Ns), 1e-3);
}

TEST(Collision, ASleepingBodyIsNoWallForWhatHitsIt) {
  for (const double speed_m_per_s : {0.003, 0.05, 0.2, 1.0}) {
    World world;
    const std::size_t a = world.add(kBrick, 0.1, at({0, 0, 0})), b = world.add(kBrick, 0.1, at({0.063, 0.004, 0}));
    for (const std::size_t i : {a, b}) world.body(i).gravity_m_per_s2 = Vec3(0);
    world.run(1);
    ASSERT_TRUE(world.allAsleep());
    world.state(a).condition = BodyCondition::kAwake;
    world.state(a).still_s = 0;
    world.state(a).momentum_Ns = {0.1 * speed_m_per_s, 0, 0};
    world.run(0.006 / speed_m_per_s);
    EXPECT_LT(glm::distance(world.momentum(), Vec3(0.1 * speed_m_per_s, 0, 0)), 1e-12) << speed_m_per_s;
    EXPECT_GT(world.state(b).momentum_Ns.x, 0.04 * speed_m_per_s);
  }
}

TEST(Collision, OverlapGoesSlowly) {
  World world;
  const std::size_t a = world.add(kBrick, 0.1, at({0, 0, 0})), b = world.add(kBrick, 0.1, at({0.001, 0, 0.012}));
  for (const std::size_t i : {a, b}) world.body(i).gravity_m_per_s2 = Vec3(0);
  for (int i = 0; i < 500; ++i) {
    world.tick();
    EXPECT_LT(glm::length(world.state(a).momentum_Ns) / 0.1, 0.11);
  }
  EXPECT_GT(world.pose(b).position.z - world.pose(a).position.z, 0.02 - 1e-5);
  EXPECT_LT(glm::length(world.momentum()), 1e-12);
}

TEST(Collision, MoveInTheNextTickWhereManyContactsWereFoundByALongSearch) {
  World world;
  world.add(kTable, 0, at({0, 0, -0.01}));
  for (int i = 0; i < 12; ++i) {
    const std::size_t brick = world.add(kBrick, 0.1, at({0.1 * (i % 4), 0.1 * (i / 4), 0.01}), 0.1);
    world.state(brick).momentum_Ns = {0.03, 0.02, 0};
  }
  constexpr std::int64_t kUnits = 20'000;
  world.allowForSearch(kUnits);
  world.allowForMotion(0);
  int moved = 0, leftToTheNext = 0;
  for (int tick = 0; tick < 1000; ++tick) {
    const bool isLeft = world.pairs().isFound;
    const Pose before = world.pose(1);
    world.tick();
    const bool moves = !(world.pose(1) == before);
    if (isLeft) {
      EXPECT_TRUE(moves);
    }
    if (moves) {
      EXPECT_LE(world.searched(), kUnits / 2);
    }
    moved += moves ? 1 : 0;
    leftToTheNext += isLeft ? 1 : 0;
  }
  EXPECT_GT(moved, 100);
  EXPECT_GT(leftToTheNext, 10);
}

}  // namespace
}  // namespace haptics::test::collision_test
