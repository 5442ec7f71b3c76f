#include "tests/eval/worst/import_families.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/eval/random.h"
#include "tests/eval/worst/mesh_writer.h"

namespace haptics::eval {
namespace {

using Genes = std::span<const double, ImportFamily::kGenes>;
using shapes::Shape;

constexpr double kTurn = 2 * std::numbers::pi;

double power(double gene, double least, double most) { return least * std::pow(most / least, gene); }
double real(double gene, double least, double most) { return least + gene * (most - least); }
int root(double count) { return std::max(1, static_cast<int>(std::lround(std::sqrt(count)))); }
Random randomOf(double gene) { return Random(static_cast<std::uint64_t>(gene * 1e6)); }
Vec3 inCube(Random& random) { return {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}; }

void addTriangle(Shape& shape, Vec3 a, Vec3 b, Vec3 c) {
  const auto first = static_cast<std::uint32_t>(shape.vertices.size());
  for (const Vec3 corner : {a, b, c}) shape.vertices.emplace_back(corner);
  shape.triangles.push_back({first, first + 1, first + 2});
}

MeshFile soup(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  Shape shape;
  const double size = power(genes[0], 0.003, 1);
  const double flat = power(genes[1], 1e-6, 1);
  for (int i = 0; i < triangles; ++i) {
    const Vec3 middle = inCube(random) * Vec3(1, 1, flat);
    const auto corner = [&] { return middle + size * inCube(random) * Vec3(1, 1, flat); };
    addTriangle(shape, corner(), corner(), corner());
  }
  return fileOf(std::move(shape), genes[3]);
}

MeshFile needles(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  Shape shape;
  const double width = power(genes[0], 1e-6, 0.1);
  for (int i = 0; i < triangles; ++i) {
    const Vec3 from = inCube(random) * Vec3(1, 1, 0) - Vec3(0, 0, genes[1]);
    addTriangle(shape, from, from + Vec3(width, 0, 0), inCube(random) * Vec3(1, 1, 0) + Vec3(0, 0, genes[1]));
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Its rim goes up and down.
MeshFile fan(Genes genes, int triangles) {
  Shape shape = shapes::cone(1, real(genes[0], -1, 1), std::max(3, triangles / 2));
  for (std::size_t i = 2; i < shape.vertices.size(); ++i) {
    shape.vertices[i].z += static_cast<float>(real(genes[1], 0, 0.1) * std::sin(static_cast<double>(i) * genes[2] * 7));
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Cones in a row, each torn where its top comes out below its foot.
MeshFile hubs(Genes genes, int triangles) {
  const int valence = static_cast<int>(power(genes[0], 8, 4000));
  Shape shape;
  for (int i = 0; i < std::max(1, triangles / valence / 2); ++i) {
    shape.add(shapes::cone(1, real(genes[1], -0.3, 1), valence), Vec3(i * real(genes[2], 0.1, 2), 0.01 * (i % 7), 0));
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Corners on a grid so coarse that many are at one place.
MeshFile coincident(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  Shape shape;
  const double places = power(genes[0], 4, triangles);
  const double perSide = std::cbrt(places);
  const double size = power(genes[1], 2 / perSide, 2);
  for (int i = 0; i < triangles; ++i) {
    const Vec3 middle = inCube(random);
    const auto corner = [&] { return glm::round((middle + size * inCube(random)) * perSide) / perSide; };
    addTriangle(shape, corner(), corner(), corner());
  }
  return fileOf(std::move(shape), genes[3]);
}

MeshFile shells(Genes genes, int triangles) {
  const int n = std::max(1, root(power(genes[0], 12, triangles) / 12));
  const int count = std::max(1, triangles / (12 * n * n));
  Shape shape;
  for (int i = 0; i < count; ++i) {
    shape.add(shapes::sphere(1 + power(genes[1], 1e-6, 1) * i / count, n), Vec3(genes[2] * 0.01 * i / count, 0, 0));
  }
  return fileOf(std::move(shape), genes[3]);
}

Shape grid(int n, const std::function<Vec3(double, double)>& at) {
  Shape shape;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) shape.vertices.emplace_back(at(1.0 * i / n, 1.0 * j / n));
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const auto v = static_cast<std::uint32_t>(i * (n + 1) + j);
      const auto across = static_cast<std::uint32_t>(n + 1);
      shape.triangles.push_back({v, v + across, v + across + 1});
      shape.triangles.push_back({v, v + across + 1, v + 1});
    }
  }
  return shape;
}

/// In one plane, or nearly.
MeshFile sheets(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const int n = std::max(1, root(power(genes[0], 2, triangles) / 2));
  const double apart = genes[1] < 0.3 ? 0 : power(genes[1], 1e-8, 0.1);
  Shape shape;
  for (int i = 0; i < std::max(1, triangles / (2 * n * n)); ++i) {
    const Vec3 way(random.between(-0.5, 0.5), random.between(-0.5, 0.5), apart * random.between(-1, 1));
    const double turn = random.between(0, genes[2] * kTurn);
    shape.add(grid(n, [&](double u, double v) {
      return way + Vec3(u * std::cos(turn) - v * std::sin(turn), u * std::sin(turn) + v * std::cos(turn), 0);
    }));
  }
  return fileOf(std::move(shape), genes[3]);
}

MeshFile comb(Genes genes, int triangles) {
  const int n = static_cast<int>(power(genes[1], 1, 4));
  const int teeth = std::max(1, triangles / (12 * n * n));
  const double pitch = 1.0 / teeth;
  Shape shape;
  for (int i = 0; i < teeth; ++i) {
    shape.add(shapes::box({pitch * real(genes[0], 0.1, 1.1), power(genes[2], 0.01, 10), 0.02}, n), {pitch * i, 0, 0});
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Rows of large triangles over small ones that meet them along one side.
MeshFile junctions(Genes genes, int triangles) {
  const int small = static_cast<int>(power(genes[0], 1, triangles));
  const double off = genes[1] < 0.5 ? 0 : power(genes[1], 1e-10, 1e-3);
  Shape shape;
  for (int row = 0; static_cast<int>(shape.triangles.size()) < triangles; ++row) {
    const double z = row * real(genes[2], 0, 0.1);
    addTriangle(shape, {0, 0, z}, {1, 0, z}, {0.5, 1, z});
    for (int i = 0; i < small; ++i) {
      addTriangle(shape, {1.0 * i / small, -off, z}, {(i + 0.5) / small, -0.1, z}, {(i + 1.0) / small, -off, z});
    }
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Pages that share an edge.
MeshFile book(Genes genes, int triangles) {
  const int pages = static_cast<int>(power(genes[0], 3, triangles));
  Shape shape;
  for (int first = 0; first < triangles; first += pages) {
    const auto spine = static_cast<std::uint32_t>(shape.vertices.size());
    const double x = genes[1] * first / pages;
    shape.vertices.insert(shape.vertices.end(), {Vec3f(x, 0, 0), Vec3f(x, 0, real(genes[2], 1e-4, 1))});
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(pages); ++i) {
      shape.vertices.emplace_back(Vec3(x + std::cos(kTurn * i / pages), std::sin(kTurn * i / pages), 0.5));
      shape.triangles.push_back({spine, spine + 1, spine + 2 + i});
    }
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Triangles as small as 10^-decades of the largest, near one place.
MeshFile scales(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const double decades = real(genes[0], 0, 35);
  Shape shape;
  for (int i = 0; i < triangles; ++i) {
    const Vec3 middle = std::pow(10, -decades * random.between(0, 1)) * inCube(random);
    const double size = power(genes[1], 0.01, 1) * glm::length(middle);
    const auto corner = [&] { return middle + size * inCube(random); };
    addTriangle(shape, corner(), corner(), corner());
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Tetrahedra that hang on to nothing, and a few triangles across all of them.
MeshFile bits(Genes genes, int triangles) {
  const int n = std::max(1, static_cast<int>(std::cbrt(triangles / 4.0)));
  const double size = real(genes[0], 0.01, 1.5) / n;
  Shape shape;
  for (int i = 0; i < n * n * n; ++i) {
    const Vec3 at = Vec3(i % n, i / n % n, i / n / n) / static_cast<double>(n);
    const auto first = static_cast<std::uint32_t>(shape.vertices.size());
    for (const Vec3 corner : {Vec3(0), Vec3(size, 0, 0), Vec3(0, size, 0), Vec3(0, 0, size)}) {
      shape.vertices.emplace_back(at + corner);
    }
    shape.triangles.insert(shape.triangles.end(), {{first, first + 2, first + 1},
                                                   {first, first + 1, first + 3},
                                                   {first, first + 3, first + 2},
                                                   {first + 1, first + 2, first + 3}});
  }
  Random random = randomOf(genes[2]);
  for (int i = static_cast<int>(genes[1] * genes[1] * triangles / 10); i > 0; --i) {
    addTriangle(shape, inCube(random), inCube(random), inCube(random));
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Sheets whose cells are long and thin, straight or slanted.
MeshFile slivers(Genes genes, int triangles) {
  const int n = root(triangles / 2.0);
  const double thin = power(genes[0], 1e-7, 1);
  const double slant = genes[1], wave = genes[2];
  return fileOf(
      grid(n,
           [&](double u, double v) { return Vec3(u + slant * v, v * thin, wave * std::sin(7 * u) * std::cos(9 * v)); }),
      genes[3]);
}

/// A band, turned half round or more often, whose ends meet the wrong way round.
MeshFile moebius(Genes genes, int triangles) {
  const int across = static_cast<int>(power(genes[0], 1, 64));
  const int along = std::max(3, triangles / 2 / across);
  const double halves = 1 + 2 * std::floor(genes[1] * 20);
  const double width = real(genes[2], 0.01, 1.2);
  Shape shape;
  for (int i = 0; i < along; ++i) {
    const double angle = kTurn * i / along;
    for (int j = 0; j <= across; ++j) {
      const double side = width * (2.0 * j / across - 1);
      const double r = 1 + side * std::cos(halves * angle / 2);
      shape.vertices.emplace_back(Vec3(r * std::cos(angle), r * std::sin(angle), side * std::sin(halves * angle / 2)));
    }
  }
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>(i < along ? i * (across + 1) + j : across - j);
  };
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      shape.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      shape.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Few triangles, each many times.
MeshFile same(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const int different = static_cast<int>(power(genes[0], 1, triangles));
  Shape shape;
  for (int i = 0; i < different; ++i) addTriangle(shape, inCube(random), inCube(random), inCube(random));
  for (int i = different; i < triangles; ++i) {
    const auto again = shape.triangles[static_cast<std::size_t>(i % different)];
    shape.triangles.push_back(genes[1] < 0.5 ? again : std::array{again[1], again[0], again[2]});
  }
  return fileOf(std::move(shape), genes[3]);
}

/// Corners along a line, or as far off it as makes area.
MeshFile line(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const double off = power(genes[0], 1e-12, 1e-2);
  const Vec3 along = genes[1] < 0.3 ? Vec3(1, 0, 0) : glm::normalize(Vec3(1, genes[1], 0.3));
  Shape shape;
  for (int i = 0; i < triangles; ++i) {
    const auto corner = [&] { return along * random.between(0, 1) + off * inCube(random); };
    addTriangle(shape, corner(), corner(), corner());
  }
  return fileOf(std::move(shape), genes[3]);
}

/// From one small place to another.
MeshFile bundle(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const double small = power(genes[0], 1e-8, 1e-1);
  const double step = genes[1];
  Shape shape;
  for (int i = 0; i < triangles; ++i) {
    const Vec3 end(1, step * random.below(5), 0);
    addTriangle(shape, small * inCube(random), end + small * inCube(random), end + small * inCube(random));
  }
  return fileOf(std::move(shape), genes[3]);
}

/// A closed surface that passes through itself all over.
MeshFile crumpled(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const int n = std::max(1, root(triangles / 12.0));
  const double far = power(genes[0], 0.1, 100) / n;
  const double part = power(genes[1], 0.001, 1);
  Shape shape = shapes::sphere(1, n);
  for (Vec3f& v : shape.vertices) {
    if (random.between(0, 1) < part) v += Vec3f(far * inCube(random));
  }
  return fileOf(std::move(shape), genes[3]);
}

/// A plate with dents that come out on its other side.
MeshFile dented(Genes genes, int triangles) {
  const int n = std::max(2, root(triangles / 12.0));
  const double pitch = power(genes[0], 6, 60) / n;
  const double thick = 0.5 / n;
  const double deep = thick * real(genes[1], 0.8, 3);
  const double wide = pitch * real(genes[2], 0.1, 0.5);
  return fileOf(shapes::box({1, 1, thick}, n).mapped([&](Vec3 v) {
    if (v.z <= 0) return v;
    const double x = v.x - pitch * std::round(v.x / pitch), y = v.y - pitch * std::round(v.y / pitch);
    return v - Vec3(0, 0, deep * std::exp(-(x * x + y * y) / (wide * wide)));
  }),
                genes[3]);
}

/// Outlines of up to 1,000 corners that turn both ways.
MeshFile outlines(Genes genes, int triangles) {
  Random random = randomOf(genes[2]);
  const int corners = static_cast<int>(power(genes[0], 4, 1001));
  std::vector<Vec3f> vertices;
  std::vector<std::vector<std::uint32_t>> polygons;
  for (int i = 0; i < std::max(1, triangles / std::max(1, corners - 2)); ++i) {
    polygons.emplace_back();
    const double turns = genes[1] < 0.5 ? 1 : std::floor(1 + 9 * genes[1]);
    for (int k = 0; k < corners; ++k) {
      const double angle = kTurn * turns * k / corners;
      const double r = genes[3] < 0.5 ? (k % 2 == 0 ? 1 : genes[3] * 2) : random.between(genes[3], 1);
      polygons.back().push_back(static_cast<std::uint32_t>(vertices.size()));
      vertices.emplace_back(Vec3(r * std::cos(angle), r * std::sin(angle), i));
    }
  }
  return fileOf(vertices, polygons);
}

constexpr std::array kFamilies{
    ImportFamily{"soup", "triangles anywhere, short to long, flat or not", soup},
    ImportFamily{"needles", "thin triangles from a plane to another", needles},
    ImportFamily{"fan", "all triangles about two vertices", fan},
    ImportFamily{"hubs", "cones in a row, each within the next", hubs},
    ImportFamily{"coincident", "many corners at few places", coincident},
    ImportFamily{"shells", "nested spheres", shells},
    ImportFamily{"sheets", "sheets in one plane or nearly", sheets},
    ImportFamily{"comb", "boxes in a row", comb},
    ImportFamily{"junctions", "sides that many vertices lie on", junctions},
    ImportFamily{"book", "pages that share an edge", book},
    ImportFamily{"scales", "sizes over up to 35 decades", scales},
    ImportFamily{"bits", "a lattice of tetrahedra", bits},
    ImportFamily{"slivers", "sheets of long thin cells", slivers},
    ImportFamily{"moebius", "bands with one side", moebius},
    ImportFamily{"same", "few triangles, each many times", same},
    ImportFamily{"line", "corners along a line", line},
    ImportFamily{"bundle", "from one place to a few", bundle},
    ImportFamily{"crumpled", "closed surfaces that pass through themselves all over", crumpled},
    ImportFamily{"dented", "plates with dents that come out on the other side", dented},
    ImportFamily{"outlines", "polygons of up to 1,000 corners that turn both ways", outlines},
};

}  // namespace

std::span<const ImportFamily> importFamilies() { return kFamilies; }

const ImportFamily& findImportFamily(std::string_view name) {
  const auto* found = std::ranges::find(kFamilies, name, &ImportFamily::name);
  if (found != kFamilies.end()) return *found;
  std::string known;
  for (const ImportFamily& family : kFamilies) known += (known.empty() ? "" : ", ") + std::string(family.name);
  throw std::invalid_argument("there is no family " + std::string(name) + "; there are " + known);
}

}  // namespace haptics::eval
