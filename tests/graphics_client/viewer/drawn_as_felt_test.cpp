#include <gtest/gtest.h>
#include <vtkPointData.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/maths/barycentric.h"
#include "graphics_client/surface/displayed_surface.h"
#include "graphics_client/viewer/dented_points.h"
#include "graphics_client/viewer/poly_data.h"
#include "haptic_server/engine/surface/nearest_point.h"
#include "tests/haptic_server/engine/step/surface_world.h"

// What is drawn of a textured body that gives is where the servo feels it.
namespace haptics::drawn_as_felt_test {
namespace {

using namespace fixture;

constexpr double kFarthest_m = 5e-5;
constexpr double kSide_m = 0.1;
/// The upper side about the plane z = kSide_m / 2.
Vec3 rub(std::uint64_t tick) {
  const double t = 1e-3 * static_cast<double>(tick);
  const double depth_m = 0.003 + 0.002 * std::sin(5 * t);
  return {-0.02 + 0.02 * t, 0.0113 + 0.004 * std::sin(3 * t),
          kSide_m / 2 + 0.002 - (0.002 + depth_m) * std::min(1.0, 5 * t)};
}

/// The farthest that the drawn surface is from a felt point of it, over a stroke.
double farthest_m(const TriMesh& shape, const std::vector<Vec3f>& material) {
  SurfaceProperties properties;
  properties.shading = Shading{.crease_rad = 0.5, .creases = {}};
  properties.texture = acrossDepth();
  ServoObject pad = objectOf(1, surfaceOf(shape), Vec3(0), 1000);
  pad.damping_Ns_per_m = 0;
  pad.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.02, 2), 400, 0});
  pad.detail = makeSurfaceDetail(
      *pad.surface, properties, {depthField(), nullptr, nullptr, std::make_shared<const std::vector<Vec3f>>(material)});

  SurfaceFields fields{.texture = depthField()};
  fields.material = material;
  const DisplayedSurface drawn = displaySurface(shape, properties, fields, 400'000);
  const auto data = trianglesOf(drawn.points, drawn.triangles, drawn.normals);
  addRises(data, drawn.rises);
  DentedPoints points(data);
  points.drawIn(data);

  VirtualServo servo(rub, kConfig, sceneOf(1, {pad}));
  double farthest = 0;
  while (servo.tick() < 2000) {
    const TelemetrySample sample = servo.step();
    if (servo.tick() < 300 || servo.tick() % 100 != 0) continue;
    EXPECT_EQ(sample.object, 1U);
    std::vector<Dent> dents;
    for (const BodyDent& dent : servo.state().allDents()) dents.push_back(dent.dent);
    EXPECT_FALSE(dents.empty());
    points.follow(dents, pad.tissue->falloff);
    TriMesh seen{{}, drawn.triangles};
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
      std::array<double, 3> at;
      data->GetPoint(i, at.data());
      seen.vertices.emplace_back(at[0], at[1], at[2]);
    }
    Allowance endless;
    const Vec3 way = sample.ihip - rub(servo.tick() - 1);
    const Vec3 felt = sample.ihip + glm::normalize(way) * sample.height_m;
    const ClosestPoint foot = nearestPoint(*surfaceOf(seen), felt, 0.01, kNoTriangle, endless);
    farthest = std::max(farthest, foot.triangle == kNoTriangle ? 1.0 : std::sqrt(foot.squaredDistance));
  }
  return farthest;
}

/// Unit, as the renderer interpolates them in a triangle.
Vec3 drawnNormal(vtkPolyData* data, const TriangleIndices& triangle, Vec3 place) {
  std::array<Vec3, 3> corner, normal;
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<double, 3> at;
    data->GetPoint(triangle[k], at.data());
    corner[k] = Vec3(at[0], at[1], at[2]);
    data->GetPointData()->GetNormals()->GetTuple(triangle[k], at.data());
    normal[k] = Vec3(at[0], at[1], at[2]);
  }
  const Vec3 share = barycentric(corner[0], corner[1], corner[2], place);
  return glm::normalize(share[0] * normal[0] + share[1] * normal[1] + share[2] * normal[2]);
}

TEST(DrawnAsFelt, NormalsOfASoftSphere) {
  const TriMesh mesh = makeSphere(0.05, 12).value();
  SurfaceProperties properties;
  properties.shading = Shading{.crease_rad = 1, .creases = {}};
  ServoObject ball = objectOf(1, surfaceOf(mesh), Vec3(0), 1000);
  ball.damping_Ns_per_m = 0;
  ball.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.02, 2), 400, 0});
  ball.detail = makeSurfaceDetail(*ball.surface, properties, {});
  const DisplayedSurface drawn = displaySurface(mesh, properties, {}, 400'000);
  const auto data = trianglesOf(drawn.points, drawn.triangles, drawn.normals);
  DentedPoints points(data);
  points.drawIn(data);

  VirtualServo servo(aboutSphere, kConfig, sceneOf(1, {ball}));
  double squares = 0;
  int count = 0;
  while (servo.tick() < 2000) {
    const TelemetrySample sample = servo.step();
    if (servo.tick() < 400 || servo.tick() % 20 != 0) continue;
    ASSERT_EQ(sample.object, 1U);
    std::vector<Dent> dents;
    for (const BodyDent& dent : servo.state().allDents()) dents.push_back(dent.dent);
    points.follow(dents, ball.tissue->falloff);
    TriMesh seen{{}, drawn.triangles};
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
      std::array<double, 3> at;
      data->GetPoint(i, at.data());
      seen.vertices.emplace_back(at[0], at[1], at[2]);
    }
    const auto surface = surfaceOf(seen);
    Allowance endless;
    const ClosestPoint foot = nearestPoint(*surface, sample.ihip, 0.01, kNoTriangle, endless);
    ASSERT_NE(foot.triangle, kNoTriangle);
    // The dent is symmetrical about the way to the middle of the sphere.
    const Vec3 out = glm::normalize(aboutSphere(servo.tick() - 1));
    const Vec3 normal = drawnNormal(data, drawn.triangles[surface->canonical(foot.triangle)], foot.point);
    squares += std::pow(std::acos(std::min(1.0, glm::dot(normal, out))), 2);
    ++count;
  }
  EXPECT_LE(std::sqrt(squares / count) * 180 / std::numbers::pi, 0.25);
}

TEST(DrawnAsFelt, SoftPadWithATexture) {
  const TriMesh box = makeBox(Vec3(kSide_m), 50).value();
  EXPECT_LE(farthest_m(box, box.vertices), kFarthest_m);
}

TEST(DrawnAsFelt, SoftPadTiltedByALattice) {
  Lattice lattice{.low_m = Vec3(-0.06), .size_m = Vec3(0.12), .points = {2, 2, 2}, .control_m = {}};
  for (const double z : {-0.06, 0.06}) {
    for (const double y : {-0.06, 0.06}) {
      for (const double x : {-0.06, 0.06}) lattice.control_m.emplace_back(x, y, z + (x > 0 ? 0.004 : 0));
    }
  }
  const TriMesh box = makeBox(Vec3(kSide_m), 50).value();
  EXPECT_LE(farthest_m({shapedBy(lattice, box.vertices), box.triangles}, box.vertices), kFarthest_m);
}

}  // namespace
}  // namespace haptics::drawn_as_felt_test
