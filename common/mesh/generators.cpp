#include "common/mesh/generators.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/maths/elementary.h"
#include "common/mesh/import.h"

namespace haptics {
namespace {

Result<void> checkSize(const char* name, double size_m) {
  if (std::isfinite(size_m) && size_m > 0) return {};
  return refused(name, "is " + std::to_string(size_m) + "; it must be finite and > 0, in metres");
}

Result<void> checkSegments(const char* name, std::uint32_t segments, std::uint32_t least) {
  if (segments >= least) return {};
  return refused(name, "is " + std::to_string(segments) + "; it must be at least " + std::to_string(least));
}

Result<void> checkCount(const char* name, double triangles) {
  if (triangles <= static_cast<double>(kMaxTriangles)) return {};
  return refused(name, "would make more than " + std::to_string(kMaxTriangles) + " triangles");
}

struct Quads {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;

  /// A quadrilateral, counter-clockwise seen from outside, cut from its first to its third corner.
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }

  /// canonicalise() joins what the patches share. A triangle that it drops (sizes so far apart that float32 has no
  /// room for them) would leave a hole.
  [[nodiscard]] Result<TriMesh> canonical(const char* name) && {
    const std::size_t made = triangles.size();
    auto imported = canonicalise(vertices, std::move(triangles), ImportOptions{});
    if (!imported) return refused(name, std::move(imported).error().reason);
    if (imported->report.kept != made || !imported->report.closed()) {
      return refused(name, "its triangles would be too thin or too small for float32 vertices; choose fewer segments");
    }
    return std::move(imported->mesh);
  }
};

/// Six n x n grids over the cube [-1, 1]^3. `place` must send equal points to equal points: that is what joins faces.
template <class Place>
Quads gridsOnCube(std::uint32_t n, Place place) {
  Quads quads;
  const std::uint32_t row = n + 1;
  quads.vertices.reserve(6 * std::size_t{row} * row);
  quads.triangles.reserve(12 * std::size_t{n} * n);
  // Exactly odd around the middle, so that faces seen from either side agree on their common edge.
  const auto along = [n](std::uint32_t i) { return (2.0 * i - n) / n; };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(quads.vertices.size());
      for (std::uint32_t j = 0; j < row; ++j) {
        for (std::uint32_t i = 0; i < row; ++i) {
          Vec3 p;
          p[axis] = side;
          p[(axis + 1) % 3] = along(i);
          p[(axis + 2) % 3] = along(j);
          quads.vertices.push_back(place(p));
        }
      }
      for (std::uint32_t j = 0; j < n; ++j) {
        for (std::uint32_t i = 0; i < n; ++i) {
          const std::uint32_t a = first + j * row + i;
          if (side > 0) {
            quads.add(a, a + 1, a + row + 1, a + row);
          } else {
            quads.add(a, a + row, a + row + 1, a + 1);
          }
        }
      }
    }
  }
  return quads;
}

elementary::SineCosine directionAt(std::uint32_t i, std::uint32_t segments) {
  return elementary::sineCosine(2 * std::numbers::pi * i / segments);
}

}  // namespace

Result<TriMesh> makeBox(Vec3 size_m, std::uint32_t segmentsPerSide) {
  const double n = segmentsPerSide;
  auto ok = checkSize("size_m.x", size_m.x)
                .and_then([&] { return checkSize("size_m.y", size_m.y); })
                .and_then([&] { return checkSize("size_m.z", size_m.z); })
                .and_then([&] { return checkSegments("segments", segmentsPerSide, 1); })
                .and_then([&] { return checkCount("segments", 12 * n * n); });
  if (!ok) return tl::unexpected(std::move(ok).error());
  return gridsOnCube(segmentsPerSide, [half = size_m / 2.0](Vec3 p) { return p * half; }).canonical("size_m");
}

