#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/deform/free_form.h"
#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"
#include "common/surface/makers/grown_reaction_diffusion.h"
#include "common/surface/point_field_asset.h"
#include "haptic_server/engine/geometry/enclosure.h"
#include "haptic_server/scene/field_library.h"
#include "haptic_server/scene/mesh_library.h"
#include "haptic_server/scene/object_assets.h"
#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::meshes_test {
namespace {

using namespace test;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

constexpr double kStiffness_N_per_m = 800;
constexpr const char* kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// An asset folder with tetrahedron.obj in it, and secret.obj outside of it.
class MeshLibraryTest : public ::testing::Test {
 protected:
  MeshLibraryTest() {
    fs::create_directories(root / "assets" / "sub");
    write("assets/tetrahedron.obj");
    write("secret.obj");
  }

  void write(const std::string& path, const std::string& text = kTetrahedron) { std::ofstream(root / path) << text; }
  Error refusedFile(const std::string& path) {
    const auto outcome = library.resolve(file(path), kStiffness_N_per_m);
    EXPECT_FALSE(outcome) << path;
    return outcome ? Error{} : outcome.error();
  }

  const TemporaryFolder folder;
  const fs::path root = folder.path();
  AssetStore store;
  const AssetFolders folders{{root / "missing", root / "assets"}};
  MeshLibrary library{folders, store};
};

TEST_F(MeshLibraryTest, ReadsAFileBelowAnAssetFolderAndReportsIt) {
  const auto mesh = library.resolve(file("tetrahedron.obj"), kStiffness_N_per_m);
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->asset->mesh->triangles.size(), 4U);
  EXPECT_THAT(mesh->report, HasSubstr("tetrahedron.obj"));
}

TEST_F(MeshLibraryTest, RefusesEveryWayOutOfTheAssetFolder) {
  fs::create_symlink(root / "secret.obj", root / "assets" / "link.obj");
  fs::create_directory_symlink(root, root / "assets" / "up");
  for (const std::string& path :
       {std::string("../secret.obj"), std::string("sub/../../secret.obj"), (root / "secret.obj").string(),
        std::string("link.obj"), std::string("up/secret.obj"), std::string(), std::string("."), std::string("sub"),
        std::string("nothing.obj"), std::string("tetrahedron.obj\0x", 17)}) {
    EXPECT_EQ(refusedFile(path).field, "file");
  }
}

TEST_F(MeshLibraryTest, FollowsALinkThatStaysInside) {
  fs::create_symlink(root / "assets" / "tetrahedron.obj", root / "assets" / "sub" / "link.obj");
  EXPECT_TRUE(library.resolve(file("sub/link.obj"), kStiffness_N_per_m));
}

TEST_F(MeshLibraryTest, ReadsAFileOnceWhileItsMeshIsInUse) {
  auto first = library.resolve(file("tetrahedron.obj"), kStiffness_N_per_m).value();
  const auto written = fs::last_write_time(root / "assets/tetrahedron.obj");
  const auto size = fs::file_size(root / "assets/tetrahedron.obj");
  write("assets/tetrahedron.obj", std::string(size, ' '));  // not a mesh any more, but looks unchanged
  fs::last_write_time(root / "assets/tetrahedron.obj", written);
  EXPECT_EQ(library.resolve(file("tetrahedron.obj"), kStiffness_N_per_m)->asset, first.asset);
  first = {};
  EXPECT_FALSE(library.resolve(file("tetrahedron.obj"), kStiffness_N_per_m));
}

