#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh/hole_filling.h"
#include "common/mesh/tri_mesh.h"
#include "common/mesh/work.h"

namespace haptics {

/// Vertices or triangles of a mesh; sorted, each once, where a function takes them.
using Numbers = std::vector<std::uint32_t>;
void makeUnique(Numbers& numbers);

/// The triangles around each vertex of a mesh.
class Fans {
 public:
  explicit Fans(const TriMesh& mesh);
  [[nodiscard]] std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(triangles_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }
  /// None when there are more than so many, or the work does not suffice.
  [[nodiscard]] std::optional<Numbers> around(const Numbers& vertices, std::size_t most, Work& work) const;

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> triangles_;
};

/// The rims of the hole that cutting these triangles out of a closed mesh leaves. None when there is none, when rims
/// touch, when one has more than kMaxCorners, or when the work does not suffice.
[[nodiscard]] std::optional<std::vector<Rim>> rimsOf(const TriMesh& mesh, const Fans& fans, const Numbers& cut,
                                                     Work& work);
/// The triangles inside of a rim, when cutting leaves a small part of the surface there that hangs on to nothing else; else
/// none. Or none, because the work does not suffice.
[[nodiscard]] Numbers islandIn(const TriMesh& mesh, const Fans& fans, const Numbers& cut, std::span<const Rim> rims,
                               std::size_t rim, Work& work);
/// Does a triangle that is not cut have a line from a to b?
[[nodiscard]] bool joinsOutside(const Fans& fans, const TriMesh& mesh, const Numbers& cut, std::uint32_t a,
                                std::uint32_t b, Work& work);

/// A part of a surface, metres.
using Patch = std::vector<std::array<Vec3, 3>>;
[[nodiscard]] Patch patchOf(const std::vector<Vec3f>& vertices, std::span<const TriangleIndices> triangles);
[[nodiscard]] double areaOf(const Patch& patch);
/// Signed, of what lies between it and the origin: of two patches with one rim the difference is what lies between them.
[[nodiscard]] double volumeUnder(const Patch& patch);
/// How far the corners and middles of a patch's triangles are from another one, at most. None when the work does not
/// suffice.
[[nodiscard]] std::optional<double> farthestFrom(const Patch& patch, const Patch& other, Work& work);

}  // namespace haptics
