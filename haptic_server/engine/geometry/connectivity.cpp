#include "haptic_server/engine/geometry/connectivity.h"

#include <algorithm>

#include "common/interruption/grow.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {
namespace {

using Triangles = std::span<const std::array<std::uint32_t, 3>>;

/// An edge as one of its triangles runs along it, filed under its smaller vertex.
struct HalfEdge {
  std::uint32_t larger;  // vertex
  std::uint32_t code;    // twice (3 t + k), plus 1 when it runs from the larger to the smaller vertex
};

std::uint32_t start(Triangles triangles, std::size_t edge) { return triangles[edge / 3][edge % 3]; }
std::uint32_t end(Triangles triangles, std::size_t edge) {
  return triangles[edge / 3][static_cast<std::size_t>(nextCorner(static_cast<int>(edge % 3)))];
}

void pairUp(std::span<HalfEdge> bucket, std::vector<std::uint32_t>& neighbours) {
  std::sort(bucket.begin(), bucket.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.larger != b.larger ? a.larger < b.larger : a.code < b.code;
  });
  for (std::size_t i = 0; i < bucket.size();) {
    std::size_t last = i + 1;
    while (last < bucket.size() && bucket[last].larger == bucket[i].larger) ++last;
    const bool opposite = last - i == 2 && ((bucket[i].code ^ bucket[i + 1].code) & 1U) != 0;
    if (opposite) {
      const std::uint32_t a = bucket[i].code / 2;
      const std::uint32_t b = bucket[i + 1].code / 2;
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
  for (std::size_t e = 0; e < edges; ++e) {
    interruptionPoint();
    ++offset[std::min(start(triangles, e), end(triangles, e)) + 1];
  }
  for (std::size_t v = 0; v < vertexCount; ++v) offset[v + 1] += offset[v];
  interruptionPoint();
  std::vector<HalfEdge> filed;
  growTo(filed, edges);
  std::vector<std::uint32_t> next(offset.begin(), offset.end() - 1);
  for (std::size_t e = 0; e < edges; ++e) {
    interruptionPoint();
    const std::uint32_t a = start(triangles, e);
    const std::uint32_t b = end(triangles, e);
    filed[next[std::min(a, b)]++] = {std::max(a, b), static_cast<std::uint32_t>(2 * e + (a > b ? 1 : 0))};
  }
  interruptionPoint();
  std::vector<std::uint32_t> neighbours;
  growTo(neighbours, edges, kNoTriangle);
  for (std::size_t v = 0; v < vertexCount; ++v) {
    interruptionPoint();
    pairUp(std::span(filed).subspan(offset[v], offset[v + 1] - offset[v]), neighbours);
  }
  return neighbours;
}

std::vector<std::uint8_t> findOpenVertices(std::size_t vertexCount, Triangles triangles,
                                           std::span<const std::uint32_t> neighbours) {
  std::vector<std::uint32_t> valence(vertexCount, 0);
  std::vector<std::uint32_t> any(vertexCount, kNoTriangle);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    interruptionPoint();
    for (const std::uint32_t v : triangles[t]) {
      ++valence[v];
      any[v] = t;
    }
  }
  interruptionPoint();
  std::vector<std::uint8_t> open(vertexCount, 0);
  for (std::uint32_t v = 0; v < vertexCount; ++v) {
    interruptionPoint();
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
  }
  return open;
}

}  // namespace haptics
