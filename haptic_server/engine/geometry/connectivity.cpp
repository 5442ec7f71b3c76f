#include "haptic_server/engine/geometry/connectivity.h"

#include <algorithm>

#include "common/interruption/grow.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {
namespace {

using Triangles = std::span<const std::array<std::uint32_t, 3>>;

/// An edge as one of its triangles runs along it, filed under its smaller vertex: its larger vertex above its code, which
/// is twice (3 t + k), plus 1 when it runs from the larger to the smaller vertex.
using HalfEdge = std::uint64_t;

std::uint32_t larger(HalfEdge edge) { return static_cast<std::uint32_t>(edge >> 32); }
std::uint32_t code(HalfEdge edge) { return static_cast<std::uint32_t>(edge); }

void pairUp(std::span<HalfEdge> bucket, std::vector<std::uint32_t>& neighbours) {
  std::sort(bucket.begin(), bucket.end());
  for (std::size_t i = 0; i < bucket.size();) {
    std::size_t last = i + 1;
    while (last < bucket.size() && larger(bucket[last]) == larger(bucket[i])) ++last;
    const bool opposite = last - i == 2 && ((bucket[i] ^ bucket[i + 1]) & 1U) != 0;
    if (opposite) {
      const std::uint32_t a = code(bucket[i]) / 2;
      const std::uint32_t b = code(bucket[i + 1]) / 2;
      neighbours[a] = b / 3;
      neighbours[b] = a / 3;
    }
    i = last;
  }
}

}  // namespace

std::vector<std::uint32_t> findNeighbours(std::size_t vertexCount, Triangles triangles) {
  const std::size_t edges = 3 * triangles.size();
  std::vector<std::uint32_t> offset(vertexCount + 1, 0);
  const auto visitEdges = [&](auto visit) {
    forEach(triangles.size(), [&](std::size_t t) {
      const auto& [a, b, c] = triangles[t];
      const auto code = static_cast<std::uint32_t>(6 * t);
      visit(a, b, code);
      visit(b, c, code + 2);
      visit(c, a, code + 4);
    });
  };
  visitEdges([&](std::uint32_t a, std::uint32_t b, std::uint32_t) { ++offset[std::min(a, b) + 1]; });
  for (std::size_t v = 0; v < vertexCount; ++v) offset[v + 1] += offset[v];
  interruptionPoint();
  std::vector<HalfEdge> filed;
  growTo(filed, edges);
  std::vector<std::uint32_t> next(offset.begin(), offset.end() - 1);
  visitEdges([&](std::uint32_t a, std::uint32_t b, std::uint32_t code) {
    filed[next[std::min(a, b)]++] = HalfEdge{std::max(a, b)} << 32 | code | (a > b ? 1 : 0);
  });
  std::vector<std::uint32_t> neighbours;
  growTo(neighbours, edges, kNoTriangle);
  forEach(vertexCount,
          [&](std::size_t v) { pairUp(std::span(filed).subspan(offset[v], offset[v + 1] - offset[v]), neighbours); });
  return neighbours;
}

std::vector<std::uint8_t> findOpenVertices(std::size_t vertexCount, Triangles triangles,
                                           std::span<const std::uint32_t> neighbours) {
  std::vector<std::uint32_t> valence(vertexCount, 0);
  std::vector<std::uint32_t> any(vertexCount, kNoTriangle);
  forEach(triangles.size(), [&](std::size_t t) {
    for (const std::uint32_t v : triangles[t]) {
      ++valence[v];
      any[v] = static_cast<std::uint32_t>(t);
    }
  });
  std::vector<std::uint8_t> open(vertexCount, 0);
  forEach(vertexCount, [&](std::size_t v) {
    std::uint32_t turned = 0;
    std::uint32_t t = any[v];
    while (t != kNoTriangle) {
      const auto& corners = triangles[t];
      const auto k = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
      t = neighbours[3 * std::size_t{t} + k];
      ++turned;
      if (t == any[v]) break;
    }
    open[v] = t != kNoTriangle && turned == valence[v] ? 0 : 1;
  });
  return open;
}

}  // namespace haptics
