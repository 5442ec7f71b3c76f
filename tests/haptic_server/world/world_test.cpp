#include "haptic_server/world/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/servo/allocation_tripwire.h"

namespace haptics::world_test {
namespace {

using ::testing::HasSubstr;

constexpr double kRadius_m = 0.05;

struct Sphere {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  explicit Sphere(double radius_m = kRadius_m) {
    const TriMesh mesh = makeSphere(radius_m, 16).value();
    for (const Vec3f& v : mesh.vertices) vertices.push_back({v.x, v.y, v.z});
    triangles = mesh.triangles;
  }
  [[nodiscard]] World::Mesh mesh() const { return {vertices, triangles}; }
};

template <class Call>
std::string refusalOf(Call call) {
  try {
    call();
  } catch (const InvalidInput& refusal) {
    return refusal.what();
  }
  return "";
}

/// From above down to `depth_m` below the top of the sphere at 0.1 m/s, then at rest: the last sample.
World::Sample press(World& world, double depth_m, int ticks = 600) {
  World::Sample sample;
  for (int i = 0; i < ticks; ++i) {
    sample = world.step({0, 0, std::max(kRadius_m - depth_m, kRadius_m + 0.01 - 1e-4 * i)});
  }
  return sample;
}

TEST(World, PushesOutOfASphereByStiffnessTimesDepth) {
  World world;
  const auto body = world.add("ball", Sphere().mesh(), {.stiffness_N_per_m = 500});
  const World::Sample sample = press(world, 0.004);
  EXPECT_EQ(sample.body, body);
  EXPECT_NEAR(sample.penetration_m, 0.004, 1e-4);
  EXPECT_NEAR(std::hypot(sample.force_N[0], sample.force_N[1], sample.force_N[2]), 500 * sample.penetration_m, 1e-6);
  EXPECT_NEAR(sample.normal[2], 1, 0.02);
  EXPECT_EQ(sample.fault, World::Fault::kNone);
}

TEST(World, IsEmptyAtFirstAndFree) {
  World world;
  const World::Sample sample = world.step({0.1, 0.2, 0.3});
  EXPECT_EQ(sample.body, 0U);
  EXPECT_EQ(sample.force_N, (World::Vector{}));
  EXPECT_EQ(sample.ihip_m, (World::Vector{0.1, 0.2, 0.3}));
}

TEST(World, TakesAwayTheForceForAHipThatIsNotFiniteAndGivesItBack) {
  World world;
  world.add("ball", Sphere().mesh());
  double before = press(world, 0.002).force_N[2];
  ASSERT_GT(before, 1);
  World::Sample sample;
  for (int i = 0; i < 100; ++i) {
    sample = world.step({0, std::numeric_limits<double>::quiet_NaN(), 0});
    EXPECT_EQ(sample.fault, World::Fault::kNonFiniteHip);
    EXPECT_LE(std::abs(sample.force_N[2] - before), 0.25);
    before = sample.force_N[2];
  }
  EXPECT_EQ(sample.force_N, (World::Vector{}));
  EXPECT_STREQ(faultInWords(sample.fault), "the device's position is not finite, or more than 10 km away");
  EXPECT_EQ(world.step({0, 0, 0.06}).fault, World::Fault::kNone);
  EXPECT_GT(press(world, 0.002, 1000).force_N[2], 1);
}

TEST(World, TakesAwayTheForceAfterManyMissedTicks) {
  World world;
  world.add("ball", Sphere().mesh());
  press(world, 0.002);
  EXPECT_EQ(world.step({0, 0, kRadius_m - 0.002}, 500).fault, World::Fault::kMissedTicks);
}

TEST(World, FeelsEditsWithoutAStepOfTheForce) {
  World world;
  const auto body = world.add("ball", Sphere().mesh());
  const World::Vector hip{0, 0, kRadius_m - 0.002};
  World::Vector before = press(world, 0.002).force_N;
  double largest = 0;
  const auto hold = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const World::Vector now = world.step(hip).force_N;
      largest = std::max(largest, std::hypot(now[0] - before[0], now[1] - before[1], now[2] - before[2]));
      before = now;
    }
  };
  world.setMaterial(body, {.stiffness_N_per_m = 300});
  hold(300);
  EXPECT_NEAR(before[2], 0.6, 0.05);
  world.setPose(body, {.position_m = {0, 0, 0.001}});
  hold(300);
  EXPECT_NEAR(before[2], 0.9, 0.05);
  world.remove(body);
  hold(1000);
  EXPECT_EQ(before, (World::Vector{}));
  EXPECT_LT(largest, 0.05);
}

