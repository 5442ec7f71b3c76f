#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace haptics {

/// The triangle across each edge: element 3 t + k for edge k of triangle t, kNoTriangle at a boundary. Two triangles
/// are neighbours only where exactly two run along an edge, in opposite directions; the rule does not depend on the
/// order of the triangles, and a fin, a duplicate or a flipped face becomes a boundary that the contact core's solver
/// holds.
[[nodiscard]] std::vector<std::uint32_t> findNeighbours(std::size_t vertexCount,
                                                        std::span<const std::array<std::uint32_t, 3>> triangles);

/// For each vertex, whether its triangles are anything else than one closed fan: on a boundary, or where parts touch in
/// a point. 1 or 0.
[[nodiscard]] std::vector<std::uint8_t> findOpenVertices(std::size_t vertexCount,
                                                         std::span<const std::array<std::uint32_t, 3>> triangles,
                                                         std::span<const std::uint32_t> neighbours);

}  // namespace haptics
