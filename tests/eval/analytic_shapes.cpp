#include "tests/eval/analytic_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"

namespace haptics::eval {
namespace {

constexpr double kSphereRadius = 0.05;
constexpr double kMajorRadius = 0.04;
constexpr double kMinorRadius = 0.015;
constexpr double kCylinderRadius = 0.03;
constexpr double kCylinderHeight = 0.1;
constexpr double kCubeSide = 0.1;

constexpr double kCellSide = 0.05;
constexpr double kWave = 0.02;
constexpr double kAmplitude = 0.001;  // the crests' radius of curvature, 10 mm, is beyond every depth

std::uint32_t rootOf(double squares) {
  return std::max(1U, static_cast<std::uint32_t>(std::lround(std::sqrt(squares))));
}

TriMesh sphere(int triangles) { return makeSphere(kSphereRadius, rootOf(triangles / 12.0)).value(); }
TriMesh torus(int triangles) {
  const std::uint32_t across = std::max(6U, rootOf(triangles / 3.0));  // fewer make no torus
  return makeTorus(kMajorRadius, kMinorRadius, across * 3 / 2, across).value();
}
TriMesh cube(int triangles) { return makeBox(Vec3(kCubeSide), rootOf(triangles / 12.0)).value(); }

/// Rectangles of a lattice, joined where they meet.
class LatticeFaces {
 public:
  LatticeFaces(glm::ivec3 perCell, Vec3 cell_m) : perCell_(perCell), step_m_(cell_m / Vec3(perCell)) {}

  /// u x v points outwards; corner, u and v in cells.
  void add(glm::ivec3 corner, glm::ivec3 u, glm::ivec3 v) {
    const glm::ivec3 alongU = glm::sign(u);
    const glm::ivec3 alongV = glm::sign(v);
    const auto steps = [&](glm::ivec3 cells) { return std::abs(glm::dot(Vec3(perCell_), Vec3(cells))); };
    for (int i = 0; i < steps(u); ++i) {
      for (int j = 0; j < steps(v); ++j) {
        const glm::ivec3 at = corner * perCell_ + alongU * i + alongV * j;
        const auto first = static_cast<std::uint32_t>(vertices_.size());
        for (const glm::ivec3 p : {at, at + alongU, at + alongU + alongV, at + alongV}) {
          vertices_.push_back(Vec3(p) * step_m_);
        }
        triangles_.push_back({first, first + 1, first + 2});
        triangles_.push_back({first, first + 2, first + 3});
      }
    }
  }
  /// All six sides of a box of some cells.
  void addBox(glm::ivec3 corner, glm::ivec3 size) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 u(0), v(0), far(0);
      u[(axis + 1) % 3] = size[(axis + 1) % 3];
      v[(axis + 2) % 3] = size[(axis + 2) % 3];
      far[axis] = size[axis];
      add(corner, v, u);
      add(corner + far, u, v);
    }
  }
  template <class Map>
  [[nodiscard]] TriMesh mesh(Map map) && {
    for (Vec3& v : vertices_) v = map(v);
    return canonicalise(vertices_, std::move(triangles_), {}).value().mesh;
  }
  [[nodiscard]] TriMesh mesh() && {
    return std::move(*this).mesh([](Vec3 v) { return v; });
  }

 private:
  glm::ivec3 perCell_;
  Vec3 step_m_;
  std::vector<Vec3> vertices_;
  std::vector<TriangleIndices> triangles_;
};

/// Nearly square faces; the ends are fans.
TriMesh cylinder(int triangles) {
  constexpr double kAround = 2 * std::numbers::pi * kCylinderRadius / kCylinderHeight;
  const std::uint32_t along = rootOf(triangles / (2 * kAround));
  const std::uint32_t around = std::max(3U, static_cast<std::uint32_t>(std::lround(along * kAround)));
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % around + j * around; };
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> faces;
  for (std::uint32_t j = 0; j <= along; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double u = 2 * std::numbers::pi * i / around;
      vertices.emplace_back(kCylinderRadius * std::cos(u), kCylinderRadius * std::sin(u),
                            kCylinderHeight * (static_cast<double>(j) / along - 0.5));
    }
  }
  const auto bottom = static_cast<std::uint32_t>(vertices.size());
  vertices.emplace_back(0, 0, -kCylinderHeight / 2);
  vertices.emplace_back(0, 0, kCylinderHeight / 2);
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < along; ++j) {
      faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    faces.push_back({bottom, at(i + 1, 0), at(i, 0)});
    faces.push_back({bottom + 1, at(i, along), at(i + 1, along)});
  }
  return canonicalise(vertices, std::move(faces), {}).value().mesh;
}

