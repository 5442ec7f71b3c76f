#include "haptic_server/scene/scene_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <ctime>
#include <future>
#include <thread>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/stiffness_limit.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::scene_service_test {
namespace {

using namespace test;
using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr SessionId kAlice = 11, kBob = 21;
constexpr auto kPatience = 60s;  // of a test for another thread; never reached unless something is broken

std::vector<ObjectId> idsOf(const ServoScene& scene, bool pendingRemoval) {
  std::vector<ObjectId> ids;
  for (const ServoObject& object : scene.objects) {
    if (object.pendingRemoval == pendingRemoval) ids.push_back(object.id);
  }
  return ids;
}

constexpr auto kNewPlan = ServoSceneBuilder::Plan::kReplan;
constexpr auto kOldPlan = ServoSceneBuilder::Plan::kKeep;

TEST(ServoSceneBuilder, KeepsARemovedObjectForAWhileAsLeaving) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker({});
  sequencer.submit(kAlice, 1, edit(add("a"), add("b")));
  EXPECT_THAT(idsOf(*maker.make(sequencer, 0, kNewPlan), false), ElementsAre(1, 2));
  EXPECT_EQ(maker.nextDeparture_ns(), std::nullopt);

  sequencer.submit(kAlice, 2, edit(remove("a"), add("c")));
  const auto scene = maker.make(sequencer, 100, kNewPlan);
  EXPECT_EQ(scene->revision, 2U);
  EXPECT_THAT(idsOf(*scene, false), ElementsAre(2, 3));
  EXPECT_THAT(idsOf(*scene, true), ElementsAre(1));
  EXPECT_EQ(scene->objects[0].id, 1U) << "in order of id";
  EXPECT_EQ(maker.nextDeparture_ns(), 100 + kRemovalFade_ns);

  EXPECT_THAT(idsOf(*maker.make(sequencer, 99 + kRemovalFade_ns, kNewPlan), true), ElementsAre(1));
  const auto after = maker.make(sequencer, 100 + kRemovalFade_ns, kNewPlan);
  EXPECT_THAT(idsOf(*after, true), ElementsAre());
  EXPECT_EQ(after->revision, 2U);
  EXPECT_EQ(maker.nextDeparture_ns(), std::nullopt);
}

TEST(ServoSceneBuilder, HoldsAToolByASpringAlsoWhereADeviceBearsNone) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker({}, {.stiffest_N_per_m = 0, .stiffestTorsion_Nm_per_rad = 0});
  sequencer.submit(kAlice, 1, edit(add("a"), SetMotion{named("a"), MotionProperties{.tool = ToolProperties{0.01}}}));
  const auto scene = maker.make(sequencer, 0, kNewPlan);
  ASSERT_NE(scene->objects[0].tool, nullptr);
  EXPECT_GT(scene->objects[0].stiffness_N_per_m, 0);
  EXPECT_GT(scene->objects[0].torsion_Nm_per_rad, 0);
}

TEST(ServoSceneBuilder, LetsTheOldestGoEarlyWhenThereIsNoRoomToLeave) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker({});
  Transaction full, fullAgain;
  for (std::size_t i = 0; i < kMaxServoObjects; ++i) {
    full.operations.push_back(add(numbered("o", i)));
    if (i >= 2) fullAgain.operations.push_back(remove(numbered("o", i)));
  }
  sequencer.submit(kAlice, 1, full);
  (void)maker.make(sequencer, 0, kNewPlan);
  sequencer.submit(kAlice, 2, edit(remove("o0")));
  (void)maker.make(sequencer, 0, kNewPlan);
  sequencer.submit(kAlice, 3, fullAgain);
  const auto scene = maker.make(sequencer, 1, kNewPlan);
  EXPECT_EQ(scene->objects.size(), kMaxServoObjects);
  EXPECT_THAT(idsOf(*scene, false), ElementsAre(2));
}

/// Springs of different objects pull at one hand where their reaches lie over one another.
TEST(ServoSceneBuilder, SharesWhatTheDeviceBearsAmongTheEffectsOfAllObjects) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker({}, {.stiffest_N_per_m = 1000, .maxDamping_Ns_per_m = 10});
  const Effect snap{
      .kind = Effect::Kind::kSpringToPoint, .stiffness_N_per_m = 750, .damping_Ns_per_m = 1, .reach_m = 0.2};
  Effect apart = snap, wall{.kind = Effect::Kind::kForbiddenSide, .direction = Vec3(0, 0, 1), .stiffness_N_per_m = 900};
  apart.point_m.x = 0.5;
  Effect across = wall;
  across.direction = Vec3(1, 0, 0);
  auto after = [&, seq = std::uint64_t{0}](const Transaction& transaction) mutable {
    sequencer.submit(kAlice, ++seq, transaction);
    return maker.make(sequencer, 0, kNewPlan)->effects;
  };
  const auto stiffnesses = [](const std::vector<ServoEffect>& effects) {
    std::vector<double> all;
    for (const ServoEffect& effect : effects) all.push_back(effect.field->stiffness().spring_N_per_m);
    return all;
  };
  const auto alone = after(edit(add("a"), SetEffects{named("a"), {snap, apart}}, add("b")));
  EXPECT_THAT(stiffnesses(alone), ElementsAre(750, 750));
  const auto both = after(edit(SetEffects{named("b"), {snap}}));
  EXPECT_THAT(stiffnesses(both), ElementsAre(500, 750, 500));
  EXPECT_EQ(both[1].field, alone[1].field) << "what is felt as before is not edited";
  EXPECT_THAT(stiffnesses(after(edit(moveTo("b", {0.5, 0, 0})))), ElementsAre(750, 500, 500));
  EXPECT_THAT(stiffnesses(after(edit(moveTo("b", {0, 1, 0})))), ElementsAre(750, 750, 750));
  EXPECT_THAT(stiffnesses(after(edit(remove("b")))), ElementsAre(750, 750)) << "what leaves does not share";
  EXPECT_THAT(stiffnesses(after(edit(SetEffects{named("a"), {wall, across}}))), ElementsAre(900, 900));
  EXPECT_THAT(stiffnesses(after(edit(SetEffects{named("a"), {wall, wall, across}}))), ElementsAre(500, 500, 900));
}

