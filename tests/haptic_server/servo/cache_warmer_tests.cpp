#include <gtest/gtest.h>

#include <cstring>

#include "common/mesh/generators.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "haptic_server/servo/cache_warmer.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::cache_warmer_tests {
namespace {

using namespace fixture;

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 3.3};

/// In and out of a sphere, and along the edge between it and a box.
DeviceReading hand(std::uint64_t tick) {
  const double angle = 0.004 * static_cast<double>(tick);
  const double radius_m = 0.05 + 0.004 * std::cos(5 * angle);
  return {radius_m * glm::normalize(Vec3(std::cos(angle), std::sin(angle), std::sin(0.3 * angle))),
          DeviceState::kReady};
}

std::unique_ptr<ServoScene> sphereAndBox() {
  return sceneOf(1, {objectOf(1, surfaceOf(makeSphere(0.05, 20).value()), Vec3(0)),
                     objectOf(2, surfaceOf(makeBox(Vec3(0.05), 3).value()), Vec3(0.05, 0, 0))});
}

TEST(CacheWarmer, ChangesNoBitOfWhatIsFelt) {
  const auto scene = sphereAndBox();
  HapticState with(kConfig), without(kConfig);
  (void)adoptScene(*scene, with, 0);
  (void)adoptScene(*scene, without, 0);
  const auto cacheWarmer = std::make_unique<CacheWarmer>(kConfig);
  int touched = 0;
  for (std::uint64_t tick = 0; tick < 5000; ++tick) {
    (*cacheWarmer)(*scene, with);
    const StepInput input{tick, 0, hand(tick)};
    const TelemetrySample a = hapticStep(*scene, with, kConfig, input);
    const TelemetrySample b = hapticStep(*scene, without, kConfig, input);
    touched += a.object != 0 ? 1 : 0;
    ASSERT_EQ(std::memcmp(&a.force, &b.force, sizeof a.force), 0) << tick;
    ASSERT_EQ(std::memcmp(&a.ihip, &b.ihip, sizeof a.ihip), 0) << tick;
    ASSERT_EQ(a.primitive, b.primitive) << tick;
    ASSERT_EQ(a.energyGiven_J, b.energyGiven_J) << tick;
    ASSERT_EQ(a.fault, b.fault) << tick;
  }
  EXPECT_GT(touched, 1000);
  EXPECT_LT(touched, 4900);
}

/// The step as the server's loop runs it, after a rehearsal, against the same step without one.
struct Rehearsed {
  const ServoScene& scene;
  HapticState with{kConfig};
  HapticState without{kConfig};
  std::unique_ptr<CacheWarmer> cacheWarmer = std::make_unique<CacheWarmer>(kConfig);

  explicit Rehearsed(const ServoScene& s) : scene(s) {
    (void)adoptScene(scene, with, 0);
    (void)adoptScene(scene, without, 0);
  }
  TelemetrySample tick(const StepInput& input) {
    (*cacheWarmer)(scene, with);
    ForceResult felt;
    computeForce(scene, with, kConfig, input, felt, &cacheWarmer->cache());
    const TelemetrySample a = finishStep(scene, with, kConfig, input, felt);
    const TelemetrySample b = hapticStep(scene, without, kConfig, input);
    EXPECT_EQ(std::memcmp(&a.force, &b.force, sizeof a.force), 0) << input.tick;
    EXPECT_EQ(std::memcmp(&a.ihip, &b.ihip, sizeof a.ihip), 0) << input.tick;
    EXPECT_EQ(std::memcmp(&a.surfaceNormal, &b.surfaceNormal, sizeof a.surfaceNormal), 0) << input.tick;
    EXPECT_EQ(a.penetration_m, b.penetration_m) << input.tick;
    EXPECT_EQ(a.primitive, b.primitive) << input.tick;
    return a;
  }
};

/// Inside of a fine sphere alone, over several of its polygons in a tick.
DeviceReading slide(std::uint64_t tick) {
  const double angle = 0.04 * static_cast<double>(tick);
  return {0.048 * glm::normalize(Vec3(std::cos(angle), std::sin(angle), std::sin(0.3 * angle))), DeviceState::kReady};
}

TEST(CacheWarmer, ChangesNoBitOfATickOverPolygonsThatItWorkedOut) {
  const auto scene = sceneOf(1, {objectOf(1, surfaceOf(makeSphere(0.05, 60).value()), Vec3(0))});
  Rehearsed both(*scene);
  // From outside to the begin of the slide.
  (void)both.tick({0, 0, {1.05 * slide(1).position / 0.96, DeviceState::kReady}});
  int ontoKnown = 0;
  for (std::uint64_t tick = 1; tick < 3000 && !::testing::Test::HasFailure(); ++tick) {
    (void)both.tick({tick, 0, slide(tick)});
    const std::uint32_t held = both.with.contact.holding[0].triangle;
    const CollisionMesh& surface = *scene->objects[0].surface;
    const bool known = both.cacheWarmer->cache().find(surface, held) != nullptr;
    ontoKnown += known && !both.with.contactCache.polygon.is(surface, held) ? 1 : 0;
  }
  EXPECT_GT(ontoKnown, 1500);
}

