#pragma once

#include <algorithm>

#include "haptic_server/contact/neighborhood_watch.h"
#include "haptic_server/geometry/neighbours.h"

namespace haptics {
namespace detail {

/// Looks at triangles for one that is closer than the foot so far. A triangle without area is as good as a line: what
/// is across its edges is next to the foot too, and is looked at as well.
template <class Corrections>
class Candidates {
 public:
  Candidates(const Surface& surface, Vec3 h, const Foot& from, int& spent) noexcept
      : surface_(surface), h_(h), best_(from), asNear_(from.squaredDistance * kSame), spent_(spent) {
    if (surface_.triangle(from.triangle).zeroArea()) pass(from.triangle);
  }

  void consider(std::uint32_t t) noexcept {
    if (t == kNoTriangle) return;
    ++spent_;
    const Foot foot = Corrections::closestPoint(surface_.triangle(t), t, h_);
    if (foot.squaredDistance < best_.squaredDistance) best_ = foot;
    if (surface_.triangle(t).zeroArea() && foot.squaredDistance <= asNear_) pass(t);
  }
  [[nodiscard]] const Foot& best() const noexcept { return best_; }

 private:
  static constexpr double kSame = 1 + 0x1p-40;  // squared distances of one point seen from two triangles
  static constexpr std::size_t kMostPassed = 16;

  void pass(std::uint32_t t) noexcept {
    const auto end = passed_.begin() + static_cast<std::ptrdiff_t>(passedCount_);
    if (passedCount_ == kMostPassed || std::find(passed_.begin(), end, t) != end) return;
    passed_[passedCount_++] = t;
    for (int k = 0; k < 3; ++k) consider(surface_.triangle(t).neighbour(k));
  }

  const Surface& surface_;
  Vec3 h_;
  Foot best_;
  double asNear_;  // m^2
  int& spent_;
  std::array<std::uint32_t, kMostPassed> passed_;
  std::size_t passedCount_ = 0;
};

template <class Corrections>
constexpr bool withinBudget(int spent, int budget) noexcept {
  return !Corrections::kBoundedSearch || spent < budget;
}

template <class Corrections>
SearchResult searchAcrossLine(const Surface& surface, const Foot& from, Vec3 h, int& spent) noexcept {
  Candidates<Corrections> candidates(surface, h, from, spent);
  candidates.consider(surface.triangle(from.triangle).neighbour(from.index));
  return {candidates.best(), true};
}

template <class Corrections>
SearchResult searchFan(const Surface& surface, const Foot& from, Vec3 h, int& spent, int budget) noexcept {
  Candidates<Corrections> candidates(surface, h, from, spent);
  SearchResult result{from, true};
  visitFan(surface, from.triangle, from.index, [&](std::uint32_t t, int corner) noexcept {
    candidates.consider(t);
    result.converged = withinBudget<Corrections>(spent, budget);
    result.foot.triangle = t;  // where the next tick goes on, should nothing be closer
    result.foot.index = static_cast<std::uint8_t>(corner);
    return result.converged;
  });
  const bool closer = candidates.best().squaredDistance < from.squaredDistance;
  if (closer) return {candidates.best(), result.converged};
  return result.converged ? SearchResult{from, true} : result;
}

}  // namespace detail

/// Paper 3.2, the loop of the pseudocode, with these deviations, without which it does not work:
///  - A polygon's lines and vertices are part of it, so no neighbour of a polygon is strictly closer and the printed
///    loop never leaves its first polygon. The primitive that holds the closest point is therefore taken from the
///    closest point computation itself, ties going to the lower dimension, and only strictly closer neighbours are
///    hopped to. Each hop goes to a triangle that shares that primitive, so that the path is continuous, stays on the
///    surface and ends.
///  - The search has a budget. Distance never grows, so that it may stop at any hop and go on in the next tick.
template <class Corrections>
SearchResult neighborhoodWatch(const Surface& surface, const Foot& start, Vec3 h, SearchPath* path, int& spent,
                               int budget) noexcept {
  Foot foot = start;
  while (true) {
    if (path != nullptr) path->add(foot.point, foot.triangle);
    if (!Corrections::kFeatureCodes || foot.feature == Feature::kPolygon) return {foot, true};
    if (!detail::withinBudget<Corrections>(spent, budget)) return {foot, false};
    const SearchResult next = foot.feature == Feature::kLine
                                  ? detail::searchAcrossLine<Corrections>(surface, foot, h, spent)
                                  : detail::searchFan<Corrections>(surface, foot, h, spent, budget);
    if (!(next.foot.squaredDistance < foot.squaredDistance)) return next;
    foot = next.foot;
  }
}

}  // namespace haptics