/// A box of 40 x 20 x 10 mm as a tool, 40 mm above a slab whose top is z = 0.
struct ToolOverSlab {
  TriMesh slab = makeBox({0.4, 0.4, 0.1}, 4).value(), box = makeBox({0.04, 0.02, 0.01}, 2).value();
  World world{World::Device{.maxForce_N = 20}};
  std::uint64_t ground = 0;
  std::size_t points = 0;

  static World::Mesh meshOf(const TriMesh& mesh, std::vector<std::array<float, 3>>& vertices) {
    for (const Vec3f& v : mesh.vertices) vertices.push_back({v.x, v.y, v.z});
    return {vertices, mesh.triangles};
  }
  ToolOverSlab() {
    std::vector<std::array<float, 3>> ofSlab, ofBox;
    ground = world.add("ground", meshOf(slab, ofSlab), {}, {.position_m = {0, 0, -0.05}});
    points = world.hold(meshOf(box, ofBox), {.spacing_m = 0.005, .stiffness_N_per_m = 1000, .torsion_Nm_per_rad = 2});
  }
  /// Down to z at 0.1 m/s, then at rest.
  World::ToolSample press(double z, int ticks = 1500) {
    World::ToolSample sample;
    for (int i = 0; i < ticks; ++i) sample = world.stepTool({.position_m = {0, 0, std::max(z, 0.04 - 1e-4 * i)}});
    return sample;
  }
};

TEST(World, ToolRestsOnItsFace) {
  ToolOverSlab scene;
  EXPECT_GT(scene.points, 40U);
  const World::ToolSample sample = scene.press(0.003);
  EXPECT_NEAR(sample.force_N[2], 2, 0.002);
  EXPECT_NEAR(sample.proxy.position_m[2], 0.005, 1e-6);
  EXPECT_GE(sample.touching, 4U);
  EXPECT_FALSE(sample.waits);
}

TEST(World, ToolFeelsEditsWithoutAStep) {
  ToolOverSlab scene;
  double before = scene.press(0.003).force_N[2], largest = 0;
  const auto hold = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const double now = scene.world.stepTool({.position_m = {0, 0, 0.003}}).force_N[2];
      largest = std::max(largest, std::abs(now - before));
      before = now;
    }
    return before;
  };
  scene.world.setPose(scene.ground, {.position_m = {0, 0, -0.049}});
  EXPECT_NEAR(hold(300), 3, 0.003);
  scene.world.remove(scene.ground);
  EXPECT_NEAR(hold(1000), 0, 1e-9);
  EXPECT_LT(largest, 0.05);
}

TEST(World, AMotionPushesAToolWhateverElseIsEditedBeforeItsStep) {
  ToolOverSlab scene;
  const auto far = scene.world.add("far", Sphere().mesh(), {}, {.position_m = {0.5, 0.5, 0.5}});
  const auto hold = [&] { return scene.world.stepTool({.position_m = {0, 0, 0.04}}); };
  for (int i = 0; i < 600; ++i) static_cast<void>(hold());
  for (int i = 1; i <= 60; ++i) {  // its top comes from z = 0 to 6 mm beyond the underside of the box
    scene.world.moveKinematic(scene.ground, {.position_m = {0, 0, -0.05 + 0.041 * i / 60}});
    scene.world.setMaterial(far, {.stiffness_N_per_m = 500.0 + i});
    if (i < 60) static_cast<void>(hold());
  }
  const World::ToolSample sample = hold();
  EXPECT_NEAR(sample.proxy.position_m[2], 0.041 + 0.005, 1e-5);
  EXPECT_NEAR(sample.force_N[2], 1000 * 0.006, 0.01);
}