TEST_F(MeshLibraryTest, SimplifiesAMeshAndSaysSo) {
  MeshSource source{TorusSource{0.06, 0.02, 128, 64}};
  const auto whole = library.resolve(source, kStiffness_N_per_m).value();
  source.simplifyError = 1;
  const auto simple = library.resolve(source, kStiffness_N_per_m).value();
  const std::size_t left = simple.asset->mesh->triangles.size();
  EXPECT_LT(left, 10'000U);
  EXPECT_THAT(simple.report, HasSubstr("simplified from 16384 triangles to " + std::to_string(left)));
  EXPECT_EQ(simple.asset, store.find(hashOf(*simple.asset->mesh))) << "named by what is left";
  EXPECT_LT(left, library.resolve(source, 4 * kStiffness_N_per_m).value().asset->mesh->triangles.size());
}

TEST_F(MeshLibraryTest, KeepsAMeshThatCannotBeSimplifiedAndSaysSo) {
  MeshSource source = file("tetrahedron.obj");
  source.simplifyError = 1;
  const auto kept = library.resolve(source, kStiffness_N_per_m).value();
  EXPECT_EQ(kept.asset->mesh->triangles.size(), 4U);
  EXPECT_THAT(kept.report, HasSubstr("not simplified: with fewer than its 4 triangles"));
  EXPECT_EQ(library.resolve(source, kStiffness_N_per_m)->asset, kept.asset);
}

TEST_F(MeshLibraryTest, ReadsAFileAgainThatChangedOrIsScaledOtherwise) {
  const auto first = library.resolve(file("tetrahedron.obj"), kStiffness_N_per_m).value();
  MeshSource millimetres = file("tetrahedron.obj");
  millimetres.unit_m = 0.001;
  EXPECT_NE(library.resolve(millimetres, kStiffness_N_per_m)->asset->name.hash, first.asset->name.hash);
  write("assets/tetrahedron.obj", std::string(kTetrahedron) + "f 1 2 3\n");
  EXPECT_NE(library.resolve(file("tetrahedron.obj"), kStiffness_N_per_m)->asset->name.hash, first.asset->name.hash);
}

TEST_F(MeshLibraryTest, ReadsAFileAgainWhoseIncludesChanged) {
  write("assets/outer.iv", "#Inventor V2.1 ascii\nFile { name \"inner.iv\" }\n");
  const auto box = [](int size) { return "#Inventor V2.1 ascii\nCube { width " + std::to_string(size) + " }\n"; };
  write("assets/inner.iv", box(1));
  const auto first = library.resolve(file("outer.iv"), kStiffness_N_per_m);
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_EQ(library.resolve(file("outer.iv"), kStiffness_N_per_m)->asset, first->asset);
  write("assets/inner.iv", box(10));
  EXPECT_NE(library.resolve(file("outer.iv"), kStiffness_N_per_m)->asset->name.hash, first->asset->name.hash);
}

TEST_F(MeshLibraryTest, NamesTheOptionThatAFileDoesNotTake) {
  MeshSource source = file("tetrahedron.obj");
  source.part = PartName("lid");
  const auto refused = library.resolve(source, kStiffness_N_per_m);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "part");
}

TEST_F(MeshLibraryTest, AFileThatIsNoMeshIsNamed) {
  write("assets/bad.obj", "v 0 0 nan\n");
  const Error error = refusedFile("bad.obj");
  EXPECT_EQ(error.field, "file");
  EXPECT_THAT(error.reason, HasSubstr("bad.obj"));
}

TEST_F(MeshLibraryTest, DoesNotTellWhereItsFilesLie) {
  write("assets/bad.obj", "v 0 0 nan\n");
  fs::create_symlink(root / "secret.obj", root / "assets" / "leak.obj");
  for (const auto& path : {"bad.obj", "nothing.obj", "sub", "leak.obj", "sub/../bad.obj"}) {
    EXPECT_THAT(refusedFile(path).text(), Not(HasSubstr(root.filename().string()))) << path;
  }
  EXPECT_THAT(refusedFile("bad.obj").reason, StartsWith("bad.obj: "));
}

TEST_F(MeshLibraryTest, NamesTheBadArgumentOfAGenerator) {
  EXPECT_EQ(library.resolve({BoxSource{Vec3(1), 0}}, kStiffness_N_per_m).error().field.rfind("box.", 0), 0U);
  EXPECT_EQ(library.resolve({SphereSource{-1, 8}}, kStiffness_N_per_m).error().field, "sphere.radius_m");
  EXPECT_EQ(library.resolve({CylinderSource{0.1, 0, 8}}, kStiffness_N_per_m).error().field, "cylinder.height_m");
  EXPECT_EQ(library.resolve({TorusSource{0.1, 0.2, 8, 8}}, kStiffness_N_per_m).error().field.rfind("torus.", 0), 0U);
  MeshSource scaled = box();
  scaled.largestExtent_m = 1;
  EXPECT_EQ(library.resolve(scaled, kStiffness_N_per_m).error().field, "largest_extent_m");
  scaled = box();
  scaled.unit_m = 0.001;
  EXPECT_EQ(library.resolve(scaled, kStiffness_N_per_m).error().field, "unit_m");
}

