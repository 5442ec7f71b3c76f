#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/error/error.h"
#include "common/mesh/polygon_soup.h"

namespace haptics {

/// Why a vertex cannot be one of a face's: "is not finite" or "does not fit into float32"; null if it can.
[[nodiscard]] const char* faultOf(const Vec3& vertex);

/// Adds a face whose vertices are there. Refused, naming the vertex, if one of them cannot be used.
/// @param line   Where the face is in a text; 0 elsewhere.
/// @param corners  As PolygonSoup::addPolygon() takes them.
[[nodiscard]] Result<void> addFace(std::span<const std::uint32_t> corners, std::uint64_t line, PolygonSoup& soup);

/// Faces of a file whose vertices may come later.
class FaceList {
 public:
  /// Of the face that is being read. Counted from 0; one that cannot be there is out of range later on.
  void addCorner(std::int64_t vertex) {
    const bool mayBe = vertex >= 0 && vertex < std::int64_t{std::numeric_limits<std::uint32_t>::max()};
    corners_.push_back(mayBe ? static_cast<std::uint32_t>(vertex) : std::numeric_limits<std::uint32_t>::max());
  }
  void endFace(std::uint64_t line) {
    faces_.push_back({corners_.size() - cornersBefore_, line});
    cornersBefore_ = corners_.size();
  }
  [[nodiscard]] bool empty() const { return faces_.empty(); }

  /// Adds all of them. Refused as addFace().
  [[nodiscard]] Result<void> addTo(PolygonSoup& soup) const;

 private:
  struct Face {
    std::size_t corners;
    std::uint64_t line;
  };

  std::vector<std::uint32_t> corners_;
  std::vector<Face> faces_;
  std::size_t cornersBefore_ = 0;
};

}  // namespace haptics