TEST(ServoSceneBuilder, KeepsWhatASurfaceIsMadeOfUntilItIsEdited) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker({});
  auto detailAfter = [&, seq = std::uint64_t{0}](const Transaction& transaction) mutable {
    sequencer.submit(kAlice, ++seq, transaction);
    return maker.make(sequencer, 0, kNewPlan)->objects.at(0).detail;
  };
  EXPECT_EQ(detailAfter(edit(add("a"))), nullptr);
  SurfaceEdit change;
  change.shading = Shading{0.5, {}};
  const auto shaded = detailAfter(edit(setSurface(change)));
  ASSERT_NE(shaded, nullptr);
  EXPECT_EQ(detailAfter(edit(moveTo("a", {1, 0, 0}))), shaded);

  change.shading.reset();
  change.friction = FrictionEdit{Friction{0.6, 0.3, 0, PerVertexScale{}}, sameValues(0.5F)};
  change.texture = TextureEdit{Texture{.family = GrainFamily{0.01, 1}, .amplitude_m = 1e-3}, {}};
  const auto rubbed = detailAfter(edit(setSurface(change)));
  EXPECT_EQ(rubbed->shading, shaded->shading) << "normals of a large mesh take their time";
  EXPECT_EQ(rubbed->friction->most(), 0.3);
  EXPECT_TRUE(rubbed->texture);

  const auto remeshed = detailAfter(edit(RemeshObject{named("a"), box(0.2)}));
  EXPECT_NE(remeshed->shading, shaded->shading);
  change.friction.emplace();
  change.texture.emplace();
  change.shading.emplace();
  EXPECT_EQ(detailAfter(edit(setSurface(change))), nullptr);
}

TEST(ServoSceneBuilder, PlansTheExplorationOncePerRevision) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  std::vector<std::size_t> planned;
  ServoSceneBuilder maker([&](const ServoScene& scene) {
    planned.push_back(scene.objects.size());
    return std::make_shared<const ExplorationPlan>();
  });
  sequencer.submit(kAlice, 1, edit(add("a"), add("b")));
  const auto first = maker.make(sequencer, 0, kNewPlan);
  EXPECT_NE(first->plan, nullptr);
  sequencer.submit(kAlice, 2, edit(remove("a")));
  const auto second = maker.make(sequencer, 0, kNewPlan);
  const auto third = maker.make(sequencer, kRemovalFade_ns, kNewPlan);
  EXPECT_NE(second->plan, first->plan);
  EXPECT_EQ(third->plan, second->plan);
  EXPECT_THAT(planned, ElementsAre(2, 1)) << "what is leaving is not explored";
}

TEST(ServoSceneBuilder, PlansAnewWhenBodiesHaveComeToRestElsewhere) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  std::vector<Vec3> planned;
  ServoSceneBuilder maker([&](const ServoScene& scene) {
    planned.push_back(scene.objects.front().pose.position);
    return std::make_shared<const ExplorationPlan>();
  });
  sequencer.submit(kAlice, 1, edit(AddObject{"a", box(), {}, {}, MotionProperties{.mass_kg = 1}}));
  EXPECT_EQ(maker.make(sequencer, 0, kNewPlan)->objects.front().pose.position, Vec3(0));
  MotionState motion;
  motion.bodyCount = 1;
  motion.body[0] = {1, Pose{Quat(1, 0, 0, 0), Vec3(1, 2, 3)}, BodyCondition::kAwake};
  maker.follow(motion);
  EXPECT_FALSE(maker.planIsOld()) << "it still moves";
  motion.body[0].condition = BodyCondition::kAsleep;
  maker.follow(motion);
  EXPECT_TRUE(maker.planIsOld());
  EXPECT_EQ(maker.make(sequencer, 0, kNewPlan)->objects.front().pose.position, Vec3(0)) << "the scene's, as before";
  maker.follow(motion);
  EXPECT_FALSE(maker.planIsOld());
  EXPECT_EQ(planned, (std::vector<Vec3>{Vec3(0), Vec3(1, 2, 3)}));
}

TEST(ServoSceneBuilder, GivesLightBodiesTheStiffnessThatTheyBear) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker({});
  sequencer.submit(kAlice, 1,
                   edit(AddObject{"light", box(), {}, {800.0, 0.5}, MotionProperties{.mass_kg = 1e-3}},
                        AddObject{"heavy", box(), {}, {800.0, 0.5}, MotionProperties{.mass_kg = 1}}));
  const auto scene = maker.make(sequencer, 0, kNewPlan);
  EXPECT_LT(scene->objects[0].stiffness_N_per_m, 200);
  EXPECT_NEAR(scene->objects[0].damping_Ns_per_m / scene->objects[0].stiffness_N_per_m, 0.5 / 800, 1e-12);
  EXPECT_EQ(scene->objects[1].stiffness_N_per_m, 800);
}

