// What real files hold: S11. Through the production import, as a file would come in.

#include <algorithm>
#include <limits>

#include "common/mesh/import.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

using shapes::Shape;

constexpr double kHalfEdge_m = 0.05;

struct Defect {
  void (*make)(Shape& cube);
  /// Did the import say so?
  bool (*reported)(const MeshReport& report);
  double reach;  ///< Metres from the middle of each side to where it is felt as if nothing were wrong.
};

Shape cube() { return shapes::box(Vec3(2 * kHalfEdge_m), 8); }

/// A triangle at the cube's corner (+, +, +).
std::size_t atCorner(const Shape& shape) {
  const auto t = std::find_if(shape.triangles.begin(), shape.triangles.end(), [&](const TriangleIndices& triangle) {
    return std::any_of(triangle.begin(), triangle.end(),
                       [&](std::uint32_t v) { return shape.vertices[v] == Vec3f(static_cast<float>(kHalfEdge_m)); });
  });
  return static_cast<std::size_t>(t - shape.triangles.begin());
}

void removeOne(Shape& shape) {
  shape.triangles.erase(shape.triangles.begin() + static_cast<std::ptrdiff_t>(atCorner(shape)));
}

void addFin(Shape& shape) {
  const TriangleIndices root = shape.triangles[atCorner(shape)];
  const auto tip = static_cast<std::uint32_t>(shape.vertices.size());
  shape.vertices.emplace_back(0.07F, 0.07F, 0.07F);
  shape.triangles.push_back({root[0], root[1], tip});
}

void duplicateSome(Shape& shape) {
  const std::size_t count = shape.triangles.size();
  for (std::size_t t = 0; t < count; t += 5) {
    const TriangleIndices again = shape.triangles[t];
    shape.triangles.push_back(again);
  }
}

void flipSome(Shape& shape) {
  for (std::size_t t = 0; t < shape.triangles.size(); t += 7) std::swap(shape.triangles[t][0], shape.triangles[t][1]);
}

/// Cuts every third triangle in two across its first edge, which its neighbour does not know of.
void cutSome(Shape& shape, bool fillJoint) {
  const std::vector<TriangleIndices> whole = shape.triangles;
  shape.triangles.clear();
  for (std::size_t t = 0; t < whole.size(); ++t) {
    const TriangleIndices& v = whole[t];
    if (t % 3 != 0) {
      shape.triangles.push_back(v);
      continue;
    }
    const auto middle = static_cast<std::uint32_t>(shape.vertices.size());
    shape.vertices.push_back((shape.vertices[v[0]] + shape.vertices[v[1]]) * 0.5F);
    shape.triangles.push_back({v[0], middle, v[2]});
    shape.triangles.push_back({middle, v[1], v[2]});
    if (fillJoint) shape.triangles.push_back({v[0], v[1], middle});  // without area
  }
}

void unweld(Shape& shape) {
  const Shape welded = shape;
  shape = {};
  for (const TriangleIndices& t : welded.triangles) {
    const auto first = static_cast<std::uint32_t>(shape.vertices.size());
    for (const std::uint32_t v : t) shape.vertices.push_back(welded.vertices[v]);
    shape.triangles.push_back({first, first + 1, first + 2});
  }
}

constexpr std::array kDefects{
    Defect{removeOne, [](const MeshReport& r) { return r.boundaryEdges == 3; }, 0.035},
    Defect{[](Shape& s) { cutSome(s, false); }, [](const MeshReport& r) { return r.boundaryEdges > 0; }, 0.045},
    Defect{addFin, [](const MeshReport& r) { return r.nonManifoldEdges == 1; }, 0.035},
    Defect{duplicateSome, [](const MeshReport& r) { return r.duplicateFaces > 0; }, 0.045},
    Defect{flipSome, [](const MeshReport& r) { return r.inconsistentEdges > 0; }, 0.045},
    Defect{[](Shape& s) { cutSome(s, true); }, [](const MeshReport& r) { return r.droppedDegenerate > 0; }, 0.045},
    Defect{unweld, [](const MeshReport& r) { return r.verticesWelded > 0 && r.closed(); }, 0.045},
};

Result<ImportedMesh> import(const Shape& shape) {
  return canonicalise({shape.vertices.begin(), shape.vertices.end()}, shape.triangles, {});
}

/// Presses every side of the cube, strokes along it and lets go; ticks in which it is not felt as a whole cube would be.
int wrongTicks(Stage& stage, double reach, Random& random) {
  constexpr double kDepth = 0.003;
  int wrong = 0;
  for (int side = 0; side < 6; ++side) {
    const int axis = side % 3;
    const double end = side < 3 ? 1.0 : -1.0;
    const auto at = [&](double a, double b, double height) {
      Vec3 p;
      p[axis] = end * (kHalfEdge_m + height);
      p[(axis + 1) % 3] = a;
      p[(axis + 2) % 3] = b;
      return p;
    };
    const auto check = [&](const Felt& felt, Vec3 hip) {
      Vec3 expected = hip;
      expected[axis] = end * kHalfEdge_m;
      wrong += felt.touching && glm::distance(felt.ihip, expected) < kInside_m ? 0 : 1;
    };
    Vec3 from = at(0.001, 0.002, -kDepth);
    stage.place(at(0.001, 0.002, kDepth));
    check(stage.tick(from), from);
    for (int stroke = 0; stroke < 5; ++stroke) {
      const Vec3 to = at(random.between(-reach, reach), random.between(-reach, reach), -kDepth);
      stage.lead(from, to, 0.0013, check);
      from = to;
    }
    from[axis] = end * (kHalfEdge_m + kDepth);
    wrong += stage.tick(from).touching ? 1 : 0;
  }
  return wrong;
}

}  // namespace

SceneResult strokeBadMeshes(Renderer& method, Random& random) {
  int unreported = 0;
  int wrong = 0;
  int ticks = 0;
  for (const Defect& defect : kDefects) {
    Shape shape = cube();
    defect.make(shape);
    const auto imported = import(shape);
    if (!imported || !defect.reported(imported->report)) {
      ++unreported;
      continue;
    }
    Stage stage(method, random);
    stage.add(buildCollisionMesh(imported->mesh.vertices, imported->mesh.triangles));
    stage.begin(Vec3(0, 0, 4 * kHalfEdge_m));
    wrong += wrongTicks(stage, defect.reach, random);
    ticks += stage.ticks();
  }
  Shape broken = cube();
  broken.vertices[7].y = std::numeric_limits<float>::quiet_NaN();
  const bool refused = !import(broken);
  return {{{"ticks", ticks},
           {"defects", kDefects.size()},
           {"unreported_defects", unreported},
           {"nan_vertex_refused", refused},
           {"wrong_ticks_away_from_defects", wrong}},
          unreported == 0 && refused && wrong == 0};
}

}  // namespace haptics::eval
