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

/// Where the edges of some triangles pierce triangles that they share no vertex with.
class CrossedSearch {
 public:
  explicit CrossedSearch(const Surface& surface) : surface_(surface) {}

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
  [[nodiscard]] const std::vector<std::uint32_t>& found() const { return found_; }

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
        found_.insert(found_.end(), {t, other});
        if (own.neighbour(k) != kNoTriangle) found_.push_back(own.neighbour(k));
      }
      return 1.0;
    });
  }

  const Surface& surface_;
  std::int64_t spent_ = 0;  // passes
  std::vector<std::uint32_t> found_;
};

}  // namespace

void Surface::markCrossed(int threads) {
  constexpr std::uint32_t kPiece = 4096;  // triangles that a thread takes at a time
  const std::uint32_t pieces = (triangleCount() + kPiece - 1) / kPiece;
  std::vector<std::vector<std::uint32_t>> found(pieces);
  std::atomic<std::uint32_t> next{0};
  std::atomic<std::int64_t> left{(kMostTests + kMostTestsEach * triangleCount()) * kPassesPerTest};
  const auto work = [&] {
    for (std::uint32_t i = next++; i < pieces; i = next++) {
      CrossedSearch search(*this);
      search.run(i * kPiece, std::min(triangleCount(), (i + 1) * kPiece), left);
      found[i] = search.found();
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < threads && pieces > 1; ++i) helpers.emplace_back(work);
    work();
  }
  for (const std::vector<std::uint32_t>& some : found) {
    for (const std::uint32_t t : some) records_[t].flags |= TriangleRecord::kCrossed;
    anyCrossed_ = anyCrossed_ || !some.empty();
  }
  if (left > 0) return;  // the sum of all costs, whatever the threads
  anyCrossed_ = true;
  for (TriangleRecord& r : records_) r.flags |= TriangleRecord::kCrossed;
}

}  // namespace haptics