TEST_F(MeshLibraryTest, FindsAnAssetOnlyWhileSomeoneHoldsIt) {
  auto asset = store.intern(makeBox(Vec3(1), 1).value());
  const MeshSource source{AssetSource{asset->name.hash}};
  EXPECT_EQ(library.resolve(source, kStiffness_N_per_m)->asset, asset);
  asset = nullptr;
  EXPECT_EQ(library.resolve(source, kStiffness_N_per_m).error().field, "asset");
}

/// As above, with an image from the demo's own scenes.
class FieldLibraryTest : public MeshLibraryTest {
 protected:
  FieldLibraryTest() { fs::copy_file(fs::path(SCENES_FOLDER) / "sprinkles.png", root / "assets" / "sprinkles.png"); }
  FieldLibrary fields{folders, store};
};

TEST_F(FieldLibraryTest, ReadsAnImageOnceWhileItsFieldIsInUse) {
  const auto first = fields.resolve(FieldSource{FileSource{"sprinkles.png"}});
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_EQ(first->asset->field->width(), 256U);
  EXPECT_THAT(first->report, HasSubstr("sprinkles.png: 256 x 256 samples"));
  EXPECT_EQ(first->asset->name, (AssetName{AssetKind::kScalarField, hashOf(*first->asset->field)}));
  EXPECT_EQ(fields.resolve(FieldSource{FileSource{"sprinkles.png"}})->asset, first->asset);
}

TEST_F(FieldLibraryTest, ComputesARecipeOnceWhileItsFieldIsInUse) {
  const SpotNoiseSource recipe{.cells = 4, .resolution = 32};
  const auto first = fields.resolve(FieldSource{recipe});
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_EQ(fields.resolve(FieldSource{recipe})->asset, first->asset);
  SpotNoiseSource other = recipe;
  other.seed = 2;
  EXPECT_NE(fields.resolve(FieldSource{other})->asset->name, first->asset->name);
  EXPECT_EQ(fields.resolve(FieldSource{AssetSource{first->asset->name.hash}})->asset, first->asset);
}

TEST_F(FieldLibraryTest, GrowsAPatternOnceForEachMeshWhileItIsInUse) {
  const auto ball = store.intern(makeSphere(0.02, 8).value()), other = store.intern(makeSphere(0.021, 8).value());
  const GrownReactionDiffusionSource recipe{.wavelength_m = 0.01};
  const auto first = fields.resolve(PointFieldSource{recipe}, *ball);
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_EQ(first->asset->name,
            (AssetName{AssetKind::kPointField, hashOf(grownReactionDiffusion(*ball->mesh, recipe).value())}));
  EXPECT_THAT(first->report, HasSubstr(std::to_string(first->asset->field->samples().size()) + " samples"));
  EXPECT_EQ(fields.resolve(PointFieldSource{recipe}, *ball)->asset, first->asset);
  EXPECT_NE(fields.resolve(PointFieldSource{recipe}, *other)->asset->name, first->asset->name);
  EXPECT_EQ(fields.resolve(PointFieldSource{AssetSource{first->asset->name.hash}}, *other)->asset, first->asset);
  EXPECT_EQ(fields.resolve(PointFieldSource{AssetSource{ball->name.hash}}, *ball).error().field, "asset");
  const Error fine =
      fields.resolve(PointFieldSource{GrownReactionDiffusionSource{.wavelength_m = 1e-4}}, *ball).error();
  EXPECT_EQ(fine.field, "reaction_diffusion.wavelength_m");
}

TEST_F(FieldLibraryTest, RefusesWhatIsNoImageAndDoesNotTellWhereItLies) {
  const auto refusal = [&](const std::string& path) { return fields.resolve(FieldSource{FileSource{path}}).error(); };
  for (const auto& path : {"tetrahedron.obj", "missing.png", "../secret.obj"}) {
    EXPECT_EQ(refusal(path).field, "image") << path;
    EXPECT_THAT(refusal(path).reason, Not(HasSubstr(root.string()))) << path;
  }
  EXPECT_THAT(refusal("tetrahedron.obj").reason, HasSubstr("PNG"));
}

TEST_F(FieldLibraryTest, HoldsVertexValuesThatAreGiven) {
  const auto given = fields.resolve(VertexValuesSource{GivenValues{{1, 0.5F, 0}}});
  ASSERT_TRUE(given);
  EXPECT_EQ(*given->asset->values, (std::vector<float>{1, 0.5F, 0}));
  const ContentHash hash = given->asset->name.hash;
  EXPECT_EQ(fields.resolve(VertexValuesSource{AssetSource{hash}})->asset, given->asset);
  EXPECT_EQ(fields.resolve(FieldSource{AssetSource{hash}}).error().field, "asset") << "they are no field";
}

