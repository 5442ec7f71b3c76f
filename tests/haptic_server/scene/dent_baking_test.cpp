#include "haptic_server/scene/dent_baking.h"

#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "common/mesh/generators.h"
#include "haptic_server/scene/scene_service.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::dent_baking_test {
namespace {

using namespace test;

constexpr double kRadius_m = 0.05;
constexpr Softness kClay{.stiffness_N_per_m = 200, .radius_m = 0.012, .degree = 2, .return_s = 0, .plastic = 1};
const DeformationProperties kPlastic{.softness = kClay, .lattice = {}};

ObjectAssets sphereIn(AssetStore& store) {
  ObjectAssets assets;
  assets.mesh = store.intern(makeSphere(kRadius_m, 24).value());
  return assets;
}

Dent down(double depth_m, double x = 0) {
  return {Vec3f(Vec3(x, 0, std::sqrt(kRadius_m * kRadius_m - x * x))), Vec3f(Vec3(0, 0, -depth_m))};
}

TEST(Residue, IsOfAbsoluteVerticesThoseOfBeforeIncluded) {
  AssetStore store;
  ObjectAssets assets = sphereIn(store);
  const std::vector<PermanentDent> dents{{4, down(0.002)}, {7, down(0.001, 0.01)}};
  const BakeResult both = bake(kPlastic, assets, dents);
  EXPECT_EQ(both.upTo, 7U);
  EXPECT_EQ(both.releasedUpTo, 0U);
  EXPECT_GT(both.residue.vertex.size(), 10U);
  EXPECT_LT(both.residue.vertex.size(), assets.mesh->mesh->vertices.size() / 4);
  for (std::uint32_t v = 0; v < assets.mesh->mesh->vertices.size(); ++v) {
    const Vec3f rest = assets.mesh->mesh->vertices[v];
    const std::vector<Dent> all{dents[0].dent, dents[1].dent};
    EXPECT_EQ(both.residue.placeOf(v).value_or(rest), dented(rest, all, tissueOf(kClay).falloff));
  }

  assets.residue = store.intern(bake(kPlastic, assets, std::span(dents).first(1)).residue);
  DeformationProperties dentedOnce = kPlastic;
  dentedOnce.residue = assets.residue->name.hash;
  EXPECT_EQ(bake(dentedOnce, assets, std::span(dents).last(1)).residue, both.residue) << "one by one or together";
}

TEST(Residue, LetsNoTriangleTurnOverHoweverOftenAPlaceIsPressed) {
  AssetStore store;
  ObjectAssets assets = sphereIn(store);
  DeformationProperties properties = kPlastic;
  const TriMesh& mesh = *assets.mesh->mesh;
  bool refusedOnce = false;
  for (std::uint64_t i = 1; i <= 40; ++i) {
    const PermanentDent dent{i, down(0.0015, 0.002 * double(i % 3))};
    const BakeResult taken = bake(properties, assets, {&dent, 1});
    EXPECT_NE(taken.upTo == i, taken.releasedUpTo == i);
    refusedOnce = refusedOnce || taken.releasedUpTo == i;
    if (taken.upTo == 0) continue;
    assets.residue = store.intern(taken.residue);
    properties.residue = assets.residue->name.hash;
    const std::vector<Vec3f> now = assets.shapeAtRest(properties);
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto normal = [&](const std::vector<Vec3f>& v) {
        return glm::cross(Vec3(v[b]) - Vec3(v[a]), Vec3(v[c]) - Vec3(v[a]));
      };
      ASSERT_GT(glm::dot(normal(mesh.vertices), normal(now)), 0) << "after dent " << i;
    }
  }
  EXPECT_TRUE(refusedOnce) << "the scene does not do what it is for";
}

TEST(Residue, HoldsNoPlaceThatNobodyWouldTake) {
  AssetStore store;
  ObjectAssets assets;
  constexpr double kLarge_m = 2000;
  assets.mesh = store.intern(makeSphere(kLarge_m, 24).value());
  DeformationProperties properties = kPlastic;
  properties.softness->radius_m = 0.3 * kLarge_m;
  const PermanentDent dent{3, {Vec3f(0, 0, kLarge_m), Vec3f(0, 0, -10)}};
  const BakeResult taken = bake(properties, assets, {&dent, 1});
  EXPECT_EQ(taken.upTo, 0U);
  EXPECT_EQ(taken.releasedUpTo, 3U);
}

