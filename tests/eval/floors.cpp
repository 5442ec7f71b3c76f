#include "tests/eval/floors.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/import.h"

namespace haptics::eval {
namespace {

using shapes::Shape;

/// A whole number of tenths of a millimetre at scale 1, as decimals that are typed.
double decimal(Random& random, double low_m, double high_m, double scale) {
  constexpr double kAMetre = 1e4;
  return std::round(random.between(low_m, high_m) * kAMetre) / (kAMetre / scale);
}

/// The same box in another frame: a quarter or half turn leaves its corners' numbers, any other turn rounds them.
Tile turnedBox(Vec3 size, int n, Vec3 middle, Random& random) {
  Quat turn(1, 0, 0, 0);
  const int draw = random.below(4);
  if (draw == 1) turn = random.below(2) == 0 ? Quat(0, 1, 0, 0) : Quat(0, 0, 0, 1);
  if (draw == 2) turn = random.rotation();
  const Quat back = glm::conjugate(turn);
  const Shape box = shapes::box(size, n);
  return {draw < 2 ? box : box.mapped([&](Vec3 v) { return back * v; }), {turn, middle}};
}

enum class Cracked { kParts, kSheet, kBlock };

/// One mesh with a crack, in one of its ways: boxes beside one another, an open sheet in two patches, a block whose top comes
/// in two patches. Vertices are floats, so that the crack is as wide as they let it be.
Shape crackedShape(Cracked kind, double crack_m, double scale) {
  const double half = 0.05 * scale;
  Shape all;
  switch (kind) {
    case Cracked::kParts:
      for (int i = 0; i < 4; ++i)
        all.add(shapes::box(Vec3(0.025, 0.1, 0.02) * scale),
                Vec3((i - 1.5) * (0.025 * scale + crack_m), 0, -0.01 * scale));
      return all;
    case Cracked::kSheet: {
      const Shape patch = shapes::sheet(0.1 * scale, 4).mapped([](Vec3 v) { return Vec3(v.x * 0.5, v.y, v.z); });
      all.add(patch, Vec3(-half / 2, 0, 0));
      all.add(patch, Vec3(half / 2 + crack_m, 0, 0));
      return all;
    }
    case Cracked::kBlock:
      break;
  }
  // The block of two halves without the walls between them.
  for (const double side : {-1.0, 1.0}) {
    const Shape box = shapes::box(Vec3(half, 0.1 * scale, 0.02 * scale), 2);
    Shape open = box;
    std::erase_if(open.triangles, [&](const TriangleIndices& t) {
      return std::ranges::all_of(t, [&](std::uint32_t v) { return box.vertices[v].x * side < -0.24 * half; });
    });
    all.add(open, Vec3(side * half / 2 + (side > 0 ? crack_m : 0), 0, -0.01 * scale));
  }
  return all;
}

Shape imported(const std::vector<Vec3>& vertices, const std::vector<TriangleIndices>& triangles) {
  const auto mesh = canonicalise(vertices, triangles, {});
  return {mesh->mesh.vertices, mesh->mesh.triangles};
}

/// Of a segment's rim, which is 2^-21 * 1.75 of the mesh's largest coordinate: what is to be closed for certain.
double widestCrack_m(double scale) { return 1.6 * 0x1.cp-21 * 0.05 * scale; }

}  // namespace

Floor flushBoxes(double scale, Random& random) {
  Floor floor;
  floor.scale = scale;
  const int columns = 2 + random.below(5), rows = 1 + random.below(3);
  const double depth = decimal(random, 0.02, 0.05, floor.scale);
  const bool alike = random.below(2) == 0;
  const double width = decimal(random, 0.01, 0.04, floor.scale);
  double left = -columns * decimal(random, 0.005, 0.02, floor.scale);
  floor.low = Vec3(left, -depth * rows / 2, 0);
  for (int i = 0; i < columns; ++i) {
    const double own = alike ? width : decimal(random, 0.01, 0.04, floor.scale);
    for (int j = 0; j < rows; ++j) {
      const double height = decimal(random, 0.015, 0.03, floor.scale);
      const Vec3 middle(left + own / 2, floor.low.y + j * depth + depth / 2, -height / 2);
      floor.tiles.push_back(turnedBox({own, depth, height}, 1 + random.below(3), middle, random));
    }
    left += own;
    floor.seams.push_back(left);
  }
  floor.seams.pop_back();
  floor.high = Vec3(left, -floor.low.y, 0);
  return floor;
}

Floor crackedMesh(double scale, Random& random) {
  Floor floor;
  floor.scale = scale;
  const double widest = widestCrack_m(floor.scale);
  const double narrowest = std::min(1e-9, widest / 100);
  const double crack_m = random.below(8) == 0 ? 0 : narrowest * std::pow(widest / narrowest, random.between(0, 1));
  const Cracked kind = static_cast<Cracked>(random.below(3));
  const Shape shape = crackedShape(kind, crack_m, floor.scale);
  floor.tiles.push_back({imported({shape.vertices.begin(), shape.vertices.end()}, shape.triangles), Pose{}});
  floor.low = Vec3(-0.05, -0.05, 0) * floor.scale;
  floor.high = -floor.low;
  floor.seams = {crack_m / 2};
  if (kind == Cracked::kParts) {
    for (const double side : {-1.0, 1.0}) floor.seams.push_back(side * (0.025 * floor.scale + crack_m));
    floor.seams[0] = 0;
  }
  return floor;
}

Floor fiveBoxes(double width_m, double gap_m) {
  Floor floor;
  const double pitch_m = width_m + gap_m;
  const Vec3 size_m(width_m, 0.125, 0.03125);
  for (int i = 0; i < 5; ++i)
    floor.tiles.push_back({shapes::box(size_m), {{1, 0, 0, 0}, {(i - 2) * pitch_m, 0, -size_m.z / 2}}});
  for (int i = 0; i < 4; ++i) floor.seams.push_back((i - 1.5) * pitch_m);
  floor.high = Vec3(2 * pitch_m + width_m / 2, size_m.y / 2, 0);
  floor.low = -floor.high;
  return floor;
}

Floor patchedBlock(double gap_m, bool closed) {
  constexpr int kSquares = 4;
  constexpr double kHalf_m = 0.05, kHeight_m = 0.02;
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
  const auto quad = [&](Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const auto k = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), {a, b, c, d});
    triangles.insert(triangles.end(), {{k, k + 1, k + 2}, {k, k + 2, k + 3}});
  };
  for (const auto& [left, right] : {std::pair{-kHalf_m, -gap_m / 2}, {gap_m / 2, kHalf_m}}) {
    for (int i = 0; i < kSquares; ++i) {
      for (int j = 0; j < kSquares; ++j) {
        const double x0 = left + (right - left) * i / kSquares, x1 = left + (right - left) * (i + 1) / kSquares;
        const double y0 = kHalf_m * (2.0 * j / kSquares - 1), y1 = kHalf_m * (2.0 * (j + 1) / kSquares - 1);
        quad({x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0});
      }
    }
  }
  if (closed) {
    const double s = kHalf_m, h = kHeight_m;
    quad({-s, -s, -h}, {-s, s, -h}, {s, s, -h}, {s, -s, -h});
    quad({-s, -s, 0}, {-s, -s, -h}, {s, -s, -h}, {s, -s, 0});
    quad({s, -s, 0}, {s, -s, -h}, {s, s, -h}, {s, s, 0});
    quad({s, s, 0}, {s, s, -h}, {-s, s, -h}, {-s, s, 0});
    quad({-s, s, 0}, {-s, s, -h}, {-s, -s, -h}, {-s, -s, 0});
  }
  Floor floor;
  floor.tiles.push_back({imported(vertices, triangles), Pose{}});
  floor.high = Vec3(kHalf_m, kHalf_m, 0);
  floor.low = -floor.high;
  floor.seams = {0};
  return floor;
}

}  // namespace haptics::eval