/// Two cells wide and high, without the one at x, z > 0, two cells deep. The crease is the y axis.
TriMesh lShape(int triangles) {
  LatticeFaces faces(glm::ivec3(static_cast<int>(rootOf(triangles / 44.0))), Vec3(kCellSide));
  for (const glm::ivec2 cell : {glm::ivec2(-1, -1), glm::ivec2(0, -1), glm::ivec2(-1, 0)}) {
    faces.add({cell.x, -1, cell.y}, {1, 0, 0}, {0, 0, 1});
    faces.add({cell.x, 1, cell.y}, {0, 0, 1}, {1, 0, 0});
  }
  faces.add({-1, -1, -1}, {0, 2, 0}, {2, 0, 0});  // below
  faces.add({-1, -1, -1}, {0, 0, 2}, {0, 2, 0});  // behind
  faces.add({1, -1, -1}, {0, 2, 0}, {0, 0, 1});   // the foot's front
  faces.add({0, -1, 0}, {1, 0, 0}, {0, 2, 0});    // the floor
  faces.add({0, -1, 0}, {0, 2, 0}, {0, 0, 1});    // the wall
  faces.add({-1, -1, 1}, {1, 0, 0}, {0, 2, 0});   // above
  return std::move(faces).mesh();
}

double waveAt(double x) { return kAmplitude * std::sin(2 * std::numbers::pi * x / kWave); }

/// A plate with a wavy top, four times finer along the waves' way than across.
TriMesh grating(int triangles) {
  const int across = static_cast<int>(rootOf(triangles / 16.0));
  LatticeFaces faces({2 * across, across / 2 + 1, 1}, Vec3(kCellSide));
  faces.addBox({-1, -1, 0}, {2, 2, 1});
  return std::move(faces).mesh([](Vec3 v) { return v.z > 0 ? v + Vec3(0, 0, waveAt(v.x)) : v; });
}

/// The inverse way: the HIP is below a point of the surface, whose traction it should feel.
Truth below(Vec3 place, Vec3 normal, double depth) {
  const Vec3 hip = place - normal * depth;
  const bool touching = depth > 0;
  return {hip, touching ? place : hip, touching};
}

Truth onSphere(double way, double depth) {
  const Quat tilt = glm::angleAxis(0.4, glm::normalize(Vec3(1, 0.5, 0.2)));
  const double angle = way / kSphereRadius;
  const Vec3 normal = tilt * Vec3(std::sin(angle), 0, std::cos(angle));
  return below(normal * kSphereRadius, normal, depth);
}

/// From the outside over the top to the inside.
Truth onTorus(double way, double depth) {
  const double u = 0.3 + 0.7 * way / kMajorRadius;
  const double v = -0.2 + 0.7 * way / kMinorRadius;
  const Vec3 outwards{std::cos(u), std::sin(u), 0};
  const Vec3 normal = outwards * std::cos(v) + Vec3(0, 0, std::sin(v));
  return below(outwards * kMajorRadius + normal * kMinorRadius, normal, depth);
}

Truth onCylinder(double way, double depth) {
  const double u = 0.1 + 0.9 * way / kCylinderRadius;
  const Vec3 normal{std::cos(u), std::sin(u), 0};
  return below(normal * kCylinderRadius + Vec3(0, 0, 0.43 * way - 0.02), normal, depth);
}

/// Along the top and off its side. The god-object solved by hand: it stays on the top until the HIP has left.
Truth onCube(double way, double depth) {
  constexpr double kHalf = kCubeSide / 2;
  const Vec3 place{0.83 * way + 0.005, 0.56 * way - 0.013, kHalf};
  Truth truth = below(place, {0, 0, 1}, depth);
  if (place.x <= kHalf) return truth;
  truth.ihip = truth.hip;
  truth.touching = false;
  return truth;
}

/// Along the floor into the crease, then up the wall. The god-object solved by hand: in the quadrant x, z >= 0, which is
/// convex, it is the point nearest to the HIP.
Truth onLShape(double way, double depth) {
  constexpr double kFloor = 0.03;
  const double up = way - kFloor - depth;
  const Vec3 hip{std::max(kFloor - way, -depth), 0.31 * way - 0.011, up > 0 ? up - depth : -depth};
  const Vec3 ihip = glm::max(hip, Vec3(0, hip.y, 0));
  return {hip, ihip, ihip != hip};
}

/// Along and across the waves. Below the radius of curvature the point that the HIP was put below is the nearest one,
/// and the path's.
Truth onGrating(double way, double depth) {
  const double x = 0.9 * way - 0.027;
  const double slope = 2 * std::numbers::pi / kWave * kAmplitude * std::cos(2 * std::numbers::pi * x / kWave);
  return below({x, 0.4 * way - 0.011, kCellSide + waveAt(x)}, glm::normalize(Vec3(-slope, 0, 1)), depth);
}

constexpr std::array kShapes{
    AnalyticShape{"sphere", sphere, onSphere, kSphereRadius},
    AnalyticShape{"torus", torus, onTorus},
    AnalyticShape{"cylinder", cylinder, onCylinder},
    AnalyticShape{"cube", cube, onCube},
    AnalyticShape{"l_shape", lShape, onLShape},
    AnalyticShape{"sine_grating", grating, onGrating},
};

}  // namespace

std::span<const AnalyticShape> analyticShapes() { return kShapes; }

}  // namespace haptics::eval