MotionState motionOf(const std::vector<ObjectDent>& dents, const std::vector<std::uint64_t>& staying) {
  MotionState motion;
  motion.sceneRevision = 1000;
  motion.dentCount = dents.size();
  std::ranges::copy(dents, motion.dent.begin());
  std::ranges::copy(staying, motion.staying.begin());
  return motion;
}

TEST(Residue, IsOfTheDentsBeforeTheFirstThatMayStillChangeOfEachObject) {
  const ObjectDent a{1, down(0.001)}, b{2, down(0.002)};
  const auto staying = permanentDents(motionOf({a, b, a, b, a}, {3, 0, 5, 6, 7}), {});
  ASSERT_EQ(staying.size(), 1U);
  ASSERT_EQ(staying.at(1).size(), 3U);
  EXPECT_EQ(staying.at(1)[1].number, 5U);
  const auto rest = permanentDents(motionOf({a, a, a}, {3, 5, 7}), {{1, {.upTo = 3}}});
  ASSERT_EQ(rest.at(1).size(), 2U);
  EXPECT_EQ(rest.at(1)[0].number, 5U);
  const auto behindALoosenedOne = permanentDents(motionOf({a, a, a}, {3, 5, 7}), {{1, {.upTo = 3, .releasedUpTo = 5}}});
  EXPECT_TRUE(behindALoosenedOne.empty()) << "until that has gone back";
}