TEST(ServoSceneBuilder, LeavesThePlanForLaterWhenToldSo) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  ServoSceneBuilder maker([](const ServoScene&) { return std::make_shared<const ExplorationPlan>(); });
  sequencer.submit(kAlice, 1, edit(add("a")));
  const auto first = maker.make(sequencer, 0, kOldPlan);
  EXPECT_NE(first->plan, nullptr) << "there is none to keep";
  EXPECT_FALSE(maker.planIsOld());
  sequencer.submit(kAlice, 2, edit(add("b")));
  EXPECT_EQ(maker.make(sequencer, 0, kOldPlan)->plan, first->plan);
  EXPECT_TRUE(maker.planIsOld());
  EXPECT_NE(maker.make(sequencer, 0, kNewPlan)->plan, first->plan);
  EXPECT_FALSE(maker.planIsOld());
}

/// Plays the servo: goes over to the newest scene.
class Servo {
 public:
  explicit Servo(SceneMailbox& mailbox) : mailbox_(mailbox) {}
  const ServoScene* look() {
    if (const ServoScene* next = mailbox_.newest()) {
      scene_ = next;
      mailbox_.adopted();
    }
    return scene_;
  }
  template <class Condition>
  [[nodiscard]] bool waitFor(Condition condition) {
    for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
      if (look() && condition(*scene_)) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }

 private:
  SceneMailbox& mailbox_;
  const ServoScene* scene_ = nullptr;
};

/// Waits for the reply.
EditOutcome submitTo(SceneService& sceneService, std::uint64_t seq, const Transaction& transaction) {
  auto reply = std::make_shared<std::promise<EditOutcome>>();
  EXPECT_TRUE(
      sceneService.submitEdit(kAlice, seq, transaction, [reply](const EditOutcome& o) { reply->set_value(o); }));
  auto future = reply->get_future();
  if (future.wait_for(kPatience) != std::future_status::ready) throw std::runtime_error("no reply");
  return future.get();
}

class SceneServiceTest : public ::testing::Test {
 protected:
  EditOutcome submit(std::uint64_t seq, const Transaction& transaction) {
    return submitTo(sceneService, seq, transaction);
  }

  SceneMailbox mailbox;
  Servo servo{mailbox};
  std::vector<std::string> logged;
  SceneService sceneService{
      {.assetFolders = {}, .makePlan = {}, .log = [this](const std::string& line) { logged.push_back(line); }},
      mailbox};
};

TEST_F(SceneServiceTest, PublishesTheStartSceneBeforeItRuns) {
  const auto reports = sceneService.loadStartScene(edit(add("a"), add("b")));
  ASSERT_TRUE(reports);
  EXPECT_EQ(reports->size(), 2U);
  EXPECT_EQ(logged, *reports);
  ASSERT_NE(servo.look(), nullptr);
  EXPECT_EQ(servo.look()->objects.size(), 2U);
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  EXPECT_NE(sceneService.history()->epoch, 0U);
}

TEST_F(SceneServiceTest, RefusesABadStartSceneByField) {
  const auto reports = sceneService.loadStartScene(edit(add("a"), add("b", file("../../etc/passwd"))));
  ASSERT_FALSE(reports);
  EXPECT_EQ(reports.error().field, "operations[1].add.mesh.file");
  EXPECT_EQ(servo.look(), nullptr);
  EXPECT_TRUE(sceneService.loadStartScene(edit(add("a"))));
}

TEST_F(SceneServiceTest, PublishesAnEditToServoAndListenerBeforeItReplies) {
  std::uint64_t heard = 0;
  sceneService.start();
  sceneService.setListener([&](const std::shared_ptr<const SceneHistory>& history) {
    heard = history->version.revision();
    EXPECT_EQ(sceneService.history(), history) << "a listener may ask for it";
  });
  const auto outcome = submit(1, edit(add("a")));
  ASSERT_TRUE(std::holds_alternative<Accepted>(outcome));
  EXPECT_EQ(heard, 1U);
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  ASSERT_NE(servo.look(), nullptr);
  EXPECT_EQ(servo.look()->revision, 1U);
  EXPECT_TRUE(std::holds_alternative<Error>(submit(2, edit(add("a")))));
  EXPECT_EQ(heard, 1U);
}

TEST_F(SceneServiceTest, GrowsAPatternOnAMeshAndNamesItByItsHash) {
  sceneService.start();
  AddObject ball{"ball", {SphereSource{0.02, 8}}, {}, {}};
  ball.material.surface.texture = TextureEdit{Texture{.family = GrownFamily{}, .amplitude_m = 1e-3},
                                              {GrownSource{GrownReactionDiffusionSource{.wavelength_m = 0.01}}}};
  const auto outcome = submit(1, edit(ball));
  ASSERT_TRUE(std::holds_alternative<Accepted>(outcome)) << std::get<Error>(outcome).text();
  const ObjectRecord record = std::get<Accepted>(outcome)->commit.put.at(0);
  const AssetName name{AssetKind::kPointField, std::get<GrownFamily>(record.material.surface.texture->family).points};
  const auto asset = sceneService.findAsset(name.hash);
  ASSERT_NE(asset, nullptr);
  const auto atClient = decodeAsset(name.kind, asset->bytes().copy());
  ASSERT_TRUE(atClient) << atClient.error().text();
  EXPECT_EQ(canonicalBytes(*atClient).hash(), name.hash);
  const auto own = std::get<std::shared_ptr<const PointField>>(*atClient);
  const auto servers = as<PointFieldAsset>(asset)->field;
  EXPECT_NE(own, servers);
  for (double x = -0.02; x < 0.02; x += 0.001) {
    const Vec3 point(x, std::sqrt(0.0004 - x * x), 0);
    EXPECT_EQ(own->at(point).value, servers->at(point).value);
    EXPECT_EQ(own->at(point).gradient, servers->at(point).gradient);
  }
  EXPECT_EQ(own->bounds().lowest, servers->bounds().lowest);
  ball.name = "fine";
  std::get<GrownSource>((*ball.material.surface.texture)->sources[0]).points =
      GrownReactionDiffusionSource{.wavelength_m = 1e-4};
  const auto refused = submit(2, edit(ball));
  ASSERT_TRUE(std::holds_alternative<Error>(refused));
  EXPECT_EQ(std::get<Error>(refused).field,
            "operations[0].add.material.texture.field.grown.reaction_diffusion.wavelength_m");
}

