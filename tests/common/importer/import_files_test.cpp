#include <libdeflate.h>
#include <sys/stat.h>

#include <chrono>
#include <random>
#include <thread>

#include "common/surface/field_asset.h"
#include "common/surface/makers/grown_reaction_diffusion.h"
#include "common/surface/makers/reaction_diffusion.h"
#include "common/surface/point_field_asset.h"
#include "file_imports.h"

namespace haptics::import_files_test {
namespace {

using namespace std::chrono_literals;
using fixture::kTetrahedronOff;
using fixture::tetrahedron;
using ::testing::HasSubstr;

using ImportFiles = fixture::FileImports;

/// Triangles across one another, each as long as all of them together: to find what crosses what takes seconds.
std::string soup() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1, 1);
  std::string obj;
  constexpr int kTriangles = 200'000;
  for (int i = 0; i < 3 * kTriangles; ++i) {
    obj += "v " + std::to_string(place(random)) + ' ' + std::to_string(place(random)) + ' ' +
           std::to_string(place(random)) + '\n';
  }
  for (int i = 1; i < 3 * kTriangles; i += 3) {
    obj += "f " + std::to_string(i) + ' ' + std::to_string(i + 1) + ' ' + std::to_string(i + 2) + '\n';
  }
  return obj;
}

TEST_F(ImportFiles, GiveTheMeshAndItsReport) {
  const auto imported = import("t.off", kTetrahedronOff, {.unit_m = 0.5});
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_EQ(imported->mesh.vertices[1], Vec3f(0, 0.5F, 0));
  EXPECT_EQ(imported->report.kept, 4U);
  EXPECT_TRUE(imported->report.repair.searched);
  EXPECT_EQ(import("t.off", kTetrahedronOff)->mesh, tetrahedron());
}

TEST_F(ImportFiles, OfACanonicalMeshAreInMetres) {
  TriMesh large = tetrahedron();
  for (Vec3f& v : large.vertices) v *= 60.0F;
  const auto bytes = encodeMesh(large);
  const auto imported = import("t.mesh", {bytes.data(), bytes.size()});
  ASSERT_TRUE(imported) << imported.error().text();
  EXPECT_TRUE(imported->report.isUnitKnown);
  EXPECT_EQ(imported->report.doubtOfUnit(), "");
  const auto part = import("t.mesh", {bytes.data(), bytes.size()}, {.part = PartName("lid")});
  EXPECT_EQ(part.error().field, "part");
}

TEST_F(ImportFiles, NameTheWrongOption) {
  EXPECT_EQ(import("t.off", kTetrahedronOff, {.unit_m = -1}).error().field, "unit_m");
}

