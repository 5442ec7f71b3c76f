#include "tests/eval/analytic_shapes.h"

#include <array>
#include <cmath>

#include "common/mesh/generators.h"

namespace haptics::eval {
namespace {

constexpr double kSphereRadius = 0.05;
constexpr double kMajorRadius = 0.04;
constexpr double kMinorRadius = 0.015;
constexpr double kCylinderRadius = 0.03;
constexpr double kCylinderHeight = 0.1;
constexpr double kCubeSide = 0.1;

std::uint32_t rootOf(double squares) { return static_cast<std::uint32_t>(std::lround(std::sqrt(squares))); }

TriMesh sphere(int triangles) { return makeSphere(kSphereRadius, rootOf(triangles / 12.0)).value(); }
TriMesh torus(int triangles) {
  const std::uint32_t across = rootOf(triangles / 3.0);
  return makeTorus(kMajorRadius, kMinorRadius, across * 3 / 2, across).value();
}
TriMesh cylinder(int triangles) {
  return makeCylinder(kCylinderRadius, kCylinderHeight, static_cast<std::uint32_t>(triangles / 4)).value();
}
TriMesh cube(int triangles) { return makeBox(Vec3(kCubeSide), rootOf(triangles / 12.0)).value(); }

SurfacePoint onSphere(double way) {
  const Quat tilt = glm::angleAxis(0.4, glm::normalize(Vec3(1, 0.5, 0.2)));
  const double angle = way / kSphereRadius;
  const Vec3 normal = tilt * Vec3(std::sin(angle), 0, std::cos(angle));
  return {normal * kSphereRadius, normal};
}

/// From the outside over the top to the inside.
SurfacePoint onTorus(double way) {
  const double u = 0.3 + 0.7 * way / kMajorRadius;
  const double v = -0.2 + 0.7 * way / kMinorRadius;
  const Vec3 outwards{std::cos(u), std::sin(u), 0};
  const Vec3 normal = outwards * std::cos(v) + Vec3(0, 0, std::sin(v));
  return {outwards * kMajorRadius + normal * kMinorRadius, normal};
}

SurfacePoint onCylinder(double way) {
  const double u = 0.1 + 0.9 * way / kCylinderRadius;
  const Vec3 normal{std::cos(u), std::sin(u), 0};
  return {normal * kCylinderRadius + Vec3(0, 0, 0.43 * way - 0.02), normal};
}

SurfacePoint onCube(double way) { return {Vec3(0.83 * way - 0.031, 0.56 * way - 0.013, kCubeSide / 2), {0, 0, 1}}; }

constexpr std::array kShapes{
    AnalyticShape{"sphere", sphere, onSphere},
    AnalyticShape{"torus", torus, onTorus},
    AnalyticShape{"cylinder", cylinder, onCylinder},
    AnalyticShape{"cube", cube, onCube},
};

}  // namespace

std::span<const AnalyticShape> analyticShapes() { return kShapes; }

}  // namespace haptics::eval
