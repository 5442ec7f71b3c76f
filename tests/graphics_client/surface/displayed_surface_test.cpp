#include "graphics_client/surface/displayed_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mesh/generators.h"
#include "common/surface/make_field.h"

namespace haptics::displayed_surface_test {
namespace {

constexpr std::size_t kPlenty = 1'000'000;
constexpr double kWave_m = 0.01, kAmplitude_m = 0.0005;

FieldFamily gratingAlongX(double wavelength_m = kWave_m) {
  return FourierFamily{{FourierTerm{.amplitude = 1, .direction = {1, 0, 0}, .wavelength_m = wavelength_m}}};
}

std::shared_ptr<const ScalarField> fieldOf(const FieldFamily& family) {
  return makeField(family, [](const ContentHash&) { return nullptr; }).value();
}

SurfaceProperties textured(const FieldFamily& family) {
  SurfaceProperties properties;
  properties.texture = Texture{.family = family, .amplitude_m = kAmplitude_m};
  return properties;
}

/// Two triangles on z = 0, from the origin to (side, side).
TriMesh square(float side_m) {
  return {.vertices = {{0, 0, 0}, {side_m, 0, 0}, {side_m, side_m, 0}, {0, side_m, 0}},
          .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

TEST(DisplayedSurface, IsTheMeshItselfWithoutNormalsWhereItIsFeltFaceted) {
  const TriMesh mesh = makeSphere(0.05, 8).value();
  const DisplayedSurface drawn = displaySurface(mesh, {}, {}, kPlenty);
  EXPECT_EQ(drawn.points, mesh.vertices);
  EXPECT_EQ(drawn.triangles, mesh.triangles);
  EXPECT_TRUE(drawn.normals.empty());
  EXPECT_TRUE(drawn.closed);
}

TEST(DisplayedSurface, HasTheShadingsNormalsWhereItIsFeltShaded) {
  SurfaceProperties properties;
  properties.shading = Shading{.crease_rad = 0.5, .creases = {}};
  const DisplayedSurface ball = displaySurface(makeSphere(0.05, 8).value(), properties, {}, kPlenty);
  ASSERT_EQ(ball.normals.size(), ball.points.size());
  for (std::size_t i = 0; i < ball.points.size(); ++i) {
    EXPECT_GT(glm::dot(ball.normals[i], glm::normalize(ball.points[i])), 0.999F);
  }
  EXPECT_EQ(displaySurface(makeBox({1, 1, 1}, 1).value(), properties, {}, kPlenty).points.size(), 24U);
}

TEST(DisplayedSurface, RisesByTheHeightThatIsFelt) {
  const auto field = fieldOf(gratingAlongX());
  const DisplayedSurface drawn = displaySurface(square(0.05F), textured(gratingAlongX()), {.texture = field}, kPlenty);
  ASSERT_EQ(drawn.heights.size(), drawn.points.size());
  EXPECT_FALSE(drawn.filtered);
  for (std::size_t i = 0; i < drawn.points.size(); ++i) {
    const double phase = 2 * std::numbers::pi * drawn.points[i].x / kWave_m;
    EXPECT_NEAR(drawn.points[i].z, kAmplitude_m * (std::cos(phase) - field->lowest()), 1e-8);
    EXPECT_NEAR(drawn.heights[i], (std::cos(phase) - field->lowest()) / (field->highest() - field->lowest()), 1e-4);
  }
}

TEST(DisplayedSurface, HasTheFieldsOfItsMaterialWhereItIsDeformed) {
  const auto field = fieldOf(gratingAlongX());
  const TriMesh material = square(0.05F);
  TriMesh stretched = material;
  for (Vec3f& v : stretched.vertices) v.x *= 2;
  const DisplayedSurface drawn =
      displaySurface(stretched, textured(gratingAlongX()), {.texture = field, .material = material.vertices}, kPlenty);
  for (std::size_t i = 0; i < drawn.points.size(); ++i) {
    const double phase = 2 * std::numbers::pi * drawn.points[i].x / (2 * kWave_m);
    ASSERT_NEAR(drawn.points[i].z, kAmplitude_m * (std::cos(phase) - field->lowest()), 1e-8);
    const double slope = -kAmplitude_m * std::numbers::pi / kWave_m * std::sin(phase);
    const Vec3 normal = glm::normalize(Vec3(-slope, 0, 1));
    ASSERT_NEAR(glm::distance(Vec3(drawn.normals[i]), normal), 0, 1e-5);
  }
}

TEST(DisplayedSurface, SinksIntoPitsOfALiteralTexture) {
  SurfaceProperties properties = textured(gratingAlongX());
  properties.texture->literal = true;
  const DisplayedSurface drawn =
      displaySurface(square(0.05F), properties, {.texture = fieldOf(gratingAlongX())}, kPlenty);
  const auto [low, high] = std::ranges::minmax_element(drawn.points, {}, [](Vec3f p) { return p.z; });
  EXPECT_NEAR(low->z, -kAmplitude_m, 1e-7);
  EXPECT_NEAR(high->z, kAmplitude_m, 1e-7);
}

TEST(DisplayedSurface, HasTheNormalsOfTheRaisedSurface) {
  const DisplayedSurface drawn =
      displaySurface(square(0.05F), textured(gratingAlongX()), {.texture = fieldOf(gratingAlongX())}, kPlenty);
  for (std::size_t i = 0; i < drawn.points.size(); ++i) {
    const double wave = 2 * std::numbers::pi / kWave_m;
    const double slope = -kAmplitude_m * wave * std::sin(wave * drawn.points[i].x);
    const Vec3 normal = glm::normalize(Vec3(-slope, 0, 1));
    EXPECT_LT(glm::distance(Vec3(drawn.normals[i]), normal), 1e-4);
  }
}

TEST(DisplayedSurface, HasFourEdgesToTheFinestWave) {
  SurfaceProperties properties = textured(gratingAlongX());
  properties.friction = Friction{.mu_static = 0.5, .mu_dynamic = 0.3, .variation = 0.5, .over = gratingAlongX(0.002)};
  const DisplayedSurface drawn =
      displaySurface(square(0.05F), properties,
                     {.texture = fieldOf(gratingAlongX()), .friction = fieldOf(gratingAlongX(0.002))}, kPlenty);
  EXPECT_DOUBLE_EQ(drawn.finestDetail_m, 0.002);
  EXPECT_LE(drawn.longestEdge_m, 0.0005);
}

TEST(DisplayedSurface, DrawsTheMeanOfWavesThatItsTrianglesCannotCarry) {
  constexpr std::size_t kFew = 2000;
  const FieldFamily fine = gratingAlongX(0.0004);
  const auto field = fieldOf(fine);
  const DisplayedSurface drawn = displaySurface(square(0.05F), textured(fine), {.texture = field}, kFew);
  EXPECT_TRUE(drawn.filtered);
  EXPECT_LE(drawn.triangles.size(), kFew);
  double squares = 0;
  for (const Vec3f& p : drawn.points) {
    squares += std::pow(p.z / kAmplitude_m + field->lowest(), 2) / static_cast<double>(drawn.points.size());
  }
  EXPECT_LT(std::sqrt(squares), 0.25);  // 0.71 where the wave is sampled here and there
}

TEST(DisplayedSurface, MeetsItselfAtACrease) {
  constexpr double kSide_m = 0.05;
  SurfaceProperties properties = textured(NoiseFamily{.wavelength_m = 1});  // as good as constant
  const auto field = fieldOf(properties.texture->family);
  const TriMesh mesh = makeBox({kSide_m, kSide_m, kSide_m}, 1).value();
  const DisplayedSurface drawn = displaySurface(mesh, properties, {.texture = field}, kPlenty);
  ASSERT_EQ(drawn.points.size(), 24U);
  for (std::size_t i = 0; i < drawn.points.size(); ++i) {
    const auto same =
        std::ranges::count_if(drawn.points, [&](Vec3f p) { return glm::distance(p, drawn.points[i]) < 1e-6F; });
    EXPECT_EQ(same, 3);
    const double h =
        kAmplitude_m * (field->at(glm::sign(Vec3(drawn.points[i])) * (kSide_m / 2)).value - field->lowest());
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(std::abs(drawn.points[i][axis]), kSide_m / 2 + h, 0.01 * kAmplitude_m);
    }
  }
}

TEST(DisplayedSurface, CarriesFrictionOfAFieldAndOfVertices) {
  SurfaceProperties properties;
  properties.friction = Friction{.mu_static = 0.4, .mu_dynamic = 0.2, .variation = 2, .over = gratingAlongX()};
  const DisplayedSurface waved =
      displaySurface(square(0.05F), properties, {.friction = fieldOf(gratingAlongX())}, kPlenty);
  ASSERT_EQ(waved.friction.size(), waved.points.size());
  for (std::size_t i = 0; i < waved.points.size(); ++i) {
    const double f = std::cos(2 * std::numbers::pi * waved.points[i].x / kWave_m);
    EXPECT_NEAR(waved.friction[i], 0.4 * std::max(0.0, 1 + 2 * f), 1e-4);
  }
  properties.friction->over = PerVertexScale{};
  const auto scale = std::make_shared<const std::vector<float>>(std::vector<float>{0, 1, 2, 3});
  const DisplayedSurface given = displaySurface(square(0.05F), properties, {.frictionScale = scale}, kPlenty);
  ASSERT_EQ(given.friction.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(given.friction[i], 0.4 * static_cast<double>(i), 1e-6);
}

TEST(DisplayedSurface, KnowsTheMeshsEdgesWhereItsTrianglesAreFiner) {
  const DisplayedSurface drawn =
      displaySurface(square(0.05F), textured(gratingAlongX()), {.texture = fieldOf(gratingAlongX())}, kPlenty);
  double flat = 0;
  for (const auto& [a, b] : drawn.rims) {
    flat +=
        glm::distance(Vec3f(drawn.points[a].x, drawn.points[a].y, 0), Vec3f(drawn.points[b].x, drawn.points[b].y, 0));
  }
  EXPECT_NEAR(flat, 0.05 * (4 + std::sqrt(2)), 1e-5);
}

}  // namespace
}  // namespace haptics::displayed_surface_test
