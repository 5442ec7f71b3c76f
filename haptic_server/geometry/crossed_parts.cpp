#include <algorithm>
#include <atomic>
#include <thread>

#include "haptic_server/geometry/surface.h"

namespace haptics {
namespace {

/// Triangles tested, for the mesh and for each of its triangles, before the whole mesh is taken for crossed: 0.3 s at
/// least. A sane mesh needs about 10 each, slivers across the whole mesh need thousands. Too small costs speed on such
/// meshes, never safety.
constexpr std::int64_t kMostTests = 1 << 25;
constexpr std::int64_t kMostTestsEach = 64;
/// A triangle that shares a vertex with the edge is passed over, at a fraction of a test's cost: in a fan all of them
/// meet.
constexpr std::int64_t kPassesPerTest = 16;

using Marks = std::vector<std::atomic<bool>>;

/// Where the lines of some triangles pierce triangles that they share no vertex with.
class CrossedSearch {
 public:
  CrossedSearch(const Surface& surface, Marks& marks) : surface_(surface), marks_(marks) {}

  /// Looks at the lines of triangles [begin, end) and takes the cost from `left`, in passes, until there is none left.
  void run(std::uint32_t begin, std::uint32_t end, std::atomic<std::int64_t>& left) {
    for (std::uint32_t t = begin; t < end && left > 0; ++t) {
      spent_ = 0;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t across = surface_.triangle(t).neighbour(k);
        if (across == kNoTriangle || across > t) follow(t, k);  // else the line was looked at from its other polygon
      }
      left -= spent_;
    }
  }

 private:
  void follow(std::uint32_t t, int k) {
    const TriangleRecord& own = surface_.triangle(t);
    const Vec3 from = own.corner(k);
    const Vec3 to = own.corner(nextCorner(k));
    const std::uint32_t a = own.vertexAt(k);
    const std::uint32_t b = own.vertexAt(nextCorner(k));
    const Segment edge(from, to);
    surface_.hierarchy().visitAlong(from, to, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t other = first; other < last; ++other) {
        const TriangleRecord& r = surface_.triangle(other);
        ++spent_;
        if (r.cornerOf(a) >= 0 || r.cornerOf(b) >= 0) continue;
        spent_ += kPassesPerTest;
        Crossing crossing;
        if (!edge.enters(r, true, crossing)) continue;
        for (const std::uint32_t crossed : {t, other, own.neighbour(k)}) {
          if (crossed != kNoTriangle) marks_[crossed].store(true, std::memory_order_relaxed);
        }
      }
      return 1.0;
    });
  }

  const Surface& surface_;
  Marks& marks_;
  std::int64_t spent_ = 0;  // passes
};

}  // namespace

void Surface::markCrossed(int threads) {
  constexpr std::uint32_t kPiece = 4096;  // triangles that a thread takes at a time
  Marks marks(triangleCount());
  std::atomic<std::uint32_t> next{0};
  std::atomic<std::int64_t> left{(kMostTests + kMostTestsEach * triangleCount()) * kPassesPerTest};
  const auto work = [&] {
    CrossedSearch search(*this, marks);
    for (std::uint32_t t = next.fetch_add(kPiece); t < triangleCount(); t = next.fetch_add(kPiece)) {
      search.run(t, std::min(triangleCount(), t + kPiece), left);
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < threads && triangleCount() > kPiece; ++i) helpers.emplace_back(work);
    work();
  }
  const bool all = left <= 0;  // the sum of all costs, whatever the threads
  for (std::uint32_t t = 0; t < triangleCount(); ++t) {
    if (!all && !marks[t]) continue;
    records_[t].flags |= TriangleRecord::kCrossed;
    anyCrossed_ = true;
  }
}

}  // namespace haptics