// The cube's grid is sent to the sphere by x' = x sqrt(1 - y^2/2 - z^2/2 + y^2 z^2/3) and its rotations (P. Nowell,
// "Mapping a Cube to a Sphere", 2005), which keeps the triangles' sizes closer together than dividing by the length.
// It uses only operations that IEEE 754 rounds exactly, so that every machine makes the same sphere.
Result<TriMesh> makeSphere(double radius_m, std::uint32_t segmentsPerCubeEdge) {
  const double n = segmentsPerCubeEdge;
  auto ok = checkSize("radius_m", radius_m)
                .and_then([&] { return checkSegments("segments", segmentsPerCubeEdge, 1); })
                .and_then([&] { return checkCount("segments", 12 * n * n); });
  if (!ok) return tl::unexpected(std::move(ok).error());
  const auto onSphere = [radius_m](Vec3 p) {
    const Vec3 s = p * p;
    const auto scale = [](double u, double v) { return std::sqrt(1 - u / 2 - v / 2 + u * v / 3); };
    return radius_m * Vec3(p.x * scale(s.y, s.z), p.y * scale(s.z, s.x), p.z * scale(s.x, s.y));
  };
  return gridsOnCube(segmentsPerCubeEdge, onSphere).canonical("radius_m");
}

Result<TriMesh> makeCylinder(double radius_m, double height_m, std::uint32_t segmentsAround) {
  auto ok = checkSize("radius_m", radius_m)
                .and_then([&] { return checkSize("height_m", height_m); })
                .and_then([&] { return checkSegments("segments", segmentsAround, 3); })
                .and_then([&] { return checkCount("segments", 4.0 * segmentsAround); });
  if (!ok) return tl::unexpected(std::move(ok).error());

  Quads quads;
  const std::uint32_t bottom = 2 * segmentsAround, top = bottom + 1;  // middles of the ends
  for (std::uint32_t i = 0; i < segmentsAround; ++i) {
    const auto [sine, cosine] = directionAt(i, segmentsAround);
    quads.vertices.emplace_back(radius_m * cosine, radius_m * sine, -height_m / 2);
    quads.vertices.emplace_back(radius_m * cosine, radius_m * sine, height_m / 2);
  }
  quads.vertices.emplace_back(0, 0, -height_m / 2);
  quads.vertices.emplace_back(0, 0, height_m / 2);
  for (std::uint32_t i = 0; i < segmentsAround; ++i) {
    const std::uint32_t here = 2 * i, next = 2 * ((i + 1) % segmentsAround);
    quads.add(here, next, next + 1, here + 1);
    quads.triangles.push_back({bottom, next, here});
    quads.triangles.push_back({top, here + 1, next + 1});
  }
  return std::move(quads).canonical("radius_m");
}

Result<TriMesh> makeTorus(double majorRadius_m, double minorRadius_m, std::uint32_t majorSegments,
                          std::uint32_t minorSegments) {
  auto ok = checkSize("major_radius_m", majorRadius_m)
                .and_then([&] { return checkSize("minor_radius_m", minorRadius_m); })
                .and_then([&] { return checkSegments("major_segments", majorSegments, 3); })
                .and_then([&] { return checkSegments("minor_segments", minorSegments, 3); })
                .and_then([&] { return checkCount("major_segments", 2.0 * majorSegments * minorSegments); });
  if (!ok) return tl::unexpected(std::move(ok).error());
  if (minorRadius_m >= majorRadius_m) {
    return refused("minor_radius_m", "must be smaller than major_radius_m: the torus would cross itself");
  }

  Quads quads;
  const auto index = [&](std::uint32_t i, std::uint32_t j) {
    return i % majorSegments * minorSegments + j % minorSegments;
  };
  for (std::uint32_t i = 0; i < majorSegments; ++i) {
    const auto around = directionAt(i, majorSegments);
    for (std::uint32_t j = 0; j < minorSegments; ++j) {
      const auto tube = directionAt(j, minorSegments);
      const double toAxis = majorRadius_m + minorRadius_m * tube.cosine;
      quads.vertices.emplace_back(toAxis * around.cosine, toAxis * around.sine, minorRadius_m * tube.sine);
    }
  }
  for (std::uint32_t i = 0; i < majorSegments; ++i) {
    for (std::uint32_t j = 0; j < minorSegments; ++j) {
      quads.add(index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
    }
  }
  return std::move(quads).canonical("major_radius_m");
}

}  // namespace haptics
