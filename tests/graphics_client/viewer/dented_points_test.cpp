#include "graphics_client/viewer/dented_points.h"

#include <gtest/gtest.h>
#include <vtkPointData.h>

#include <array>
#include <chrono>
#include <cmath>
#include <vector>

#include "common/mesh/generators.h"
#include "graphics_client/surface/mesh_normals.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics::dented_points_test {
namespace {

constexpr double kRadius_m = 0.05;
const Falloff kFalloff(0.02, 2);

struct Drawn {
  TriMesh mesh = makeSphere(kRadius_m, 16).value();
  ShadedMesh shaded = shadeMesh(mesh, 3);
  vtkSmartPointer<vtkPolyData> data = trianglesOf(mesh.vertices, mesh.triangles, shaded.normals);
};

Vec3 pointOf(vtkPolyData* data, std::size_t i) {
  std::array<double, 3> at;
  data->GetPoint(static_cast<vtkIdType>(i), at.data());
  return {at[0], at[1], at[2]};
}

TEST(DentedPoints, AreThoseThatTheServoHasToTheBit) {
  Drawn drawn;
  DentedPoints points(drawn.data);
  points.drawIn(drawn.data);
  const std::array dents{Dent{{0, 0, 0.05F}, {0.001F, 0, -0.005F}}, Dent{{0.02F, 0, 0.045F}, {0, 0.001F, -0.003F}}};
  EXPECT_TRUE(points.follow(dents, kFalloff));
  EXPECT_FALSE(points.follow(dents, kFalloff)) << "they are there";
  int moved = 0;
  for (std::size_t i = 0; i < drawn.mesh.vertices.size(); ++i) {
    const Vec3f expected = dented(drawn.mesh.vertices[i], dents, kFalloff);
    ASSERT_EQ(pointOf(drawn.data, i), Vec3(expected));
    moved += expected != drawn.mesh.vertices[i];
  }
  EXPECT_GT(moved, 20);
  EXPECT_TRUE(points.follow({}, kFalloff));
  for (std::size_t i = 0; i < drawn.mesh.vertices.size(); ++i) {
    ASSERT_EQ(pointOf(drawn.data, i), Vec3(drawn.mesh.vertices[i]));
  }
}

TEST(DentedPoints, OpenWithTheJawsThatTheyAreOn) {
  Drawn drawn;
  DentedPoints points(drawn.data);
  points.drawIn(drawn.data);
  const JawProperties jaws{{-0.1, 0, 0}, {0, -1, 0}, {1, 0, 0}};
  EXPECT_FALSE(points.open(jaws, 0)) << "they are closed";
  EXPECT_TRUE(points.open(jaws, 0.5));
  EXPECT_FALSE(points.open(jaws, 0.5));
  for (std::size_t i = 0; i < drawn.mesh.vertices.size(); ++i) {
    const Vec3 rest(drawn.mesh.vertices[i]), now = pointOf(drawn.data, i);
    const double before = std::atan2(rest.z, rest.x + 0.1), after = std::atan2(now.z, now.x + 0.1);
    ASSERT_NEAR(after - before, rest.z > 0 ? 0.25 : -0.25, 1e-5);
    ASSERT_NEAR(std::hypot(now.z, now.x + 0.1), std::hypot(rest.z, rest.x + 0.1), 1e-7);
    ASSERT_EQ(now.y, rest.y);
  }
  EXPECT_TRUE(points.open(jaws, 0));
  for (std::size_t i = 0; i < drawn.mesh.vertices.size(); ++i) {
    ASSERT_NEAR(glm::distance(pointOf(drawn.data, i), Vec3(drawn.mesh.vertices[i])), 0, 1e-8);
  }
}

TEST(DentedPoints, RiseFromTheDentedSurfaceAlongItsNormal) {
  constexpr double kRise_m = 0.002;
  Drawn drawn;
  std::vector<Vec3f> rises, raised;
  for (const Vec3f v : drawn.mesh.vertices) {
    rises.emplace_back(glm::normalize(Vec3(v)) * kRise_m);
    raised.push_back(v + rises.back());
  }
  drawn.data = trianglesOf(raised, drawn.mesh.triangles, drawn.shaded.normals);
  addRises(drawn.data, rises);
  DentedPoints points(drawn.data);
  points.drawIn(drawn.data);
  const std::array dents{Dent{{0, 0, 0.05F}, {0.001F, 0, -0.005F}}};
  points.follow(dents, kFalloff);
  for (std::size_t i = 0; i < raised.size(); ++i) {
    const Vec3f base = drawn.mesh.vertices[i];
    const Vec3 normal = glm::normalize(dented(VertexWithNormal{base, Vec3(rises[i])}, dents, kFalloff).normal);
    const Vec3 expected = Vec3(dented(base, dents, kFalloff)) + kRise_m * normal;
    ASSERT_LT(glm::distance(pointOf(drawn.data, i), expected), 1e-7);
  }
}

TEST(DentedPoints, TurnTheirNormalsWithTheSurface) {
  Drawn drawn;
  DentedPoints points(drawn.data);
  points.drawIn(drawn.data);
  const std::array dents{Dent{{0, 0, 0.05F}, {0, 0, -0.006F}}};
  points.follow(dents, kFalloff);
  TriMesh now = drawn.mesh;
  for (Vec3f& v : now.vertices) v = dented(v, dents, kFalloff);
  const ShadedMesh expected = shadeMesh(now, 3);
  vtkDataArray* normals = drawn.data->GetPointData()->GetNormals();
  double most = 0, turned = 0;
  for (std::size_t i = 0; i < now.vertices.size(); ++i) {
    std::array<double, 3> n;
    normals->GetTuple(static_cast<vtkIdType>(i), n.data());
    most = std::max(most, std::acos(std::min(1.0, glm::dot(Vec3(n[0], n[1], n[2]), Vec3(expected.normals[i])))));
    turned = std::max(turned, glm::distance(Vec3(drawn.shaded.normals[i]), Vec3(n[0], n[1], n[2])));
  }
  EXPECT_GT(turned, 0.2);
  EXPECT_LT(most, 0.12) << "radians: of facets against the smooth surface";
}

}  // namespace
}  // namespace haptics::dented_points_test
