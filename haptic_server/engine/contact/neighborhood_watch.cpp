#include "haptic_server/engine/contact/neighborhood_watch.h"

#include <algorithm>
#include <array>
#include <limits>

#include "haptic_server/engine/contact/walk_across_lines.h"
#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics {
namespace {

/// The closest foot of some triangles. A triangle without area is as good as a line: what
/// is across its edges is next to the foot too, and is looked at as well.
template <class ClosestPointOf>
class Candidates {
 public:
  Candidates(const CollisionMesh& surface, Vec3 h, const ClosestPoint& from, int& looked,
             ClosestPointOf closestPointOf) noexcept
      : surface_(surface),
        h_(h),
        best_(from),
        asNear_(from.squaredDistance * kSame),
        looked_(looked),
        closestPointOf_(closestPointOf) {
    if (surface_.triangle(from.triangle).zeroArea()) pass(from.triangle);
  }

  void consider(std::uint32_t t) noexcept {
    if (t == kNoTriangle) return;
    ++looked_;
    const ClosestPoint foot = closestPointOf_(surface_.triangle(t), t, h_);
    if (foot.squaredDistance < best_.squaredDistance) best_ = foot;
    if (surface_.triangle(t).zeroArea() && foot.squaredDistance <= asNear_) pass(t);
  }
  [[nodiscard]] const ClosestPoint& best() const noexcept { return best_; }

 private:
  static constexpr double kSame = 1 + 0x1p-40;  // squared distances of one point seen from two triangles
  static constexpr std::size_t kMaxPassed = 16;

  void pass(std::uint32_t t) noexcept {
    const auto end = passed_.begin() + static_cast<std::ptrdiff_t>(passedCount_);
    if (passedCount_ == kMaxPassed || std::find(passed_.begin(), end, t) != end) return;
    passed_[passedCount_++] = t;
    for (int k = 0; k < 3; ++k) consider(surface_.triangle(t).neighbour(k));
  }

  const CollisionMesh& surface_;
  Vec3 h_;
  ClosestPoint best_;
  double asNear_;  // m^2
  int& looked_;
  ClosestPointOf closestPointOf_;
  std::array<std::uint32_t, kMaxPassed> passed_;
  std::size_t passedCount_ = 0;
};

template <class ClosestPointOf>
SearchResult searchAcrossLine(const CollisionMesh& surface, const ClosestPoint& from, Vec3 h, SearchRun& run,
                              ClosestPointOf closestPointOf) noexcept {
  Candidates candidates(surface, h, from, run.looked, closestPointOf);
  candidates.consider(surface.triangle(from.triangle).neighbour(from.index));
  return {candidates.best(), true};
}

template <class ClosestPointOf>
SearchResult searchFan(const CollisionMesh& surface, const ClosestPoint& from, Vec3 h, SearchRun& run,
                       ClosestPointOf closestPointOf) noexcept {
  Candidates candidates(surface, h, from, run.looked, closestPointOf);
  SearchResult result{from, true};
  visitFan(surface, from.triangle, from.index, [&](std::uint32_t t, int corner) noexcept {
    candidates.consider(t);
    result.converged = run.looked < run.budget;
    result.foot.triangle = t;  // where the next tick goes on, should nothing be closer
    result.foot.index = static_cast<std::uint8_t>(corner);
    return result.converged;
  });
  const bool closer = candidates.best().squaredDistance < from.squaredDistance;
  if (closer) return {candidates.best(), result.converged};
  return result.converged ? SearchResult{from, true} : result;
}

/// Paper 3.2, the loop of the pseudocode, with these deviations, without which it does not work:
///  - A polygon's lines and vertices are part of it, so no neighbour of a polygon is strictly closer and the printed
///    loop never leaves its first polygon. The primitive that holds the closest point is therefore taken from the
///    closest point computation itself, ties going to the lower dimension, and only strictly closer neighbours are
///    hopped to. Each hop goes to a triangle that shares that primitive, so that the path is continuous, stays on the
///    surface and ends.
///  - The search has a budget. Distance never grows, so that it may stop at any hop and go on in the next tick.
template <class ClosestPointOf>
SearchResult descend(const CollisionMesh& surface, std::uint32_t start, Vec3 h, SearchRun& run,
                     ClosestPointOf closestPointOf) noexcept {
  ++run.looked;
  ClosestPoint foot = closestPointOf(surface.triangle(start), start, h);
  while (true) {
    run.add(foot.point, foot.triangle);
    if (foot.feature == Feature::kPolygon) return {foot, true};
    if (run.looked >= run.budget) return {foot, false};
    const SearchResult next = foot.feature == Feature::kLine ? searchAcrossLine(surface, foot, h, run, closestPointOf)
                                                             : searchFan(surface, foot, h, run, closestPointOf);
    if (!(next.foot.squaredDistance < foot.squaredDistance)) return next;
    foot = next.foot;
  }
}

}  // namespace

SearchResult neighborhoodWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h, SearchRun& run) noexcept {
  SearchResult found;
  if (walkAcrossLines(surface, start, h, run, found)) return found;
  return descend(surface, start, h, run, [](const TriangleRecord& record, std::uint32_t t, Vec3 at) noexcept {
    return closestOn(record, t, at);
  });
}

SearchResult ablatedWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h, SearchRun& run,
                          const Corrections& corrections) noexcept {
  const auto closestPointOf = corrections.closestPoint != nullptr ? corrections.closestPoint : &closestOn;
  if (!corrections.boundedSearch) run.budget = std::numeric_limits<int>::max();
  if (corrections.featureCodes) return descend(surface, start, h, run, closestPointOf);
  ++run.looked;
  const ClosestPoint foot = closestPointOf(surface.triangle(start), start, h);
  run.add(foot.point, foot.triangle);
  return {foot, true};
}

}  // namespace haptics