TEST_F(SceneServiceTest, ARemovedObjectLeavesLater) {
  ASSERT_TRUE(sceneService.loadStartScene(edit(add("a"), add("b"))));
  sceneService.start();
  submit(1, edit(remove("a")));
  EXPECT_THAT(idsOf(*servo.look(), false), ElementsAre(2));
  EXPECT_TRUE(servo.waitFor([](const ServoScene& scene) { return idsOf(scene, true).empty(); }));
  EXPECT_EQ(servo.look()->revision, 2U);
}

TEST(SceneService, AnswersAStiffnessBeyondWhatTheDefaultDeviceBearsWithWhatIsFelt) {
  class IdleHand final : public HandIntent {
   public:
    HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
  } idle;
  const DevicePreset preset = findDevicePreset(kDefaultDevicePreset).value();
  const SurfaceLimits limits = surfaceLimits(SimulatedDevice({preset, HandPreset{}}, idle).info(), 1000, true);
  const DeviceLimits device{.stiffest_N_per_m = limits.stiffness_N_per_m,
                            .maxDamping_Ns_per_m = limits.damping_Ns_per_m};
  SceneMailbox mailbox;
  Servo servo(mailbox);
  SceneService sceneService({.assetFolders = {}, .makePlan = {}, .device = device, .log = {}}, mailbox);
  ASSERT_TRUE(sceneService.loadStartScene(edit(add("a"))));
  sceneService.start();
  const SetMaterial stiffer{named("a"), {.stiffness_N_per_m = 90'000, .damping_Ns_per_m = {}, .surface = {}}};
  const EditOutcome outcome = submitTo(sceneService, 1, edit(stiffer));
  ASSERT_TRUE(std::holds_alternative<Accepted>(outcome));
  const double felt_N_per_m = servo.look()->objects.at(0).stiffness_N_per_m;
  EXPECT_EQ(felt_N_per_m, limits.stiffness_N_per_m);
  EXPECT_THAT(std::get<Accepted>(outcome)->reports,
              ElementsAre(HasSubstr("warning: stiffness_N_per_m is felt as " +
                                    std::to_string(static_cast<int>(felt_N_per_m)) + " instead of 90000")));
  MotionProperties fixed;
  fixed.fixed = true;
  fixed.collision.emplace();
  std::uint64_t seq = 1;
  for (const auto& motion : {std::optional(fixed), std::optional<MotionProperties>()}) {
    const EditOutcome other = submitTo(sceneService, ++seq, edit(SetMotion{named("a"), motion}));
    EXPECT_THAT(std::get<Accepted>(other)->reports, Contains(HasSubstr("stiffness_N_per_m is felt as")))
        << "it still is";
  }
}

TEST(SceneService, CutsAStiffnessThatVariesOffWhereTheDeviceBearsNoMore) {
  SceneMailbox mailbox;
  Servo servo(mailbox);
  const DeviceLimits device{.stiffest_N_per_m = 1000, .maxDamping_Ns_per_m = 0.5};
  SceneService sceneService({.assetFolders = {}, .makePlan = {}, .device = device, .log = {}}, mailbox);
  AddObject added = std::get<AddObject>(add("a"));
  added.material.stiffness_N_per_m = 800;
  added.material.damping_Ns_per_m = 0.5;
  std::vector<float> values(8, 0.5F);
  values[3] = 2;
  added.material.surface.stiffnessOver =
      SurfaceMapEdit{SurfaceMap{0, PerVertexScale{}}, VertexValuesSource{GivenValues{values}}};
  ASSERT_TRUE(sceneService.loadStartScene(edit(added)));
  sceneService.start();
  ASSERT_NE(servo.look(), nullptr);
  const ServoObject& felt = servo.look()->objects.at(0);
  EXPECT_EQ(felt.stiffness_N_per_m, 800) << "as asked for, where it is not cut off";
  EXPECT_EQ(felt.highestFactor, 1.25);
  EXPECT_EQ(felt.damping_Ns_per_m, 0.4) << "0.5 Ns/m where it is the most";
}

TEST(SceneService, NoEditWaitsForThePlan) {
  std::atomic<int> planned{0};
  std::promise<void> release;
  auto released = release.get_future().share();
  const auto makePlan = [&, released](const ServoScene& scene) {
    if (++planned > 1) released.wait();
    auto plan = std::make_shared<ExplorationPlan>();
    plan->clearHeight_m = static_cast<double>(scene.revision);
    return plan;
  };
  SceneMailbox mailbox;
  Servo servo(mailbox);
  SceneService sceneService({.assetFolders = {}, .makePlan = makePlan, .log = {}}, mailbox);
  ASSERT_TRUE(sceneService.loadStartScene(edit(add("a"))));
  sceneService.start();
  (void)submitTo(sceneService, 1, edit(add("b")));
  EXPECT_EQ(servo.look()->revision, 2U);
  EXPECT_EQ(servo.look()->plan->clearHeight_m, 1) << "of the scene before";
  release.set_value();
  EXPECT_TRUE(servo.waitFor([](const ServoScene& scene) { return scene.plan->clearHeight_m == 2; }));
  EXPECT_EQ(planned, 2);
}

TEST(SceneService, AnEditEndsThePlanThatIsBeingMadeAndItIsMadeLater) {
  std::atomic<int> begun{0};
  const auto makePlan = [&](const ServoScene& scene) {
    const bool isLong = ++begun == 2;
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (isLong && std::chrono::steady_clock::now() < end) interruptionPoint();
    auto plan = std::make_shared<ExplorationPlan>();
    plan->clearHeight_m = static_cast<double>(scene.revision);
    return plan;
  };
  SceneMailbox mailbox;
  Servo servo(mailbox);
  SceneService sceneService({.assetFolders = {}, .makePlan = makePlan, .log = {}}, mailbox);
  ASSERT_TRUE(sceneService.loadStartScene(edit(add("a"))));
  sceneService.start();
  (void)submitTo(sceneService, 1, edit(add("b")));
  while (begun < 2) std::this_thread::sleep_for(1ms);
  const auto sent = std::chrono::steady_clock::now();
  (void)submitTo(sceneService, 2, edit(add("c")));
  EXPECT_LT(std::chrono::steady_clock::now() - sent, kPatience / 2);
  EXPECT_TRUE(servo.waitFor([](const ServoScene& scene) { return scene.plan->clearHeight_m == 3; }));
}

TEST_F(SceneServiceTest, AnEditMayNameAnUploadThatSomeoneHolds) {
  sceneService.start();
  const TriMesh mesh = makeBox(Vec3(0.5), 3).value();
  std::promise<Result<std::shared_ptr<const Asset>>> built;
  ASSERT_TRUE(sceneService.submitAsset(kAlice, {AssetKind::kMesh, hashOf(mesh)}, encodeMesh(mesh),
                                       [&](auto outcome) { built.set_value(std::move(outcome)); }));
  auto asset = built.get_future().get();
  ASSERT_TRUE(asset);
  EXPECT_EQ(sceneService.findAsset(hashOf(mesh)), *asset);
  EXPECT_TRUE(std::holds_alternative<Accepted>(submit(1, edit(add("a", {AssetSource{hashOf(mesh)}})))));
  *asset = nullptr;
  EXPECT_NE(sceneService.findAsset(hashOf(mesh)), nullptr) << "the scene holds it";
  EXPECT_EQ(std::get<Error>(submit(2, edit(add("b", {AssetSource{ContentHash{}}})))).field,
            "operations[0].add.mesh.asset");
}

TEST_F(SceneServiceTest, AnswersAndIsFeltThoughThereIsNoMemoryToTellOthersWhoHearLater) {
  std::atomic<int> failures = 0;
  std::promise<void> heard;
  sceneService.setListener([&](const std::shared_ptr<const SceneHistory>& history) {
    if (failures > 0 && failures-- > 0) throw std::bad_alloc();
    if (history->version.revision() == 1) heard.set_value();
  });
  failures = 1;
  sceneService.start();
  EXPECT_TRUE(std::holds_alternative<Accepted>(submit(1, edit(add("a")))));
  EXPECT_TRUE(servo.waitFor([](const ServoScene& scene) { return scene.objects.size() == 1; }));
  EXPECT_EQ(sceneService.history()->version.revision(), 1U);
  EXPECT_EQ(heard.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
}

TEST_F(SceneServiceTest, AFullQueueTakesNoMoreAndNeverAnswersWhatItDidNotTake) {
  std::promise<void> release;
  auto released = release.get_future().share();
  sceneService.start();
  ASSERT_TRUE(sceneService.submitEdit(kAlice, 1, edit(add("a")), [released](const EditOutcome&) { released.wait(); }));
  Transaction many;
  many.operations.assign(1000, moveTo("a", {1, 0, 0}));
  SetDeformation lattice{named("a"), {}};
  lattice.deformation.lattice.emplace(Lattice{.low_m = {}, .size_m = Vec3(1), .points = {8, 8, 8}, .control_m = {}});
  (*lattice.deformation.lattice)->control_m.resize(512);
  Transaction large;
  large.operations.assign(71, lattice);
  std::atomic<int> answered = 0;
  std::size_t taken_bytes = 0;
  int taken = 0;
  const auto fill = [&](const Transaction& transaction, std::size_t each_bytes) {
    const auto session = [&] { return kAlice + static_cast<SessionId>(taken % 4); };
    while (taken < 10'000 &&
           sceneService.submitEdit(session(), 2, transaction, [&answered](const EditOutcome&) { ++answered; })) {
      ++taken;
      taken_bytes += transaction.operations.size() * each_bytes;
    }
  };
  fill(large, sizeof(Operation) + 512 * sizeof(Vec3f));
  fill(many, sizeof(Operation));
  EXPECT_LE(taken_bytes, SceneService::kMaxQueued_bytes);
  EXPECT_GT(taken_bytes, SceneService::kMaxQueued_bytes / 2);
  release.set_value();
  submit(3, edit(add("b")));
  EXPECT_EQ(answered, taken);
}

TEST_F(SceneServiceTest, DropsEditsThatNobodyWaitsFor) {
  std::promise<void> release;
  auto released = release.get_future().share();
  sceneService.start();
  ASSERT_TRUE(sceneService.submitEdit(kAlice, 1, edit(add("a")), [released](const EditOutcome&) { released.wait(); }));
  std::stop_source left;
  const auto never = [](const EditOutcome&) { ADD_FAILURE() << "nobody waits for it"; };
  for (const std::uint64_t seq : {2, 3}) {
    ASSERT_TRUE(sceneService.submitEdit(kAlice, seq, edit(add(numbered("o", seq))), never, left.get_token()));
  }
  left.request_stop();
  release.set_value();
  submit(4, edit(add("b")));
  EXPECT_EQ(sceneService.history()->version.objects().size(), 2U);
}

/// Takes minutes to build where nobody interrupts it.
const SphereSource kHugeSphere{0.1, 900};

TEST_F(SceneServiceTest, EndsWhatItBuildsWhenNobodyWaitsForItAnyMore) {
  sceneService.start();
  std::stop_source left;
  const auto never = [](const EditOutcome&) { ADD_FAILURE() << "nobody waits for it"; };
  ASSERT_TRUE(sceneService.submitEdit(kAlice, 1, edit(add("huge", {kHugeSphere})), never, left.get_token()));
  std::this_thread::sleep_for(300ms);
  left.request_stop();
  const std::clock_t began = std::clock();  // processor time: what else the machine does is left out
  submit(2, edit(add("b")));
  EXPECT_LT(std::clock() - began, 5 * CLOCKS_PER_SEC);
  EXPECT_EQ(sceneService.history()->version.objects().size(), 1U);
}

/// Why a service that gives an edit no more refuses a mesh of 480,000 triangles. It goes on with others' edits.
std::string refusalOf(const WorkLimits& most) {
  SceneMailbox mailbox;
  SceneService sceneService({.assetFolders = {}, .makePlan = {}, .mostOfEdit = most, .log = {}}, mailbox);
  sceneService.start();
  std::promise<EditOutcome> decided;
  const auto reply = [&](const EditOutcome& outcome) { decided.set_value(outcome); };
  EXPECT_TRUE(sceneService.submitEdit(kBob, 1, edit(add("large", {SphereSource{0.1, 200}})), reply));
  auto outcome = decided.get_future();
  EXPECT_EQ(outcome.wait_for(kPatience), std::future_status::ready);
  EXPECT_TRUE(std::holds_alternative<Accepted>(submitTo(sceneService, 1, edit(add("a")))));
  EXPECT_EQ(sceneService.history()->version.objects().size(), 1U);
  const EditOutcome decision = outcome.get();
  const auto* error = std::get_if<Error>(&decision);
  return error == nullptr ? "" : error->text();
}

TEST(SceneService, EndsAnEditThatTakesMoreThanOneMay) {
  EXPECT_THAT(refusalOf({.time_s = 0.05, .memory_bytes = 2e9}),
              HasSubstr("operations: were ended when they had taken"));
  EXPECT_THAT(refusalOf({.time_s = 1000, .memory_bytes = 2e7}), HasSubstr("the server gives one edit"));
}

TEST_F(SceneServiceTest, EditsPassOneThatTakesLong) {
  sceneService.start();
  std::atomic<bool> isThere = false;
  ASSERT_TRUE(
      sceneService.submitEdit(kBob, 1, edit(add("huge", {kHugeSphere})), [&](const EditOutcome&) { isThere = true; }));
  for (std::uint64_t seq = 1; seq <= 20; ++seq) {
    ASSERT_TRUE(std::holds_alternative<Accepted>(submit(seq, edit(add(numbered("o", seq))))));
  }
  EXPECT_FALSE(isThere);
  EXPECT_EQ(sceneService.history()->version.revision(), 20U);
}

TEST_F(SceneServiceTest, ShortWorkPassesLongWorkHoweverMuchOfItIsAskedFor) {
  sceneService.start();
  constexpr SessionId kOthers = 100, kMany = 2 * SceneService::kMaxWorkers;
  for (SessionId session = kOthers; session < kOthers + kMany; ++session) {
    ASSERT_TRUE(sceneService.submitEdit(session, 1, edit(add(numbered("huge", session), {kHugeSphere})),
                                        [](const EditOutcome&) { ADD_FAILURE() << "takes minutes"; }));
  }
  const auto pattern = [](double seed) {
    SetMaterial grain{named("a"), {}};
    grain.material.surface.texture = TextureEdit{
        {.family = MappedFamily{{}, {Mapping::Shape::kSphere, {}, {1, 0, 0, 0}, Vec3(1), 0.01}}, .amplitude_m = 1e-4},
        {MappedSource{ReactionDiffusionSource{.cells = 8, .resolution = 32 + static_cast<std::uint32_t>(seed)}}}};
    return edit(grain);
  };
  ASSERT_TRUE(std::holds_alternative<Accepted>(submit(1, edit(add("a")))));
  for (std::uint64_t seq = 2; seq <= 3; ++seq) {
    const EditOutcome made = submit(seq, pattern(double(seq)));  // by a worker
    ASSERT_TRUE(std::holds_alternative<Accepted>(made)) << std::get<Error>(made).text();
  }
  std::size_t waiting = 0;
  for (SessionId session = kOthers; session < kOthers + kMany; ++session) {
    const auto place = sceneService.waiting(session);
    if (!place) continue;
    EXPECT_EQ(place->clientSeq, 1U);
    waiting = std::max(waiting, place->place);
  }
  EXPECT_GE(waiting, kMany - SceneService::kMaxWorkers - 1) << "each knows its place";
}

TEST_F(SceneServiceTest, ManySmallMeshesOfOneEditAreLongWork) {
  sceneService.start();
  Transaction many;
  for (int i = 0; i < 60; ++i)
    many.operations.push_back(AddObject{numbered("o", i), {SphereSource{0.01 + 1e-5 * i, 38}}});  // 17,000 triangles
  std::atomic<bool> isThere = false;
  std::promise<void> replied;
  ASSERT_TRUE(sceneService.submitEdit(kBob, 1, many, [&](const EditOutcome& outcome) {
    EXPECT_TRUE(std::holds_alternative<Accepted>(outcome));
    isThere = true;
    replied.set_value();
  }));
  for (std::uint64_t seq = 1; seq <= 20; ++seq) submit(seq, edit(add(numbered("b", seq))));
  EXPECT_FALSE(isThere) << "others' edits pass";
  EXPECT_EQ(replied.get_future().wait_for(kPatience), std::future_status::ready);
}

TEST_F(SceneServiceTest, ASessionsEditsKeepTheirOrderWhateverTheyTake) {
  sceneService.start();
  std::vector<std::uint64_t> order;
  std::promise<void> last;
  for (std::uint64_t seq = 1; seq <= 6; ++seq) {
    const Transaction transaction = seq % 2 == 1
                                        ? edit(add(numbered("o", seq), {SphereSource{0.1, 100}}))  // 120,000 triangles
                                        : edit(moveTo(numbered("o", seq - 1), {1, 0, 0}));
    ASSERT_TRUE(sceneService.submitEdit(kAlice, seq, transaction, [&, seq](const EditOutcome& outcome) {
      EXPECT_TRUE(std::holds_alternative<Accepted>(outcome));
      order.push_back(seq);
      if (seq == 6) last.set_value();
    }));
  }
  ASSERT_EQ(last.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_THAT(order, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST_F(SceneServiceTest, PreconditionsHoldWhenAnEditTakesEffectNotWhenItIsPrepared) {
  sceneService.start();
  ASSERT_TRUE(std::holds_alternative<Accepted>(submit(1, edit(add("a")))));
  Transaction remesh = edit(RemeshObject{named("a"), {SphereSource{0.1, 200}}});  // half a million triangles
  remesh.preconditions.push_back({named("a"), 1, std::nullopt});
  std::promise<EditOutcome> decided;
  ASSERT_TRUE(sceneService.submitEdit(kBob, 1, remesh, [&](const EditOutcome& o) { decided.set_value(o); }));
  ASSERT_TRUE(std::holds_alternative<Accepted>(submit(2, edit(moveTo("a", {1, 0, 0})))));
  const EditOutcome outcome = decided.get_future().get();
  ASSERT_TRUE(std::holds_alternative<EditConflict>(outcome));
  EXPECT_EQ(std::get<EditConflict>(outcome).current.at(0)->revision, 2U);
  EXPECT_EQ(sceneService.history()->version.revision(), 2U);
}

TEST_F(SceneServiceTest, WhatIsPreparedStaysGoodWhileOthersEditTheSameObject) {
  sceneService.start();
  ASSERT_TRUE(std::holds_alternative<Accepted>(submit(1, edit(add("a")))));
  std::atomic<bool> isDecided = false;
  AddObject ball{"ball", {SphereSource{0.1, 100}}, {}, {}, MotionProperties{.mass_kg = 1}};
  ASSERT_TRUE(std::holds_alternative<Accepted>(submit(2, edit(ball))));
  SetMaterial shade{named("ball"), {}};
  shade.material.surface.shading = Shading{0.5, {}};
  ASSERT_TRUE(sceneService.submitEdit(kBob, 1, edit(shade), [&](const EditOutcome& o) {
    EXPECT_TRUE(std::holds_alternative<Accepted>(o));
    isDecided = true;
  }));
  std::uint64_t seq = 2;
  const auto end = std::chrono::steady_clock::now() + 20s;
  while (!isDecided && std::chrono::steady_clock::now() < end) {
    ++seq;
    ASSERT_TRUE(std::holds_alternative<Accepted>(submit(
        seq,
        edit(SetMaterial{named("ball"),
                         {.stiffness_N_per_m = 500.0 + double(seq % 2), .damping_Ns_per_m = {}, .surface = {}}}))));
  }
  EXPECT_TRUE(isDecided);
  EXPECT_NE(servo.look()->objects.at(1).detail, nullptr);
}

TEST_F(SceneServiceTest, WhatFollowsACancelledEditIsCarriedOut) {
  sceneService.start();
  std::stop_source left;
  const auto never = [](const EditOutcome&) { ADD_FAILURE() << "nobody waits for it"; };
  ASSERT_TRUE(sceneService.submitEdit(kAlice, 1, edit(add("huge", {kHugeSphere})), never, left.get_token()));
  std::promise<void> replied;
  ASSERT_TRUE(sceneService.submitEdit(kAlice, 2, edit(add("b")), [&](const EditOutcome&) { replied.set_value(); }));
  auto reply = replied.get_future();
  EXPECT_EQ(reply.wait_for(300ms), std::future_status::timeout) << "in its session's order";
  left.request_stop();
  EXPECT_EQ(reply.wait_for(5s), std::future_status::ready);
}

TEST_F(SceneServiceTest, SaysHowFarAnEditIs) {
  sceneService.start();
  std::vector<std::pair<WorkStage, double>> told;
  std::promise<void> replied;
  ASSERT_TRUE(sceneService.submitEdit(
      kAlice, 1, edit(add("ball", {SphereSource{0.1, 150}})), [&](const EditOutcome&) { replied.set_value(); }, {},
      [&](WorkStage stage, double share) { told.emplace_back(stage, share); }));
  ASSERT_EQ(replied.get_future().wait_for(kPatience), std::future_status::ready);
  ASSERT_GE(told.size(), 2U);
  EXPECT_EQ(told.front(), (std::pair{WorkStage::kMaking, 0.0}));
  EXPECT_EQ(told.back().first, WorkStage::kBuilding);
  EXPECT_LE(told.back().second, 1);
}

TEST_F(SceneServiceTest, StopsWhileItBuilds) {
  sceneService.start();
  ASSERT_TRUE(sceneService.submitEdit(kAlice, 1, edit(add("huge", {kHugeSphere})), [](const EditOutcome&) {}));
  std::this_thread::sleep_for(300ms);
  const std::clock_t began = std::clock();
  sceneService.stop();
  EXPECT_LT(std::clock() - began, 5 * CLOCKS_PER_SEC);
}

TEST_F(SceneServiceTest, StopsWhileItBuildsWhatWasUploaded) {
  const TriMesh mesh = makeSphere(0.1, 500).value();
  sceneService.start();
  ASSERT_TRUE(sceneService.submitAsset(kAlice, {AssetKind::kMesh, hashOf(mesh)}, encodeMesh(mesh), [](auto) {}));
  std::this_thread::sleep_for(300ms);
  const std::clock_t began = std::clock();
  sceneService.stop();
  EXPECT_LT(std::clock() - began, 1.5 * CLOCKS_PER_SEC);
}

TEST(SceneService, GoesOnWhenAServoSceneCannotBeMadeAndMakesItLater) {
  std::atomic<int> failures{0};
  const auto onServoScene = [&](const ServoScene& scene, const std::vector<ServoObjectSource>&) {
    if (scene.revision == 2 && failures-- > 0) throw std::bad_alloc();
  };
  SceneMailbox mailbox;
  Servo servo(mailbox);
  std::vector<std::string> logged;
  SceneService sceneService({.assetFolders = {},
                             .makePlan = {},
                             .log = [&](const std::string& line) { logged.push_back(line); },
                             .onServoScene = onServoScene},
                            mailbox);
  ASSERT_TRUE(sceneService.loadStartScene(edit(add("a"))));
  failures = 2;
  sceneService.start();
  EXPECT_TRUE(std::holds_alternative<Accepted>(submitTo(sceneService, 1, edit(remove("a")))));
  EXPECT_EQ(servo.look()->revision, 1U) << "the scene before";
  EXPECT_TRUE(servo.waitFor([](const ServoScene& scene) { return scene.revision == 2; }));
  EXPECT_LE(servo.look()->objects.size(), 1U) << "leaving once";
  sceneService.stop();
  EXPECT_THAT(logged, ::testing::Contains(HasSubstr("revision 2 is not felt yet")).Times(1));
}

TEST(ServoSceneBuilder, CountsNoSceneThatCouldNotBeHandedOver) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  bool mayPlan = true, mayTake = true;
  ServoSceneBuilder maker([&](const ServoScene&) {
    if (!mayPlan) throw std::bad_alloc();
    return std::make_shared<const ExplorationPlan>();
  });
  const auto make = [&] {
    return maker.make(sequencer, 0, kNewPlan, [&](const ServoScene&, const std::vector<ServoObjectSource>&) {
      if (!mayTake) throw std::bad_alloc();
    });
  };
  const auto shade = [&](std::uint64_t seq, double crease_rad) {
    sequencer.submit(kAlice, seq, edit(setSurface({.shading = Shading{crease_rad, {}}})));
  };
  sequencer.submit(kAlice, 1, edit(add("a")));
  shade(2, 0.5);
  const auto first = make();
  shade(3, 0.6);
  mayPlan = false;
  EXPECT_THROW((void)make(), std::bad_alloc);
  mayPlan = true;
  mayTake = false;
  EXPECT_THROW((void)make(), std::bad_alloc);
  mayTake = true;
  shade(4, 0.5);
  const auto next = make();
  EXPECT_EQ(next->number, first->number + 1);
  EXPECT_EQ(next->objects[0].detail, first->objects[0].detail) << "as a replay makes it, of the scenes handed over";
}

TEST_F(SceneServiceTest, ManyThreadsMayEditAtOnce) {
  sceneService.start();
  std::vector<std::thread> clients;
  for (SessionId session = 1; session <= 4; ++session) {
    clients.emplace_back([this, session] {
      for (std::uint64_t i = 1; i <= 25; ++i) {
        const std::string name = numbered("o", session * 100 + i);
        EXPECT_TRUE(sceneService.submitEdit(session, i, edit(add(name)), [](const EditOutcome&) {}));
      }
    });
  }
  for (std::thread& client : clients) client.join();
  submit(1, edit(add("last")));
  EXPECT_EQ(sceneService.history()->version.revision(), 101U);
  EXPECT_EQ(sceneService.history()->version.objects().size(), 101U);
  EXPECT_TRUE(servo.waitFor([](const ServoScene& scene) { return scene.revision == 101; }));
}

TEST(SceneService, ThatIsFixedShowsWhatItIsGivenAndRefusesEdits) {
  BoxResolver resolver;
  Sequencer made(1, resolver);
  made.submit(kAlice, 1, edit(add("a")));
  SceneMailbox mailbox;
  SceneService sceneService({.assetFolders = {}, .makePlan = {}, .readOnlyReason = "it is a recording", .log = {}},
                            mailbox);
  ASSERT_TRUE(sceneService.show(made.history()->version, {}));
  sceneService.executeAll();
  EXPECT_EQ(sceneService.history()->version.revision(), 1U) << "before it runs";
  made.submit(kAlice, 2, edit(add("b")));
  std::thread player([&] { EXPECT_TRUE(sceneService.show(made.history()->version, {})); });
  sceneService.start();
  player.join();
  EXPECT_EQ(std::get<Error>(submitTo(sceneService, 1, edit(add("c")))).reason, "it is a recording");
  EXPECT_EQ(sceneService.history()->version.root(), made.history()->version.root());
  EXPECT_EQ(mailbox.newest(), nullptr) << "the servo has its scenes from elsewhere";
}

}  // namespace
}  // namespace haptics::scene_service_test