/// A room whose servo is the test.
class RoomWithClay : public ::testing::Test {
 protected:
  RoomWithClay() {
    AddObject clay{"clay", {SphereSource{kRadius_m, 24}}, {}, {}};
    clay.deformation.softness.emplace(kClay);
    EXPECT_TRUE(sceneService_.loadStartScene(edit(Operation{clay})));
    sceneService_.start();
  }
  void leave(const std::vector<ObjectDent>& dents, const std::vector<std::uint64_t>& staying) {
    const std::lock_guard lock(mutex_);
    motion_ = motionOf(dents, staying);
  }
  /// The next scene published of which this is true.
  template <class Condition>
  ServoObject waitFor(Condition condition) {
    for (int i = 0; i < 2000; ++i) {
      {
        const std::lock_guard lock(mutex_);
        if (newest_ && condition(*newest_)) return *newest_;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "no such scene comes";
    return {};
  }

  /// The room hands the servo its scene before it tells the network of the version.
  std::shared_ptr<const SceneHistory> historyAt(std::uint64_t revision) {
    for (int i = 0; i < 2000 && sceneService_.history()->version.revision() < revision; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_EQ(sceneService_.history()->version.revision(), revision);
    return sceneService_.history();
  }

  std::mutex mutex_;
  std::optional<MotionState> motion_;
  MotionState taken_;
  std::optional<ServoObject> newest_;
  SceneMailbox mailbox_;
  SceneService sceneService_{{.assetFolders = {},
                              .makePlan = {},
                              .takeMotion = [this]() -> const MotionState* {
                                const std::lock_guard lock(mutex_);
                                if (!motion_) return nullptr;
                                taken_ = *motion_;
                                motion_.reset();
                                return &taken_;
                              },
                              .log = {},
                              .onServoScene =
                                  [this](const ServoScene& scene, const std::vector<ServoObjectSource>&) {
                                    const std::lock_guard lock(mutex_);
                                    newest_ = scene.objects.front();
                                  }},
                             mailbox_};
};

TEST_F(RoomWithClay, TakesDentsInByCommitsOfItsOwn) {
  const auto rest = waitFor([](const ServoObject&) { return true; });
  leave({{1, down(0.002)}, {1, down(0.001, 0.01)}}, {3, 0});
  const auto first = waitFor([](const ServoObject& object) { return object.baked.upTo == 3; });
  EXPECT_EQ(first.baked.shape, rest.baked.shape);
  EXPECT_NE(first.surface, rest.surface);
  const auto history = historyAt(2);
  const auto residue = history->version.find(1)->deformation.residue;
  ASSERT_TRUE(residue);
  EXPECT_TRUE(sceneService_.findAsset(*residue));

  leave({{1, down(0.001, 0.01)}}, {4});
  static_cast<void>(waitFor([](const ServoObject& object) { return object.baked.upTo == 4; }));
  const auto shape = sceneService_.deformedHash(historyAt(3)->version, {});
  EXPECT_NE(shape, sceneService_.deformedHash(history->version, {})) << "of the version before the second";
}

TEST_F(RoomWithClay, LeavesDentsOfAShapeThatWasEditedSince) {
  {
    const std::lock_guard lock(mutex_);
    motion_ = motionOf({{1, down(0.002)}}, {3});
    motion_->sceneRevision = 0;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_EQ(sceneService_.history()->version.revision(), 1U);
}

TEST_F(RoomWithClay, SaysSoWhenADentMayNotStay) {
  leave({{1, down(0.012)}}, {9});
  const auto object = waitFor([](const ServoObject& o) { return o.baked.releasedUpTo == 9; });
  EXPECT_EQ(object.baked.upTo, 0U);
  EXPECT_EQ(sceneService_.history()->version.revision(), 1U);
}

TEST_F(RoomWithClay, GivesAnotherShapeWhereTheResidueIsTakenAway) {
  leave({{1, down(0.002)}}, {3});
  const auto dentedOne = waitFor([](const ServoObject& object) { return object.baked.upTo == 3; });
  SetDeformation smooth{ObjectRef{ObjectId{1}}, {}};
  smooth.deformation.residue.emplace();
  ASSERT_TRUE(sceneService_.submitEdit(5, 1, edit(Operation{smooth}), [](const EditOutcome&) {}));
  const auto object = waitFor([&](const ServoObject& o) { return o.baked.shape != dentedOne.baked.shape; });
  EXPECT_EQ(object.baked.upTo, 3U) << "those dents are gone with it";
}

Operation setResidue(const ContentHash& asset) {
  SetDeformation set{ObjectRef{std::string("a")}, {}};
  set.deformation.residue = AssetSource{asset};
  return set;
}

template <class Outcome>
std::string fieldOf(const Outcome& outcome) {
  const auto* error = std::get_if<Error>(&outcome);
  return error ? error->field : "";
}

TEST(ResidueEdits, NameMovedVerticesThatAreHereAndFit) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  sequencer.submit(5, 1, edit(add("a")));
  const auto fits = resolver.store().intern(MovedVertices{{7}, {Vec3f(1)}});
  const auto beyond = resolver.store().intern(MovedVertices{{8}, {Vec3f(1)}});
  EXPECT_EQ(fieldOf(sequencer.submit(5, 2, edit(setResidue(ContentHash{})))),
            "operations[0].set_deformation.deformation.residue.asset");
  EXPECT_EQ(fieldOf(sequencer.submit(5, 2, edit(setResidue(beyond->name.hash)))),
            "operations[0].set_deformation.deformation.residue");
  EXPECT_EQ(fieldOf(sequencer.submit(5, 2, edit(setResidue(fits->name.hash)))), "");
  EXPECT_EQ(sequencer.history()->version.find(1)->assets().back().hash, fits->name.hash);
  EXPECT_EQ(sequencer.assetsOf(1).residue, fits);
}

TEST(ResidueEdits, TakeItAwayWithTheMeshAndTheLatticeThatItIsOf) {
  BoxResolver resolver;
  Sequencer sequencer(1, resolver);
  const auto moved = resolver.store().intern(MovedVertices{{7}, {Vec3f(1)}});
  Transaction fresh = edit(add("a"), setResidue(moved->name.hash));
  sequencer.submit(5, 1, fresh);
  const auto residue = [&] { return sequencer.history()->version.find("a")->deformation.residue; };
  ASSERT_TRUE(residue());
  sequencer.submit(5, 2,
                   edit(Operation{SetDeformation{named("a"), {.softness = std::optional<Softness>{}, .lattice = {}}}}));
  EXPECT_TRUE(residue()) << "a rigid object keeps its shape";
  sequencer.submit(5, 3, edit(setResidue(moved->name.hash), Operation{RemeshObject{named("a"), box()}}));
  EXPECT_FALSE(residue()) << "overruled";
  sequencer.submit(5, 4, edit(Operation{RemeshObject{named("a"), box(0.2)}}, setResidue(moved->name.hash)));
  EXPECT_TRUE(residue());
  sequencer.submit(5, 5,
                   edit(Operation{SetDeformation{named("a"), {.softness = {}, .lattice = std::optional<Lattice>{}}}}));
  EXPECT_FALSE(residue());
}

}  // namespace
}  // namespace haptics::dent_baking_test
