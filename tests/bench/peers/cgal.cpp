#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/version.h>

#include <cmath>

#include "tests/bench/peers/peers.h"

namespace haptics::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Triangles trianglesOf(const TriMesh& mesh) {
  const auto point = [&](std::uint32_t v) { return Point(mesh.vertices[v].x, mesh.vertices[v].y, mesh.vertices[v].z); };
  Triangles triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto [a, b, c] : mesh.triangles) triangles.emplace_back(point(a), point(b), point(c));
  return triangles;
}

}  // namespace

struct Cgal::Tree {
  explicit Tree(const TriMesh& mesh) : triangles(trianglesOf(mesh)), tree(triangles.begin(), triangles.end()) {
    tree.do_not_accelerate_distance_queries();  // the hint makes its search tree needless
    tree.build();
  }
  Triangles triangles;
  AabbTree tree;
};

Cgal::Cgal(const TriMesh& mesh) : tree_(std::make_shared<const Tree>(mesh)) {}
std::string Cgal::version() { return CGAL_VERSION_STR; }

Contestants Cgal::closest(std::span<const Vec3> places) const {
  const auto lap = [tree = tree_, places] {
    Point before = tree->triangles.front().vertex(0);
    double sum = 0;
    for (const Vec3 h : places) {
      const Point place(h.x, h.y, h.z);
      before = tree->tree.closest_point(place, before);
      sum += std::sqrt(CGAL::squared_distance(place, before));
    }
    return sum / static_cast<double>(places.size());
  };
  return {{"cgal_closest_point", lap}};
}

}  // namespace haptics::bench
