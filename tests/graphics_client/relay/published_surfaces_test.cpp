#include "graphics_client/relay/published_surfaces.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"

namespace haptics::published_surfaces_test {
namespace {

using namespace std::chrono_literals;

ObjectRecord textured(ObjectId id, double wavelength_m) {
  ObjectRecord object;
  object.id = id;
  object.name = "object " + std::to_string(id);
  object.mesh = hashOf(makeSphere(0.05, 16).value());
  object.material.surface.texture =
      Texture{.family = FourierFamily{{FourierTerm{.direction = {1, 0, 0}, .wavelength_m = wavelength_m}}},
              .amplitude_m = 0.001};
  return object;
}

MirrorView viewOf(std::vector<ObjectRecord> objects) {
  MirrorView view;
  const auto ball = std::make_shared<const TriMesh>(makeSphere(0.05, 16).value());
  view.meshes[hashOf(*ball)] = ball;
  view.scene = std::make_shared<const SceneVersion>(SceneVersion::fromSnapshot(1, std::move(objects)).value());
  return view;
}

ContentHash surfaceKey(const ObjectRecord& object) {
  PublishedSurfaces surfaces;
  surfaces.want(viewOf({object}));
  return *surfaces.keys().begin();
}

/// All that are made within a while.
std::vector<PublishedSurfaces::Surface> madeBy(PublishedSurfaces& surfaces, std::size_t count) {
  std::vector<PublishedSurfaces::Surface> made;
  for (int i = 0; i < 1000 && made.size() < count; ++i) {
    if (auto one = surfaces.takeMade()) made.push_back(*std::move(one));
    std::this_thread::sleep_for(5ms);
  }
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(surfaces.takeMade());
    std::this_thread::sleep_for(5ms);
  }
  return made;
}

TEST(PublishedSurfaces, AreNamedByWhatTheyAreDrawnFromAlone) {
  const ObjectRecord object = textured(1, 0.01);
  ObjectRecord other = textured(2, 0.01);
  other.pose.position = {1, 2, 3};
  other.revision = 7;
  other.material.color = {1, 0, 0};
  other.material.surface.friction = Friction{.mu_static = 1, .mu_dynamic = 0.5};
  other.motion = MotionProperties{.mass_kg = 1};
  other.deformation.softness = Softness{100, 0.01};
  EXPECT_EQ(surfaceKey(object), surfaceKey(other));
  other.material.surface.shading = Shading{.crease_rad = 1, .creases = {}};
  EXPECT_NE(surfaceKey(object), surfaceKey(other));
  EXPECT_NE(surfaceKey(object), surfaceKey(textured(1, 0.02)));
}

TEST(PublishedSurfaces, AreMadeOnceForObjectsThatLookTheSame) {
  PublishedSurfaces surfaces;
  const MirrorView view = viewOf({textured(1, 0.01), textured(2, 0.01), textured(3, 0.02)});
  surfaces.want(view);
  EXPECT_EQ(surfaces.keys().size(), 2U);
  EXPECT_EQ(madeBy(surfaces, 2).size(), 2U);
  surfaces.want(view);
  EXPECT_EQ(madeBy(surfaces, 0).size(), 0U);
}

TEST(PublishedSurfaces, AreMadeAnewForAnObjectThatComesBack) {
  PublishedSurfaces surfaces;
  const MirrorView with = viewOf({textured(1, 0.01)}), without = viewOf({});
  for (int i = 0; i < 2; ++i) {
    surfaces.want(with);
    EXPECT_EQ(madeBy(surfaces, 1).size(), 1U);
    surfaces.want(without);
  }
}

TEST(PublishedSurfaces, WaitForWhatTheyAreMadeOf) {
  PublishedSurfaces surfaces;
  MirrorView view = viewOf({textured(1, 0.01)});
  const auto meshes = std::exchange(view.meshes, {});
  surfaces.want(view);
  EXPECT_EQ(surfaces.keys().size(), 1U);
  EXPECT_TRUE(madeBy(surfaces, 0).empty());
  view.meshes = meshes;
  surfaces.want(view);
  EXPECT_EQ(madeBy(surfaces, 1).size(), 1U);
}

TEST(PublishedSurfaces, HoldPointsTrianglesAndHeights) {
  const DisplayedSurface surface{
      .points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}, .heights = {0, 0.5F, 1}};
  const std::string bytes = encodeSurface(surface);
  ASSERT_EQ(bytes.size(), 24U + 3 * 12 + 12 + 3);
  EXPECT_EQ(bytes.substr(0, 4), "HSRF");
  std::uint64_t counts[2];
  std::memcpy(counts, bytes.data() + 8, sizeof counts);
  EXPECT_EQ(counts[0], 3U);
  EXPECT_EQ(counts[1], 1U);
  EXPECT_EQ(bytes.substr(bytes.size() - 3), std::string("\0\x80\xff", 3));
}

}  // namespace
}  // namespace haptics::published_surfaces_test
