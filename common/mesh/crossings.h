#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Where a mesh passes through itself: pairs of triangles of which a side of one pierces the other. A side that ends at
/// a vertex of the other does not pierce it. Metres.
class CrossingSearch {
 public:
  using Pair = std::array<std::uint32_t, 2>;

  /// Keeps the mesh by reference.
  explicit CrossingSearch(const TriMesh& mesh);

  /// To be called when vertices of these triangles were moved.
  void refit(std::span<const std::uint32_t> triangles);
  /// All pairs, each once, in no particular order. None when slivers across the whole mesh would make the search take
  /// more than a few seconds.
  [[nodiscard]] std::optional<std::vector<Pair>> all() const;
  /// Is one of these triangles in such a pair?
  [[nodiscard]] bool any(std::span<const std::uint32_t> triangles) const;

 private:
  struct Box {
    Vec3f low;
    Vec3f high;

    [[nodiscard]] bool meets(const Box& other) const noexcept {
      return low.x <= other.high.x && low.y <= other.high.y && low.z <= other.high.z && other.low.x <= high.x &&
             other.low.y <= high.y && other.low.z <= high.z;
    }
  };
  class PairWalk;

  void fit(std::size_t node);
  [[nodiscard]] Box boxOf(std::uint32_t triangle) const;
  [[nodiscard]] bool cross(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] bool pierces(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] std::span<const std::uint32_t> leaf(std::size_t node) const;

  const TriMesh& mesh_;
  std::vector<std::uint32_t> order_;  // triangles along a Morton curve, kLeaf to a leaf
  std::vector<std::uint32_t> place_;  // of each triangle in that order
  std::size_t leaves_;                // a power of two
  std::vector<Box> nodes_;            // a complete binary tree: the children of i are 2 i and 2 i + 1
};

}  // namespace haptics
