#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// All triangles of a scene at rest, in the world, without any connectivity: what the judges of the walk ask. Shares no
/// code with the production database. Metres.
class TriangleSoup {
 public:
  static constexpr int kMaxBodies = 8;
  struct Face {
    std::array<Vec3, 3> corner;
    Vec3 normal;      ///< Unit, outward.
    double offset_m;  ///< normal . corner
    int body;
    bool sheet;  ///< Of a body that has no inside; both of its sides can be touched.
  };

  /// At most kMaxBodies. A body whose every edge joins two triangles that run along it in opposite directions has an
  /// inside.
  void add(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles, const Pose& pose);
  /// To be called once, after all bodies were added.
  void finish();

  [[nodiscard]] std::span<const Face> faces() const { return faces_; }
  [[nodiscard]] double extent_m() const { return extent_; }  ///< Largest distance of a corner from the origin.
  [[nodiscard]] double meanEdge_m() const;

  /// Calls visit(face) for all faces whose own box meets this one, and some more.
  template <class Visit>
  void visitBox(Vec3 low, Vec3 high, Visit visit) const;

  /// Does a body wind around the point and is all of its surface farther than `skin` (m) from it?
  [[nodiscard]] bool isInside(Vec3 point, double skin) const;

 private:
  struct Node {
    Vec3 low, high;
    std::uint32_t begin = 0;  // of the faces
    std::uint32_t end = 0;
    std::uint32_t second = 0;  // child; the first follows its parent; 0 in a leaf
  };
  using Windings = std::array<int, kMaxBodies>;
  void split(std::uint32_t begin, std::uint32_t end);
  [[nodiscard]] Windings windings(Vec3 point, Vec3 direction) const;
  [[nodiscard]] bool isNear(Vec3 point, int body, double distance) const;

  std::vector<Face> faces_;
  std::vector<Node> nodes_;
  double extent_ = 0;
  int bodies_ = 0;
};

template <class Visit>
void TriangleSoup::visitBox(Vec3 low, Vec3 high, Visit visit) const {
  std::array<std::uint32_t, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    if (glm::any(glm::lessThan(node.high, low)) || glm::any(glm::greaterThan(node.low, high))) continue;
    if (node.second == 0) {
      for (std::uint32_t f = node.begin; f < node.end; ++f) visit(faces_[f]);
    } else {
      stack[depth++] = node.second;
      stack[depth++] = index + 1;
    }
  }
}

}  // namespace haptics::eval
