#include "tests/eval/fuzz/fuzz_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "common/deform/free_form.h"
#include "haptic_server/scene/object_assets.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval {
namespace {

using std::numbers::pi;

FuzzMesh fromShape(const shapes::Shape& shape) { return {shape.vertices, shape.triangles, {}}; }

FuzzMesh box(Random& random) {
  const Vec3 half{random.between(0.005, 0.035), random.between(0.005, 0.035), random.between(0.002, 0.032)};
  return fromShape(shapes::box(2.0 * half, 1 + random.below(4)));
}

/// Rings of vertices, closed by a vertex at either end. Seen along the way from the first ring to the last they turn
/// clockwise.
FuzzMesh closedRings(const std::vector<std::vector<Vec3>>& rings, Vec3 first, Vec3 last) {
  FuzzMesh mesh;
  mesh.vertices.emplace_back(first);
  for (const auto& ring : rings) mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  mesh.vertices.emplace_back(last);
  const auto around = static_cast<std::uint32_t>(rings.front().size());
  const auto end = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const auto at = [&](std::size_t ring, std::uint32_t j) {
    return 1 + static_cast<std::uint32_t>(ring) * around + j % around;
  };
  for (std::uint32_t j = 0; j < around; ++j) {
    mesh.triangles.push_back({0, at(0, j), at(0, j + 1)});
    mesh.triangles.push_back({end, at(rings.size() - 1, j + 1), at(rings.size() - 1, j)});
    for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

/// A ball of latitudes and longitudes; each vertex is drawn in by up to `spikes` of the radius.
FuzzMesh ball(int around, int along, double radius, double spikes, Random& random) {
  const auto place = [&](double latitude, double longitude) {
    const double r = radius * random.between(1 - spikes, 1);
    return r *
           Vec3(std::sin(latitude) * std::cos(longitude), std::sin(latitude) * std::sin(longitude), std::cos(latitude));
  };
  std::vector<std::vector<Vec3>> rings;
  for (int i = 1; i < along; ++i) {
    auto& ring = rings.emplace_back();
    for (int j = 0; j < around; ++j) ring.push_back(place(pi * i / along, 2 * pi * j / around));
  }
  const Vec3 first = place(0, 0);
  return closedRings(rings, first, place(pi, 0));
}

FuzzMesh blob(Random& random) {
  const int around = 8 + random.below(20);
  const int along = 5 + random.below(12);
  const double radius = random.between(0.01, 0.04);
  return ball(around, along, radius, random.between(0, 0.1), random);
}

FuzzMesh spiky(Random& random) {
  const int around = 6 + random.below(8);
  const int along = 4 + random.below(5);
  const double radius = random.between(0.02, 0.05);
  return ball(around, along, radius, random.between(0, 0.6), random);
}

void append(FuzzMesh& mesh, const FuzzMesh& other, Vec3 at) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3f v : other.vertices) mesh.vertices.emplace_back(Vec3(v) + at);
  for (const TriangleIndices& t : other.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

/// A sausage bent so far that its end goes through its beginning.
FuzzMesh bentThroughItself(Random& random) {
  const int around = 6 + random.below(8);
  const int along = 16 + random.below(16);
  const double bend = random.between(0.012, 0.025);
  const double thickness = bend * random.between(0.3, 0.7);
  const double angle = 2 * pi + random.between(0.2, 1);
  const double rise = thickness * random.between(0, 1.2);
  const auto middle = [&](double s) { return Vec3(bend * std::cos(angle * s), bend * std::sin(angle * s), rise * s); };
  std::vector<std::vector<Vec3>> rings;
  for (int i = 1; i < along; ++i) {
    const double s = static_cast<double>(i) / along;
    const double radius = thickness * std::sqrt(std::sin(pi * s)) * random.between(0.9, 1);
    const Vec3 out{std::cos(angle * s), std::sin(angle * s), 0};
    auto& ring = rings.emplace_back();
    for (int j = 0; j < around; ++j) {
      const double turn = 2 * pi * j / around;
      ring.push_back(middle(s) + radius * (std::cos(turn) * out + std::sin(turn) * Vec3(0, 0, 1)));
    }
  }
  return closedRings(rings, middle(0), middle(1));
}

FuzzMesh folded(Random& random) {
  if (random.below(2) == 0) return bentThroughItself(random);
  FuzzMesh mesh;
  const int parts = 2 + random.below(2);
  for (int i = 0; i < parts; ++i) {
    const FuzzMesh part = random.below(3) == 0 ? box(random) : blob(random);
    const double apart = random.between(0.003, 0.02);
    append(mesh, part, apart * random.direction());
  }
  return mesh;
}

/// Hills on a square grid; a cone to far below would close it.
FuzzMesh sheet(Random& random) {
  constexpr double kSide_m = 0.6;
  constexpr float kApex_m = -0.5F;
  const int n = 8 + random.below(24);
  const double height = random.between(0, 0.01);
  const double roughness = random.between(0, 0.002);
  const double wave = random.between(20, 120);
  FuzzMesh mesh;
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const double x = kSide_m * (static_cast<double>(i) / n - 0.5);
      const double y = kSide_m * (static_cast<double>(j) / n - 0.5);
      const double z = height * std::sin(wave * x) * std::cos(wave * y) + random.between(-roughness, roughness);
      mesh.vertices.emplace_back(Vec3(x, y, z));
    }
  }
  const auto apex = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, 0, kApex_m);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.missing.push_back({at(i + 1, 0), at(i, 0), apex});
    mesh.missing.push_back({at(i, n), at(i + 1, n), apex});
    mesh.missing.push_back({at(0, i), at(0, i + 1), apex});
    mesh.missing.push_back({at(n, i + 1), at(n, i), apex});
  }
  return mesh;
}