/// Tiles whose turn is in their vertices, which float rounds: neighbours are a few nanometres higher or lower.
TEST(World, ToolSlidesOverFlushTilesThatFloatRounds) {
  const Quat turned = glm::normalize(Quat(0.4, -0.3, 0.8, 0.2));
  const auto turn = [&](Vec3 v) { return turned * v; };
  World world(World::Device{.maxForce_N = 1000});
  const TriMesh tile = makeBox({0.03, 0.03, 0.02}, 1).value();
  for (int i = 0; i < 10; ++i) {
    std::vector<std::array<float, 3>> vertices;
    for (const Vec3f& v : tile.vertices) {
      const Vec3f at(turn(Vec3(v) + Vec3(0.03 * (i / 2 + 0.5), 0.03 * (i % 2 + 0.5), -0.01)));
      vertices.push_back({at.x, at.y, at.z});
    }
    world.add("tile " + std::to_string(i), {vertices, tile.triangles});
  }
  const std::vector<std::array<float, 3>> tip{
      {0, 0, 0}, {0.003F, 0, 0.02F}, {-0.0015F, 0.0026F, 0.02F}, {-0.0015F, -0.0026F, 0.02F}};
  const std::vector<std::array<std::uint32_t, 3>> sides{{2, 1, 0}, {3, 2, 0}, {1, 3, 0}, {2, 3, 1}};
  static_cast<void>(world.hold({tip, sides}, {.spacing_m = 0.001, .stiffness_N_per_m = 800}));
  double lateral_N = 0;
  for (int i = 0; i < 1700; ++i) {
    const Vec3 at = turn({0.02 + 1e-4 * std::max(i - 600, 0), 0.03, std::max(-0.001, 0.01 - 2e-5 * i)});
    const World::ToolSample sample =
        world.stepTool({.position_m = {at.x, at.y, at.z}, .rotation = {turned.w, turned.x, turned.y, turned.z}});
    const Vec3 force_N = glm::conjugate(turned) * Vec3(sample.force_N[0], sample.force_N[1], sample.force_N[2]);
    lateral_N = std::max(lateral_N, std::hypot(force_N.x, force_N.y));
    if (i > 650) {
      ASSERT_NEAR(force_N.z, 0.8, 0.001) << i;
    }
  }
  EXPECT_LT(lateral_N, 0.01);
}

TEST(World, ToolLosesItsForceSmoothlyWhereItsPoseIsNone) {
  ToolOverSlab scene;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const World::Pose& bad : {World::Pose{.position_m = {nan, 0, 0}}, World::Pose{.rotation = {0, 0, 0, 0}}}) {
    EXPECT_EQ(scene.world.stepTool({.position_m = {0, 0, 0.03}}).fault, World::Fault::kNone);
    double before = scene.press(0.003).force_N[2];
    EXPECT_NEAR(before, 2, 0.01);
    for (int i = 0; i < 40; ++i) {
      const World::ToolSample sample = scene.world.stepTool(bad);
      EXPECT_EQ(sample.fault, World::Fault::kNonFiniteHip);
      EXPECT_LE(std::abs(sample.force_N[2] - before), 0.11);
      before = sample.force_N[2];
    }
    EXPECT_EQ(before, 0);
  }
}

