#include <atomic>
#include <thread>

#include "haptic_server/geometry/surface.h"

namespace haptics {
namespace {

/// Triangles looked at per triangle of the mesh before the whole mesh is taken for crossed. A sane mesh needs about 20;
/// slivers across the whole mesh need thousands. Too small costs speed on such meshes, never safety.
constexpr std::uint64_t kMostTests = 256;

struct Found {
  std::vector<std::uint32_t> crossed;
  std::uint64_t tests = 0;
};

/// Where an edge of triangles [begin, end) pierces a triangle that shares no vertex with it.
Found findCrossed(const Surface& surface, std::uint32_t begin, std::uint32_t end) {
  Found found;
  const std::uint64_t most = kMostTests * (end - begin);
  for (std::uint32_t t = begin; t < end && found.tests <= most; ++t) {
    const TriangleRecord& own = surface.triangle(t);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t across = own.neighbour(k);
      if (across != kNoTriangle && across < t) continue;  // the line was looked at from its other polygon
      const Segment edge(own.corner(k), own.corner(nextCorner(k)));
      const std::uint32_t a = own.vertexAt(k);
      const std::uint32_t b = own.vertexAt(nextCorner(k));
      surface.hierarchy().visitAlong(
          own.corner(k), own.corner(nextCorner(k)), [&](std::uint32_t first, std::uint32_t last) {
            found.tests += last - first;
            for (std::uint32_t other = first; other < last; ++other) {
              const TriangleRecord& r = surface.triangle(other);
              Crossing crossing;
              if (r.cornerOf(a) >= 0 || r.cornerOf(b) >= 0 || !edge.enters(r, true, crossing)) continue;
              found.crossed.insert(found.crossed.end(), {t, other});
              if (across != kNoTriangle) found.crossed.push_back(across);
            }
            return found.tests <= most ? 1.0 : 0.0;
          });
    }
  }
  if (found.tests > most) found.crossed.clear();
  return found;
}

}  // namespace

void Surface::markCrossed(int threads) {
  constexpr std::uint32_t kPiece = 4096;  // triangles; fixed, so that the result does not depend on the threads
  const std::uint32_t pieces = (triangleCount() + kPiece - 1) / kPiece;
  std::vector<Found> found(pieces);
  std::atomic<std::uint32_t> next{0};
  const auto work = [&] {
    for (std::uint32_t i = next++; i < pieces; i = next++) {
      found[i] = findCrossed(*this, i * kPiece, std::min(triangleCount(), (i + 1) * kPiece));
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < threads && pieces > 1; ++i) helpers.emplace_back(work);
    work();
  }
  bool all = false;
  for (std::uint32_t i = 0; i < pieces; ++i) {
    all = all || found[i].tests > kMostTests * (std::min(triangleCount(), (i + 1) * kPiece) - i * kPiece);
    for (const std::uint32_t t : found[i].crossed) records_[t].flags |= TriangleRecord::kCrossed;
    anyCrossed_ = anyCrossed_ || !found[i].crossed.empty();
  }
  if (!all) return;
  anyCrossed_ = true;
  for (TriangleRecord& r : records_) r.flags |= TriangleRecord::kCrossed;
}

}  // namespace haptics