/// The sheet's hills above, the same hills below, turned over, and a rim.
FuzzMesh plate(Random& random) {
  const FuzzMesh above = sheet(random);
  const auto thickness = static_cast<float>(1e-6 * std::pow(300, random.between(0, 1)));
  FuzzMesh mesh;
  mesh.vertices.assign(above.vertices.begin(), above.vertices.end() - 1);  // without the apex
  mesh.triangles = above.triangles;
  mesh.upper = above.triangles.size();
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t i = 0; i < count; ++i) mesh.vertices.push_back(mesh.vertices[i] - Vec3f(0, 0, thickness));
  for (const auto& [a, b, c] : above.triangles) mesh.triangles.push_back({a + count, c + count, b + count});
  for (const auto& [b, a, apex] : above.missing) {
    mesh.triangles.push_back({a, b + count, b});
    mesh.triangles.push_back({a, a + count, b + count});
  }
  return mesh;
}

FuzzMesh mirrored(Random& random) {
  constexpr MeshKind kClosed[] = {MeshKind::kBox, MeshKind::kBlob, MeshKind::kSpiky, MeshKind::kFolded};
  FuzzMesh mesh = makeMesh(kClosed[random.below(4)], random);
  glm::dmat3 stretch(0);
  for (int k = 0; k < 3; ++k) stretch[k][k] = random.between(0.6, 1.3);
  stretch[random.below(3)] *= -1.0;
  const glm::dmat3 map = glm::mat3_cast(random.rotation()) * stretch * glm::mat3_cast(random.rotation());
  const Vec3 low(-0.1), size(0.2);
  DeformationProperties properties;
  properties.lattice = Lattice{low, size, {2, 2, 2}, FreeForm::atRest(low, size, {2, 2, 2})};
  for (Vec3f& point : properties.lattice->control_m) point = Vec3f(map * Vec3(point));
  AssetStore store;
  ObjectAssets assets;
  assets.mesh = store.intern(TriMesh{mesh.vertices, mesh.triangles});
  mesh.surface = assets.surfaceAtRest(properties);
  for (Vec3f& v : mesh.vertices) v = Vec3f(map * Vec3(v));
  for (TriangleIndices& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// One to three patches go.
FuzzMesh scan(Random& random) {
  const Vec3 size(random.between(0.02, 0.06));
  FuzzMesh mesh = random.below(3) == 0 ? fromShape(shapes::box(size, 4 + random.below(5))) : blob(random);
  const int patches = 1 + random.below(3);
  for (int i = 0; i < patches && mesh.triangles.size() > 40; ++i) {
    const Vec3 middle = mesh.middleOf(static_cast<std::size_t>(random.below(static_cast<int>(mesh.triangles.size()))));
    const double reach = random.between(0.003, 0.012);
    std::vector<TriangleIndices> kept;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      (glm::distance(mesh.middleOf(t), middle) < reach ? mesh.missing : kept).push_back(mesh.triangles[t]);
    }
    mesh.triangles = std::move(kept);
  }
  return mesh;
}

}  // namespace