TEST(World, ToolThatCannotBeHeldIsRefused) {
  ToolOverSlab scene;
  std::vector<std::array<float, 3>> vertices;
  const World::Mesh mesh = ToolOverSlab::meshOf(scene.box, vertices);
  EXPECT_THAT(refusalOf([&] { scene.world.hold(mesh, {.spacing_m = 0}); }), HasSubstr("tool.spacing_m: is 0"));
  EXPECT_THAT(refusalOf([&] { scene.world.hold(mesh, {.spacing_m = 1e-4}); }), HasSubstr("more than 8192 points"));
  EXPECT_THAT(refusalOf([&] { scene.world.hold(mesh, {.maxTorque_Nm = 0}); }), HasSubstr("tool.maxTorque_Nm: is 0"));
  EXPECT_THAT(refusalOf([&] { scene.world.hold(mesh, {.torsion_Nm_per_rad = -1}); }),
              HasSubstr("tool.torsion_Nm_per_rad"));
  EXPECT_THAT(refusalOf([&] { scene.world.hold({}, {}); }), HasSubstr("mesh: holds no face"));
  EXPECT_NEAR(scene.press(0.003).force_N[2], 2, 0.002);
}

TEST(World, HasRoomAgainWhereBodiesWereRemoved) {
  World world;
  const Sphere small(0.001);
  std::vector<std::uint64_t> bodies;
  for (int i = 0; i < 256; ++i) bodies.push_back(world.add("ball " + std::to_string(i), small.mesh()));
  EXPECT_THAT(refusalOf([&] { world.add("one more", small.mesh()); }), HasSubstr("256 already"));
  for (int i = 0; i < 10; ++i) {
    world.remove(bodies[static_cast<std::size_t>(i)]);
    world.add("ball " + std::to_string(i), small.mesh());
  }
  EXPECT_EQ(world.step({1, 1, 1}).fault, World::Fault::kNone);
}