TEST_F(ImportFiles, ThatAreNoReadableFilesAreRefused) {
  const auto missing = importMeshFile(folder_ / "missing.off", {});
  EXPECT_EQ(missing.error().field, (folder_ / "missing.off").string());
  EXPECT_THAT(missing.error().reason, HasSubstr("no such file"));
  std::filesystem::create_directory(folder_ / "folder.off");
  EXPECT_THAT(importMeshFile(folder_ / "folder.off", {}).error().reason, HasSubstr("not a regular file"));
  ASSERT_EQ(mkfifo((folder_ / "pipe.off").c_str(), 0600), 0);
  EXPECT_THAT(importMeshFile(folder_ / "pipe.off", {}).error().reason, HasSubstr("not a regular file"));
  EXPECT_THAT(refusal("empty.off", ""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("t.xyz", "1 2 3"), HasSubstr("unknown format"));
  EXPECT_THAT(refusal("t.off", "OFF\n"), HasSubstr("header"));
}

TEST_F(ImportFiles, AreUnpacked) {
  // gzip -n of kTetrahedronOff
  using namespace std::string_literals;
  const std::string packed =
      "\037\213\010\000\000\000\000\000\002\003\363\167\163\343\062\121\060\121\060\343\062\120\000\102\056\103\060\151\240\140\010\046\201\064\227\061\220\064\202\322\206\012\306\100\332\020\310\007\321\106\100\021\143\056\000\045\024\331\075\102\000\000\000"s;
  EXPECT_EQ(import("t.off.gz", packed)->mesh, tetrahedron());
  EXPECT_EQ(import("T.OFF.GZ", packed)->mesh, tetrahedron());
  EXPECT_EQ(import("t.off", packed)->mesh, tetrahedron()) << "packed under its plain name";
  for (std::size_t size = 2; size < packed.size(); size += 3) {
    EXPECT_THAT(refusal("t.off.gz", packed.substr(0, size)), HasSubstr("gzip file that is cut off"));
  }
  std::string claims = packed;
  claims.replace(claims.size() - 4, 4, "\xff\xff\xff\xff");
  EXPECT_THAT(refusal("t.off.gz", claims), HasSubstr("gzip file that is cut off"));
  const std::string zeros(10'000'000, '\0');
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> packer(
      libdeflate_alloc_compressor(6), &libdeflate_free_compressor);
  std::string much(libdeflate_gzip_compress_bound(packer.get(), zeros.size()), '\0'), many;
  much.resize(libdeflate_gzip_compress(packer.get(), zeros.data(), zeros.size(), much.data(), much.size()));
  for (int i = 0; i < 21; ++i) many += much;
  EXPECT_THAT(refusal("t.off.gz", many), HasSubstr("unpacks to more than 200000000 bytes"));
  const std::string empty = "\x1f\x8b\x08"s + std::string(6, '\0') + "\x03\x03"s + std::string(9, '\0');
  for (const std::string& parts : {empty + packed, packed + empty, packed + std::string(512, '\0')}) {
    EXPECT_EQ(import("t.off.gz", parts)->mesh, tetrahedron());
  }
  EXPECT_EQ(refusal("t.off.gz", packed + "what zcat ignores"), "loaded");
  EXPECT_THAT(refusal("t.off.gz", packed + "\x1f\x8bx"), HasSubstr("gzip file that is cut off or damaged"));
  EXPECT_THAT(refusal("t.gz", packed), HasSubstr("unknown format"));
}

TEST_F(ImportFiles, ReadImages) {
  const auto bytes = importImage(std::filesystem::path(SCENES_FOLDER) / "sprinkles.png");
  ASSERT_TRUE(bytes) << bytes.error().text();
  EXPECT_TRUE(decodeField(*bytes));
  const auto refused = importImage(write("no.png", "no image"));
  EXPECT_EQ(refused.error().field, (folder_ / "no.png").string());
  EXPECT_THAT(refused.error().reason, HasSubstr("not an image"));
}

TEST_F(ImportFiles, MakeTheSameElsewhereAsHere) {
  const MeshRecipe sphere = SphereSource{0.1, 20};
  EXPECT_EQ(makeInImporterProcess(sphere), encodeMesh(generate(sphere).value()));
  EXPECT_EQ(makeInImporterProcess(MeshRecipe(TorusSource{0.1, 0.2})).error().field, "torus.minor_radius_m");
  const ReactionDiffusionSource spots{.cells = 2, .resolution = 32};
  EXPECT_EQ(makeInImporterProcess(spots), encodeField(reactionDiffusion(spots)));
  const TriMesh ball = generate(sphere).value();
  const GrownReactionDiffusionSource grown{.wavelength_m = 0.08, .seed = 3};
  EXPECT_EQ(makeInImporterProcess(grown, ball), encodePointField(grownReactionDiffusion(ball, grown).value()));
  const Error fine = makeInImporterProcess(GrownReactionDiffusionSource{.wavelength_m = 1e-4}, ball).error();
  EXPECT_EQ(fine.field, "reaction_diffusion.wavelength_m");
  EXPECT_THAT(fine.reason, HasSubstr("give 0.01"));
}

TEST_F(ImportFiles, EndAtOnceWhenToldTo) {
  const auto file = write("soup.obj", soup());
  for (const bool beforehand : {true, false}) {
    std::stop_source stop;
    if (beforehand) stop.request_stop();
    std::jthread later([&] {
      std::this_thread::sleep_for(100ms);
      stop.request_stop();
    });
    const auto began = std::chrono::steady_clock::now();
    const auto imported = importMeshFile(file, folder_.path(), {}, stop.get_token());
    ASSERT_FALSE(imported);
    EXPECT_THAT(imported.error().reason, HasSubstr("cancelled"));
    EXPECT_LT(std::chrono::steady_clock::now() - began, 5s);
  }
}

}  // namespace
}  // namespace haptics::import_files_test