std::vector<TriangleIndices> coneOverBoundary(std::vector<Vec3f>& vertices,
                                              std::span<const TriangleIndices> triangles) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> runs;
  for (const TriangleIndices& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++runs[{t[k], t[(k + 1) % 3]}];
  }
  std::vector<TriangleIndices> cone;
  Vec3 middle(0);
  float low = std::numeric_limits<float>::max(), high = -low;
  const auto apex = static_cast<std::uint32_t>(vertices.size());
  for (const auto& [edge, count] : runs) {
    if (runs.contains({edge.second, edge.first})) continue;
    cone.push_back({edge.second, edge.first, apex});
    middle += Vec3(vertices[edge.first]);
    low = std::min(low, vertices[edge.first].z);
    high = std::max(high, vertices[edge.first].z);
  }
  if (cone.empty()) return cone;
  constexpr double kFarBelow_m = 0.5;
  middle /= static_cast<double>(cone.size());
  vertices.emplace_back(middle - Vec3(0, 0, low == high ? kFarBelow_m : 0));
  return cone;
}

std::shared_ptr<const CollisionMesh> FuzzMesh::build() const {
  if (surface) return surface;
  std::vector<std::uint32_t> numbers(vertices.size(), 0);
  for (const TriangleIndices& triangle : triangles) {
    for (const std::uint32_t vertex : triangle) numbers[vertex] = 1;
  }
  std::vector<Vec3f> used;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (numbers[i] == 0) continue;
    numbers[i] = static_cast<std::uint32_t>(used.size());
    used.push_back(vertices[i]);
  }
  std::vector<TriangleIndices> renumbered = triangles;
  for (TriangleIndices& triangle : renumbered) {
    for (std::uint32_t& vertex : triangle) vertex = numbers[vertex];
  }
  return buildCollisionMesh(used, renumbered);
}

Vec3 FuzzMesh::middleOf(std::size_t triangle) const {
  const TriangleIndices& t = triangles[triangle];
  return (Vec3(vertices[t[0]]) + Vec3(vertices[t[1]]) + Vec3(vertices[t[2]])) / 3.0;
}

bool isClosed(const std::vector<TriangleIndices>& triangles) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> runs;
  for (const TriangleIndices& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++runs[{t[k], t[(k + 1) % 3]}];
  }
  return std::ranges::all_of(runs, [&](const auto& edge) {
    const auto back = runs.find({edge.first.second, edge.first.first});
    return edge.second == 1 && back != runs.end() && back->second == 1;
  });
}

FuzzMesh makeMesh(MeshKind kind, Random& random) {
  switch (kind) {
    case MeshKind::kBox:
      return box(random);
    case MeshKind::kBlob:
      return blob(random);
    case MeshKind::kSpiky:
      return spiky(random);
    case MeshKind::kFolded:
      return folded(random);
    case MeshKind::kSheet:
      return sheet(random);
    case MeshKind::kScan:
      return scan(random);
    case MeshKind::kPlate:
      return plate(random);
    case MeshKind::kMirrored:
      return mirrored(random);
  }
  return {};
}

Vec3 normalVector(Random& random) {
  const auto one = [&] {
    const double radius = std::sqrt(-2 * std::log(random.between(0x1p-53, 1)));
    return radius * std::cos(random.between(0, 2 * pi));
  };
  const double x = one();
  const double y = one();
  return {x, y, one()};
}

}  // namespace haptics::eval