TEST(World, RefusesBadInputAndNamesIt) {
  World world;
  const Sphere sphere;
  const auto body = world.add("ball", sphere.mesh());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusalOf([&] { world.add("ball", sphere.mesh()); }), HasSubstr("\"ball\" is already there"));
  EXPECT_THAT(refusalOf([&] { world.add("", sphere.mesh()); }), HasSubstr("name: has 0 bytes"));
  EXPECT_THAT(refusalOf([&] { world.add("none", {}); }), HasSubstr("mesh: holds no face"));
  // A length that nobody has memory for is refused before anything is read.
  EXPECT_THAT(refusalOf([&] {
                world.add("huge", {sphere.vertices, {sphere.triangles.data(), 1'000'000'000}});
              }),
              HasSubstr("mesh: has 1000000000 triangles"));
  EXPECT_THAT(refusalOf([&] { world.setPose(7, {}); }), HasSubstr("no body 7"));
  EXPECT_THAT(refusalOf([&] { world.setPose(body, {.position_m = {0, nan, 0}}); }), HasSubstr("pose.position_m[1]"));
  EXPECT_THAT(refusalOf([&] { world.setPose(body, {.rotation = {0, 0, 0, 0}}); }), HasSubstr("pose.rotation"));
  EXPECT_THAT(refusalOf([&] { world.setMaterial(body, {.stiffness_N_per_m = nan}); }), HasSubstr("stiffness_N_per_m"));
  EXPECT_THAT(refusalOf([&] { world.setMaterial(body, {.dynamicFriction = 0.1}); }), HasSubstr("dynamicFriction"));
  EXPECT_THAT(refusalOf([] { World bad({.rate_Hz = 1}); }), HasSubstr("device.rate_Hz"));
  EXPECT_THAT(refusalOf([] { (void)World::Device::named("omny"); }), HasSubstr("omni, touch"));
  Sphere broken;
  broken.triangles[3][1] = 1'000'000;
  EXPECT_THAT(refusalOf([&] { world.add("broken", broken.mesh()); }), HasSubstr("mesh.triangles[3]"));
  broken = Sphere();
  broken.vertices[2][0] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(refusalOf([&] { world.add("broken", broken.mesh()); }), HasSubstr("vertex 2"));
  EXPECT_GT(press(world, 0.002).force_N[2], 1);  // and goes on
}

TEST(World, RunIsAStepForEachPosition) {
  World one, other;
  const Sphere sphere;
  one.add("ball", sphere.mesh(), {.staticFriction = 0.5, .dynamicFriction = 0.4, .roundedBelow_rad = 1});
  other.add("ball", sphere.mesh(), {.staticFriction = 0.5, .dynamicFriction = 0.4, .roundedBelow_rad = 1});
  std::vector<World::Vector> hips;
  for (int i = 0; i < 2000; ++i) hips.push_back({1e-5 * i, 0, kRadius_m + 0.002 - 5e-6 * i});
  std::vector<World::Sample> samples(hips.size());
  one.run(hips, samples);
  bool touched = false;
  for (std::size_t i = 0; i < hips.size(); ++i) {
    const World::Sample sample = other.step(hips[i]);
    ASSERT_EQ(sample.force_N, samples[i].force_N) << i;
    touched = touched || samples[i].body != 0;
  }
  EXPECT_TRUE(touched);
}

/// A plate of 0.1 mm whose upper face is at z = 0.
std::uint64_t addPlate(World& world) {
  constexpr double kThick_m = 1e-4;
  const TriMesh mesh = makeBox(Vec3(0.2, 0.2, kThick_m), 1).value();
  std::vector<std::array<float, 3>> vertices;
  for (const Vec3f& v : mesh.vertices) vertices.push_back({v.x, v.y, v.z - static_cast<float>(kThick_m / 2)});
  return world.add("plate", {vertices, mesh.triangles}, {.stiffness_N_per_m = 500, .damping_Ns_per_m = 0});
}

TEST(World, ABodyThatIsMovedInEveryTickPushesTheHandAndIsWhereItWasPut) {
  World world;
  const auto plate = addPlate(world);
  for (int i = 0; i < 600; ++i) static_cast<void>(world.step({0.01, 0.02, 0.05}));
  const std::uint64_t allocations = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    for (int i = 0; i <= 55; ++i) {  // 1 m/s
      const double height_m = 1e-3 * i;
      world.moveKinematic(plate, {.position_m = {0, 0, height_m}});
      const World::Sample sample = world.step({0.01, 0.02, 0.05});
      ASSERT_NEAR(sample.force_N[2], 500 * std::max(height_m - 0.05, 0.0), 1e-4);
    }
  }
  EXPECT_EQ(AllocationTripwire::count(), allocations);
  world.setPose(plate, {});
  for (int i = 0; i < 600; ++i) static_cast<void>(world.step({0.01, 0.02, 0.05}));
  EXPECT_EQ(world.step({0.01, 0.02, 0.05}).body, 0U) << "setPose() puts it back";
  EXPECT_THAT(refusalOf([&] {
                world.moveKinematic(plate, {.position_m = {0, std::nan(""), 0}});
              }),
              HasSubstr("pose.position_m[1]"));
}

using Vertices = std::vector<std::array<float, 3>>;

Vertices raised(Vertices vertices, double by_m) {
  for (auto& v : vertices) v[2] += static_cast<float>(by_m);
  return vertices;
}

TEST(World, VerticesThatAreMovedInEveryTickPushTheHandAtAnySpeed) {
  const TriMesh box = makeBox(Vec3(0.2, 0.2, 1e-4), 3).value();
  Vertices plate;  // whose upper face is at z = 0
  for (const Vec3f& v : box.vertices) plate.push_back({v.x, v.y, v.z - 5e-5F});
  const Vertices sheet{{-0.1F, -0.1F, 0}, {0.1F, -0.1F, 0}, {0.1F, 0.1F, 0}, {-0.1F, 0.1F, 0}};
  const std::vector<std::array<std::uint32_t, 3>> two{{0, 1, 2}, {0, 2, 3}};
  for (const auto& [vertices, triangles] : {std::pair(plate, box.triangles), std::pair(sheet, two)}) {
    for (const double step_m : {1e-6, 1e-4, 1e-3}) {
      World world;
      const auto body = world.add("body", {vertices, triangles}, {.stiffness_N_per_m = 500, .damping_Ns_per_m = 0});
      const double hip_m = 300 * step_m;
      for (int i = 0; i < 600; ++i) static_cast<void>(world.step({0.01, 0.02, hip_m}));
      world.moveVerticesKinematic(body, vertices);  // prepares memory
      std::vector<Vertices> samples;
      for (int i = 0; i < 350; ++i) samples.push_back(raised(vertices, i * step_m));
      const std::uint64_t allocations = AllocationTripwire::count();
      {
        const AllocationTripwire armed;
        for (std::size_t i = 0; i < samples.size(); ++i) {
          world.moveVerticesKinematic(body, samples[i]);
          const double depth_m = std::max(static_cast<double>(i) * step_m - hip_m, 0.0);
          ASSERT_NEAR(world.step({0.01, 0.02, hip_m}).force_N[2], std::min(500 * depth_m, 3.3), 1e-4);
        }
      }
      EXPECT_EQ(AllocationTripwire::count(), allocations);
      EXPECT_NEAR(world.step({0.01, 0.02, hip_m}).force_N[2], std::min(500 * 49 * step_m, 3.3), 1e-4)
          << "it stays there";
      world.setMaterial(body, {.stiffness_N_per_m = 400, .damping_Ns_per_m = 0});
      for (int i = 0; i < 600; ++i) static_cast<void>(world.step({0.01, 0.02, hip_m}));
      EXPECT_NEAR(world.step({0.01, 0.02, hip_m}).force_N[2], std::min(400 * 49 * step_m, 3.3), 1e-4)
          << "through edits";
    }
  }
}

TEST(World, SetPoseEndsAMotionAtOnceAndIsFeltAsAnEdit) {
  const TriMesh box = makeBox(Vec3(0.1, 0.1, 0.04), 1).value();
  Vertices vertices;
  for (const Vec3f& v : box.vertices) vertices.push_back({v.x, v.y, v.z});
  World world(World::Device{.maxForce_N = 20});
  const auto body = world.add("box", {vertices, box.triangles}, {.stiffness_N_per_m = 500, .damping_Ns_per_m = 0},
                              {.position_m = {0, 0, -0.02}});
  const auto hold = [&](int tick) { return world.step({0, 0, std::max(-0.012, 0.01 - 1e-4 * tick)}).force_N[2]; };
  for (int i = 0; i < 600; ++i) static_cast<void>(hold(i));
  world.moveKinematic(body, {.position_m = {0, 0, -0.03}});
  static_cast<void>(hold(600));
  double last_N = hold(600), largest_N = 0;
  EXPECT_NEAR(last_N, 5, 0.01);
  world.setPose(body, {.position_m = {0, 0, -0.05}});
  for (int i = 0; i < 400; ++i) {
    const double now_N = hold(600);
    largest_N = std::max(largest_N, std::abs(now_N - last_N));
    last_N = now_N;
  }
  EXPECT_LE(largest_N, 0.031);
  EXPECT_EQ(last_N, 0);
}

/// Where a tick ends in the plane of the sheets, rounding has one of them a little above and the other a little below.
TEST(World, FlushSheetsLetNothingThroughWhereverATickEnds) {
  int lost = 0;
  for (int turn = 0; turn < 60; ++turn) {
    const Quat turned = glm::normalize(Quat(std::cos(turn), std::sin(2.7 * turn), std::cos(1.3 * turn + 1), 0.3));
    World world(World::Device{.maxForce_N = 1000});
    for (const double y : {0.0, 0.05 + 2e-8}) {
      Vertices sheet;
      for (const Vec3 corner : {Vec3(0, y, 0), Vec3(0.1, y, 0), Vec3(0.1, y + 0.05, 0), Vec3(0, y + 0.05, 0)}) {
        const Vec3f at(turned * corner);
        sheet.push_back({at.x, at.y, at.z});
      }
      const std::vector<std::array<std::uint32_t, 3>> two{{0, 1, 2}, {0, 2, 3}};
      world.add(y == 0 ? "one" : "other", {sheet, two}, {.stiffness_N_per_m = 1000, .damping_Ns_per_m = 0});
    }
    World::Sample sample;
    const auto step = [&](Vec3 hip) {
      hip = turned * hip;
      sample = world.step({hip.x, hip.y, hip.z});
    };
    for (int i = 0; i < 600; ++i) step({0.05, 0.02, 0.01});
    for (const double z : {0.01, 0.0003, 0.0002, 0.0001, 0.0, -0.0001, -0.0002, -0.001, -0.001})
      step({0.04 + 0.0003 * turn, 0.05 + 1e-8, z});
    lost += std::abs(std::hypot(sample.force_N[0], sample.force_N[1], sample.force_N[2]) - 1) > 0.01 ? 1 : 0;
  }
  EXPECT_EQ(lost, 0);
}

TEST(World, GoesOverWhereFourFlushTilesMeetWithinATickOf4kHz) {
  const TriMesh tile = makeBox({0.03, 0.03, 0.049}, 1).value();
  Vertices vertices;
  for (const Vec3f& v : tile.vertices) vertices.push_back({v.x, v.y, v.z});
  for (int turn = 0; turn < 20; ++turn) {
    const Quat turned = glm::normalize(Quat(std::cos(turn), std::sin(2.7 * turn), std::cos(1.3 * turn + 1), 0.3));
    World world(World::Device{.rate_Hz = 4000, .maxForce_N = 1000});
    for (const double x : {-0.015, 0.015}) {
      for (const double y : {-0.015, 0.015}) {
        const Vec3 at = turned * Vec3(x, y, -0.0245);
        world.add("tile " + std::to_string(x) + std::to_string(y), {vertices, tile.triangles},
                  {.stiffness_N_per_m = 1000},
                  {.position_m = {at.x, at.y, at.z}, .rotation = {turned.w, turned.x, turned.y, turned.z}});
      }
    }
    World::Sample sample;
    const auto step = [&](Vec3 hip) {
      hip = turned * hip;
      sample = world.step({hip.x, hip.y, hip.z});
    };
    for (int i = 0; i < 40; ++i) step({-0.003, 0, 0.0004 - 2e-5 * i});
    for (int i = 0; i < 240; ++i) {
      step({-0.003 + 2.5e-5 * i, 0, -0.0004});
      EXPECT_FALSE(sample.allowanceSpent) << turn << ' ' << i;
    }
  }
}

TEST(World, VerticesAreMovedOfAMeshWhoseCrackIsClosed) {
  const Vertices patches{{0, 0, 0},           {0.05F, 0, 0},           {0.05F, 0.05F, 0}, {0, 0.05F, 0},
                         {0, 0.05000002F, 0}, {0.05F, 0.05000002F, 0}, {0.05F, 0.1F, 0},  {0, 0.1F, 0}};
  const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  World world;
  const auto body = world.add("patches", {patches, triangles}, {.stiffness_N_per_m = 500, .damping_Ns_per_m = 0});
  for (int i = 0; i < 300; ++i) static_cast<void>(world.step({0.02, 0.07, 0.001}));
  double force_N = 0;
  for (int i = 1; i <= 30; ++i) {
    world.moveVerticesKinematic(body, raised(patches, 1e-4 * i));
    static_cast<void>(world.step({0.02, 0.07, 0.001}));
  }
  for (int i = 0; i < 300; ++i) force_N = world.step({0.02, 0.07, 0.001}).force_N[2];
  EXPECT_NEAR(force_N, 500 * 0.002, 1e-3);
}

TEST(World, ABallThatGrowsSlowlyPushesTheHandEvenly) {
  constexpr double kSpeed_m_per_s = 2e-3;
  World world;
  Sphere ball;
  const auto body = world.add("ball", ball.mesh(), {.stiffness_N_per_m = 500});
  const double hip_m = kRadius_m - 0.002;
  press(world, 0.002, 1000);
  constexpr int kPeriod = 16;
  for (int i = 0; i < 1500; ++i) {
    if (i % kPeriod == 0) {
      Vertices grown = ball.vertices;
      const double scale = 1 + 1e-3 * i * kSpeed_m_per_s / kRadius_m;
      for (auto& v : grown) {
        for (float& x : v) x = static_cast<float>(x * scale);
      }
      world.moveVerticesKinematic(body, grown);
    }
    const double force_N = world.step({0, 0, hip_m}).force_N[2];
    const double late_s = 1e-3 * std::max(i - kPeriod, 0);
    if (i > 2 * kPeriod) {
      ASSERT_NEAR(force_N, 500 * (0.002 + kSpeed_m_per_s * late_s), 0.03) << i;
    }
  }
}

TEST(World, SaysWhichVerticesItCannotMove) {
  World world;
  Sphere ball;
  const auto body = world.add("ball", ball.mesh());
  const auto rounded = world.add("rounded", ball.mesh(), {.roundedBelow_rad = 1});
  const auto refusal = [&](std::uint64_t of, const Vertices& vertices) {
    return refusalOf([&] { world.moveVerticesKinematic(of, vertices); });
  };
  EXPECT_THAT(refusal(7, ball.vertices), HasSubstr("body: there is no body 7"));
  EXPECT_THAT(refusal(body, {{0, 0, 0}}), HasSubstr("vertices: are 1; the mesh that add() got has"));
  Vertices far = ball.vertices;
  far[3][1] = std::nanf("");
  EXPECT_THAT(refusal(body, far), HasSubstr("vertices[3]"));
  EXPECT_THAT(refusal(rounded, ball.vertices), HasSubstr("material.roundedBelow_rad"));
  world.moveVerticesKinematic(body, ball.vertices);
  EXPECT_THAT(refusalOf([&] { world.setMaterial(body, {.roundedBelow_rad = 1}); }), HasSubstr("vertices were moved"));
  EXPECT_THAT(refusalOf([&] { static_cast<void>(world.hold(ball.mesh(), {})); }), HasSubstr("tool: "));
}

TEST(World, WithoutAMassForceIsStiffnessTimesDepthAtAnySpeed) {
  World world;
  addPlate(world);
  for (int i = 0; i < 600; ++i) static_cast<void>(world.step({0.01, 0.02, 0.02}));
  for (int i = 0; i < 70; ++i) {
    const double z = 0.02 - 3e-4 * i;  // 0.3 m/s
    ASSERT_NEAR(world.step({0.01, 0.02, z}).force_N[2], 500 * std::max(-z, 0.0), 1e-6) << i;
  }
}

TEST(World, StepsWithoutAllocating) {
  World world(World::Device::named("omni"));
  const auto body = world.add("ball", Sphere().mesh(), {.roundedBelow_rad = 1});
  press(world, 0.002);
  world.setMaterial(body, {.stiffness_N_per_m = 400});  // the next step adopts it
  const std::uint64_t allocations = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    press(world, 0.003);
  }
  EXPECT_EQ(AllocationTripwire::count(), allocations);
}

TEST(World, StepsAToolWithoutAllocating) {
  ToolOverSlab scene;
  scene.press(0.003, 100);
  scene.world.setPose(scene.ground, {.position_m = {0, 0, -0.049}});
  const std::uint64_t allocations = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    scene.press(0.003);
  }
  EXPECT_EQ(AllocationTripwire::count(), allocations);
}

}  // namespace
}  // namespace haptics::world_test