/// Two finely divided boxes of 50 mm in one mesh, the second one moved by half of that and upwards by a fifth.
std::shared_ptr<const CollisionMesh> boxesThroughEachOther() {
  TriMesh both = makeBox(Vec3(0.05), 20).value();
  const TriMesh box = both;
  const auto first = static_cast<std::uint32_t>(both.vertices.size());
  for (const Vec3f v : box.vertices) both.vertices.push_back(v + Vec3f(0.0253F, 0.0017F, 0.0101F));
  for (const TriangleIndices& t : box.triangles) both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return surfaceOf(both);
}

TEST(CacheWarmer, ChangesNoBitWhereAMeshCrossesItself) {
  const auto scene = sceneOf(1, {objectOf(1, boxesThroughEachOther(), Vec3(0))});
  ASSERT_TRUE(scene->objects[0].surface->anySelfIntersecting());
  Rehearsed both(*scene);
  int blocked = 0;
  // 2 mm under the first one's top, into the other one's side.
  for (std::uint64_t tick = 0; tick < 400 && !::testing::Test::HasFailure(); ++tick) {
    const double along = 2e-4 * static_cast<double>(tick);
    const Vec3 place = tick < 40 ? Vec3(-0.02, 0, 0.031 - along) : Vec3(-0.02807 + along, 0.0031, 0.023);
    const TelemetrySample sample = both.tick({tick, 0, {place, DeviceState::kReady}});
    blocked += sample.object != 0 && sample.ihip.x < sample.hip.x - 1e-3 ? 1 : 0;
  }
  EXPECT_GT(blocked, 20);
}

TEST(CacheWarmer, ForgetsThePolygonsOfASceneThatIsGone) {
  const auto first = sceneOf(1, {objectOf(1, surfaceOf(makeSphere(0.05, 20).value()), Vec3(0))});
  const auto second = sceneOf(2, {objectOf(1, surfaceOf(makeSphere(0.05, 30).value()), Vec3(0))});
  HapticState state(kConfig);
  (void)adoptScene(*first, state, 0);
  const auto cacheWarmer = std::make_unique<CacheWarmer>(kConfig);
  for (std::uint64_t tick = 0; tick < 3; ++tick) {
    const Vec3 inwards{0, 0, 0.051 - 0.001 * static_cast<double>(tick)};
    (void)hapticStep(*first, state, kConfig, {tick, 0, {inwards, DeviceState::kReady}});
  }
  const std::uint32_t held = state.contact.holding[0].triangle;
  const CollisionMesh& surface = *first->objects[0].surface;
  (*cacheWarmer)(*first, state);
  ASSERT_NE(cacheWarmer->cache().find(surface, held), nullptr);
  (void)hapticStep(*first, state, kConfig, {3, 0, {Vec3(0, 0, 0.06), DeviceState::kReady}});
  ASSERT_TRUE(adoptScene(*second, state, 4));
  (*cacheWarmer)(*second, state);
  EXPECT_EQ(cacheWarmer->cache().find(surface, held), nullptr);
}

TEST(CacheWarmer, LeavesADeviceThatWasNeverReadyAlone) {
  const auto scene = sphereAndBox();
  HapticState state(kConfig);
  (void)adoptScene(*scene, state, 0);
  (*std::make_unique<CacheWarmer>(kConfig))(*scene, state);
  const TelemetrySample sample = hapticStep(*scene, state, kConfig, {0, 0, {Vec3(0), DeviceState::kAbsent}});
  EXPECT_FALSE(state.supervision.attached);
  EXPECT_EQ(sample.fault, Fault::kDeviceLost);
}

TEST(CacheWarmer, AllocatesNothing) {
  const auto scene = sphereAndBox();
  HapticState state(kConfig);
  (void)adoptScene(*scene, state, 0);
  const auto cacheWarmer = std::make_unique<CacheWarmer>(kConfig);
  const std::uint64_t allocations = AllocationTripwire::count();
  for (std::uint64_t tick = 0; tick < 2000; ++tick) {
    const AllocationTripwire armed;
    (*cacheWarmer)(*scene, state);
    static_cast<void>(hapticStep(*scene, state, kConfig, {tick, 0, hand(tick)}));
  }
  EXPECT_EQ(AllocationTripwire::count(), allocations);
}

}  // namespace
}  // namespace haptics::cache_warmer_tests
