#include "tests/eval/walk/triangle_soup.h"

#include <algorithm>
#include <utility>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {
namespace {

constexpr std::uint32_t kLeafFaces = 4;

bool isClosed(std::span<const TriangleIndices> triangles) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Edge> edges;
  std::vector<Edge> reversed;
  for (const TriangleIndices& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      edges.emplace_back(t[k], t[(k + 1) % 3]);
      reversed.emplace_back(t[(k + 1) % 3], t[k]);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::sort(reversed.begin(), reversed.end());
  return edges == reversed && std::adjacent_find(edges.begin(), edges.end()) == edges.end();
}

}  // namespace

void TriangleSoup::add(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles, const Pose& pose) {
  const bool sheet = !isClosed(triangles);
  for (const TriangleIndices& t : triangles) {
    Face face{};
    for (std::size_t k = 0; k < 3; ++k) {
      face.corner[k] = toWorld(pose, Vec3(vertices[t[k]]));
      extent_ = std::max(extent_, glm::length(face.corner[k]));
    }
    const Vec3 normal = glm::cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
    if (normal == Vec3(0)) continue;
    face.normal = glm::normalize(normal);
    face.offset_m = glm::dot(face.normal, face.corner[0]);
    face.body = bodies_;
    face.sheet = sheet;
    faces_.push_back(face);
  }
  ++bodies_;
}

void TriangleSoup::finish() { split(0, static_cast<std::uint32_t>(faces_.size())); }

/// Halves at the median of the centres along the widest side.
void TriangleSoup::split(std::uint32_t begin, std::uint32_t end) {
  const std::size_t index = nodes_.size();
  Node node;
  node.low = Vec3(std::numeric_limits<double>::infinity());
  node.high = -node.low;
  node.begin = begin;
  node.end = end;
  for (std::uint32_t f = begin; f < end; ++f) {
    for (const Vec3 v : faces_[f].corner) {
      node.low = glm::min(node.low, v);
      node.high = glm::max(node.high, v);
    }
  }
  nodes_.push_back(node);
  if (end - begin <= kLeafFaces) return;
  const Vec3 size = node.high - node.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto centre = [axis](const Face& f) { return f.corner[0][axis] + f.corner[1][axis] + f.corner[2][axis]; };
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(faces_.begin() + begin, faces_.begin() + middle, faces_.begin() + end,
                   [&](const Face& a, const Face& b) { return centre(a) < centre(b); });
  split(begin, middle);
  nodes_[index].second = static_cast<std::uint32_t>(nodes_.size());
  split(middle, end);
}

double TriangleSoup::meanEdge_m() const {
  double sum = 0;
  for (const Face& f : faces_) {
    for (std::size_t k = 0; k < 3; ++k) sum += glm::distance(f.corner[k], f.corner[(k + 1) % 3]);
  }
  return sum / (3.0 * static_cast<double>(faces_.size()));
}

bool TriangleSoup::isInside(Vec3 point, double skin) const {
  // No coordinate plane, diagonal or other direction that meshes have; a second one when the first finds it inside,
  // should it have met an edge.
  const Vec3 first = glm::normalize(Vec3(0.4142136, 0.7320508, 0.2360680));
  const Vec3 second = glm::normalize(Vec3(-0.6457513, 0.1622777, -0.3166248));
  const Windings one = windings(point, first);
  if (one == Windings{}) return false;
  const Windings two = windings(point, second);
  for (int body = 0; body < bodies_; ++body) {
    const auto i = static_cast<std::size_t>(body);
    if (one[i] != 0 && two[i] != 0 && !isNear(point, body, skin)) return true;
  }
  return false;
}

/// How often each closed body winds around the point: where a ray from it leaves, less where it enters.
TriangleSoup::Windings TriangleSoup::windings(Vec3 point, Vec3 direction) const {
  Windings result{};
  std::array<std::uint32_t, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    const Vec3 a = (node.low - point) / direction;
    const Vec3 b = (node.high - point) / direction;
    const Vec3 enter = glm::min(a, b);
    const Vec3 leave = glm::max(a, b);
    if (std::max({enter.x, enter.y, enter.z, 0.0}) > std::min({leave.x, leave.y, leave.z})) continue;
    if (node.second != 0) {
      stack[depth++] = node.second;
      stack[depth++] = index + 1;
      continue;
    }
    for (std::uint32_t f = node.begin; f < node.end; ++f) {
      const Face& face = faces_[f];
      if (face.sheet) continue;
      const Vec3 ab = face.corner[1] - face.corner[0];
      const Vec3 ac = face.corner[2] - face.corner[0];
      const Vec3 p = glm::cross(direction, ac);
      const double determinant = glm::dot(ab, p);
      if (determinant == 0) continue;
      const Vec3 s = point - face.corner[0];
      const double u = glm::dot(s, p) / determinant;
      const Vec3 q = glm::cross(s, ab);
      const double v = glm::dot(direction, q) / determinant;
      if (u < 0 || v < 0 || u + v > 1 || glm::dot(ac, q) / determinant <= 0) continue;
      result[static_cast<std::size_t>(face.body)] += determinant < 0 ? 1 : -1;
    }
  }
  return result;
}

bool TriangleSoup::isNear(Vec3 point, int body, double distance) const {
  bool near = false;
  visitBox(point - distance, point + distance, [&](const Face& face) {
    near = near || (face.body == body && glm::distance(closestOnTriangle(point, face.corner), point) <= distance);
  });
  return near;
}

}  // namespace haptics::eval
