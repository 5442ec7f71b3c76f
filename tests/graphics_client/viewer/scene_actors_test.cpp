#include "graphics_client/viewer/scene_actors.h"

#include <gtest/gtest.h>
#include <vtkActorCollection.h>
#include <vtkNew.h>

#include "common/mesh/generators.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics::scene_actors_test {
namespace {

/// Objects in renderers without a window.
struct Shown : testing::Test {
  FakeMirror mirror;
  vtkNew<vtkRenderer> world, closeUp;
  SceneActors actors{world, closeUp};
  const ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 1).value(), {}, {});

  Shown() { actors.setMaxTriangles(20'000); }
  void settle() { actors.settle(mirror.view(), true); }
  [[nodiscard]] int inCloseUp() { return closeUp->GetActors()->GetNumberOfItems(); }

  static SurfaceProperties rough(double wavelength_m, double mu) {
    SurfaceProperties surface;
    surface.friction = Friction{.mu_static = mu,
                                .mu_dynamic = mu,
                                .variation = 0.5,
                                .over = FieldFamily(NoiseFamily{.wavelength_m = wavelength_m})};
    return surface;
  }
  static SurfaceProperties imaged(const ContentHash& field) {
    SurfaceProperties surface;
    surface.texture =
        Texture{.family = MappedFamily{.field = field, .mapping = {.tile_m = 0.02}}, .amplitude_m = 0.0005};
    return surface;
  }
};

TEST_F(Shown, ComeAndGoWithTheScene) {
  settle();
  EXPECT_EQ(inCloseUp(), 1);
  EXPECT_FALSE(actors.outline().empty());
  EXPECT_EQ(actors.boxes().at(0).name, "box");
  const MirrorView empty;
  actors.settle(empty, true);
  EXPECT_EQ(inCloseUp(), 0);
  EXPECT_TRUE(actors.outline().empty());
}

TEST_F(Shown, AreWhereTheServoHasThemWithoutMovingTheFloor) {
  mirror.setMotion(box, MotionProperties{.mass_kg = 1});
  settle();
  const double grid_m = actors.gridSpacing_m();
  const Vec3 before = actors.boxes().at(0).corners[0];
  mirror.view().bodies[box] = {box, Pose{Quat(1, 0, 0, 0), Vec3(5, 0, 0)}};
  EXPECT_FALSE(actors.update(mirror.view(), true));
  EXPECT_EQ(actors.boxes().at(0).corners[0], before + Vec3(5, 0, 0));
  EXPECT_EQ(actors.gridSpacing_m(), grid_m);
}

TEST_F(Shown, AreHiddenByTheirNames) {
  mirror.add("other", makeBox({0.1, 0.05, 0.1}, 1).value(), {}, {});
  settle();
  const auto visible = [&] {
    actors.showFor({1, 1, 1}, {1, 1, 1});
    vtkActorCollection* all = world->GetActors();
    vtkCollectionSimpleIterator at;
    all->InitTraversal(at);
    int count = 0;
    while (vtkActor* actor = all->GetNextActor(at)) count += actor->GetVisibility();
    return count;
  };
  const int both = visible();
  actors.hide({"box", "absent"});
  const int one = visible();
  EXPECT_EQ(actors.boxes().size(), 1U);
  EXPECT_EQ(actors.boxes().at(0).name, "other");
  actors.setEdges(true);
  actors.setEdges(false);
  mirror.setSurface(box, rough(0.02, 0.2));
  settle();
  EXPECT_EQ(visible(), one) << "also with another render mesh";
  actors.hide({"box", "other"});
  const int none = visible();
  EXPECT_EQ(both - one, 2) << "with its shadow";
  EXPECT_EQ(one - none, 2);
  actors.hide({});
  mirror.setSurface(box, {});
  settle();
  EXPECT_EQ(visible(), both);
}

TEST_F(Shown, KeepTheirLookUntilTheNextOneIsMade) {
  settle();
  mirror.setSurface(box, imaged(ContentHash{}));  // the field is still on its way
  settle();
  EXPECT_EQ(inCloseUp(), 1);
  mirror.view().fields[ContentHash{}] =
      std::make_shared<const SampledField>(SampledField::make(2, 2, {0, 1, 1, 0}).value());
  settle();
  EXPECT_GE(inCloseUp(), 6);  // parts for each side of the box
}

TEST_F(Shown, AwaitTheFieldsOfAllOfTheirLayers) {
  settle();
  const ContentHash one{{1}}, two{{2}};
  const auto layer = [](const ContentHash& field) {
    return FieldLayer{1, MappedFamily{.field = field, .mapping = {.tile_m = 0.02}}};
  };
  SurfaceProperties surface;
  surface.texture = Texture{.family = LayeredFamily{LayeredFamily::Combination::kSum, {layer(one), layer(two)}},
                            .amplitude_m = 0.0005};
  surface.friction = Friction{.mu_static = 1, .dynamicOver = PerVertexScale{ContentHash{{3}}}};    // is not drawn
  surface.stiffnessOver = surface.softnessOver = SurfaceMap{0, PerVertexScale{ContentHash{{4}}}};  // likewise
  mirror.setSurface(box, surface);
  const auto samples = std::make_shared<const SampledField>(SampledField::make(2, 2, {0, 1, 1, 0}).value());
  mirror.view().fields[one] = samples;
  settle();
  EXPECT_EQ(inCloseUp(), 1);
  mirror.view().fields[two] = samples;
  settle();
  EXPECT_GE(inCloseUp(), 6);
}

TEST_F(Shown, AwaitWhatIsGrownOnThem) {
  settle();
  const ContentHash points{{5}};
  SurfaceProperties surface;
  surface.texture = Texture{.family = GrownFamily{points}, .amplitude_m = 0.01};
  mirror.setSurface(box, surface);
  settle();
  EXPECT_EQ(inCloseUp(), 1);
  mirror.view().pointFields[points] =
      std::make_shared<const PointField>(PointField::make(0.005F, {{{0.05F, 0, 0}, 1}}).value());
  settle();
  EXPECT_GE(inCloseUp(), 6);
}

TEST_F(Shown, HaveTheFrictionColorsOfAllOfThem) {
  settle();
  EXPECT_FALSE(actors.frictionRange());
  const ObjectId other = mirror.add("other", makeBox({0.1, 0.05, 0.1}, 1).value(), {}, {});
  mirror.setSurface(box, rough(0.02, 0.2));
  settle();
  const double alone = actors.frictionRange().value().most;
  mirror.setSurface(other, rough(0.02, 1.0));
  settle();
  EXPECT_LT(alone, 0.4);
  EXPECT_GT(actors.frictionRange()->most, 1.0);
  EXPECT_LT(actors.frictionRange()->least, 0.2);
  mirror.setSurface(box, {});
  mirror.setSurface(other, {});
  settle();
  EXPECT_FALSE(actors.frictionRange());
}

TEST_F(Shown, TellWhetherPitsAreFeltAsBumps) {
  SurfaceProperties surface;
  surface.texture = Texture{.family = NoiseFamily{.wavelength_m = 0.02}, .amplitude_m = 0.0005};
  for (const bool literal : {false, true}) {
    surface.texture->literal = literal;
    mirror.setSurface(box, surface);
    settle();
    EXPECT_EQ(actors.anyPitsFeltAsBumps(), literal);
  }
}

TEST_F(Shown, TellWhatIsDrawnCoarserThanItIsFelt) {
  mirror.setSurface(box, rough(0.02, 0.5));
  settle();
  EXPECT_FALSE(actors.coarsestDetail());
  mirror.setSurface(box, rough(0.0005, 0.5));
  settle();
  ASSERT_TRUE(actors.coarsestDetail());
  EXPECT_EQ(actors.coarsestDetail()->object, "box");
  EXPECT_GT(actors.coarsestDetail()->edge_m, actors.coarsestDetail()->detail_m / 4);
  actors.setMaxTriangles(2'000'000);
  settle();
  EXPECT_LT(actors.coarsestDetail().value_or(CoarseDetail{}).edge_m, 0.001);
}

}  // namespace
}  // namespace haptics::scene_actors_test