TEST(AssetStore, TakesEveryKindUnderItsOwnHashOnly) {
  AssetStore store;
  const SampledField field = BoxResolver::smallField(1);
  const auto taken = store.internEncoded({AssetKind::kScalarField, hashOf(field)}, encodeField(field));
  ASSERT_TRUE(taken) << taken.error().text();
  EXPECT_EQ(as<FieldAsset>(*taken)->field->height(), 2U);
  EXPECT_EQ(as<MeshAsset>(*taken), nullptr);
  const std::vector<float> values{1, 2};
  EXPECT_TRUE(store.internEncoded({AssetKind::kVertexValues, hashOf(values)}, encodeVertexValues(values)));
  EXPECT_EQ(store.internEncoded({AssetKind::kMesh, hashOf(values)}, encodeVertexValues(values)).error().field, "data");
  const PointField points = BoxResolver::grownOn(makeBox(Vec3(1), 1).value(), 1).value();
  const auto held = store.internEncoded({AssetKind::kPointField, hashOf(points)}, encodePointField(points));
  ASSERT_TRUE(held);
  EXPECT_EQ(as<PointFieldAsset>(*held)->field->samples().size(), 8U);
  EXPECT_EQ(store.intern(points), *held);
}

TEST(AssetStore, BuildsEqualMeshesOnce) {
  AssetStore store;
  const auto first = store.intern(makeBox(Vec3(1), 2).value());
  EXPECT_EQ(store.intern(makeBox(Vec3(1), 2).value()), first);
  EXPECT_NE(store.intern(makeBox(Vec3(1), 3).value()), first);
  EXPECT_EQ(first->name.hash, hashOf(*first->mesh));
  EXPECT_EQ(first->bytes().copy(), encodeMesh(*first->mesh));
  EXPECT_NE(first->surface, nullptr);
}

TEST(AssetStore, TakesBytesOnlyUnderTheirOwnHash) {
  AssetStore store;
  const TriMesh mesh = makeBox(Vec3(1), 2).value();
  const std::string bytes = encodeMesh(mesh);
  const auto taken = store.internEncoded({AssetKind::kMesh, hashOf(mesh)}, bytes);
  ASSERT_TRUE(taken);
  EXPECT_EQ(*as<MeshAsset>(*taken)->mesh, mesh);

  const ContentHash other = hashOf(makeBox(Vec3(2), 2).value());
  EXPECT_EQ(store.internEncoded({AssetKind::kMesh, other}, bytes).error().field, "hash");
  const std::string cut = bytes.substr(0, bytes.size() - 1);
  const ContentHash ofCut = Hasher().add(std::as_bytes(std::span(cut))).finish();
  EXPECT_EQ(store.internEncoded({AssetKind::kMesh, ofCut}, cut).error().field, "data");
}

TEST(MirroredMesh, IsFeltFromOutsideAndSoIsWhatItComesBackTo) {
  AssetStore store;
  ObjectAssets assets;
  assets.mesh = store.intern(makeSphere(0.02, 12).value());
  const Vec3 low(-0.03), size(0.06);
  const auto shaped = [&](const glm::mat3& by) {
    DeformationProperties properties;
    properties.lattice = Lattice{low, size, {2, 2, 2}, FreeForm::atRest(low, size, {2, 2, 2})};
    for (Vec3f& point : properties.lattice->control_m) point = by * point;
    return properties;
  };
  const auto winding = [](const CollisionMesh& surface) {
    Allowance endless;
    return windingNumber(surface, Vec3(0.001), endless);
  };
  std::shared_ptr<const CollisionMesh> last;
  for (const Vec3f axes : {Vec3f(-1, 1, 1), Vec3f(-1, -1, -1), Vec3f(1, 1.2, 1), Vec3f(1, 1, -1), Vec3f(-1, -1, 1)}) {
    glm::mat3 by(0);
    for (int k = 0; k < 3; ++k) by[k][k] = axes[k];
    last = assets.surfaceAtRest(shaped(by), last.get());
    EXPECT_EQ(winding(*last), 1) << axes.x << ' ' << axes.y << ' ' << axes.z;
  }
}

}  // namespace
}  // namespace haptics::meshes_test
