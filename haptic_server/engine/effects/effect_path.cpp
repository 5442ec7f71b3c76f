#include "haptic_server/engine/effects/effect_path.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace haptics {

EffectPath::EffectPath(const std::vector<Vec3>& points) {
  const std::size_t count = points.size() - 1;
  segments_.reserve(count);
  tangents_.assign(points.size(), Vec3(0));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 way = points[i + 1] - points[i];
    segments_.push_back({points[i], way, 1 / glm::dot(way, way)});
    const Vec3 along = glm::normalize(way);
    tangents_[i] += along;
    tangents_[i + 1] += along;
  }
  for (std::size_t i = 0; i < tangents_.size(); ++i) {
    constexpr double kTurnsBack = 1e-6;  // below it, the sum of two unit vectors has no direction
    if (glm::length(tangents_[i]) < kTurnsBack) tangents_[i] = segments_[std::min(i, count - 1)].way;
    tangents_[i] = glm::normalize(tangents_[i]);
  }
  leaves_ = std::bit_ceil((count + kLeaf - 1) / kLeaf);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  boxes_.assign(2 * leaves_, {Vec3(kNone), Vec3(-kNone)});
  for (std::size_t i = 0; i < count; ++i) {
    Box& box = boxes_[leaves_ + i / kLeaf];
    box.low = glm::min(box.low, glm::min(points[i], points[i + 1]));
    box.high = glm::max(box.high, glm::max(points[i], points[i + 1]));
  }
  for (std::size_t i = leaves_ - 1; i > 0; --i) {
    boxes_[i].low = glm::min(boxes_[2 * i].low, boxes_[2 * i + 1].low);
    boxes_[i].high = glm::max(boxes_[2 * i].high, boxes_[2 * i + 1].high);
  }
}

PathPlace EffectPath::nearestOn(std::size_t segment, Vec3 x) const noexcept {
  const Segment& of = segments_[segment];
  const double part = std::clamp(glm::dot(x - of.begin, of.way) * of.perSquaredLength, 0.0, 1.0);
  const Vec3 point = of.begin + part * of.way;
  return {segment, part, point, squaredLength(x - point)};
}

PathPlace EffectPath::nearest(Vec3 x, std::size_t warm) const noexcept {
  PathPlace best = nearestOn(warm, x);
  struct Entry {
    std::size_t box;
    double squared_m2;
  };
  std::array<Entry, 64> stack;  // deeper than any tree
  std::size_t depth = 0;
  stack[depth++] = {1, boxes_[1].squaredDistance(x)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (!(entry.squared_m2 < best.squared_m2)) continue;
    if (entry.box >= leaves_) {
      const std::size_t first = (entry.box - leaves_) * kLeaf;
      const std::size_t end = std::min(first + kLeaf, segments_.size());
      for (std::size_t i = first; i < end; ++i) {
        const PathPlace place = nearestOn(i, x);
        if (place.squared_m2 < best.squared_m2) best = place;
      }
      continue;
    }
    Entry near{2 * entry.box, boxes_[2 * entry.box].squaredDistance(x)};
    Entry far{2 * entry.box + 1, boxes_[2 * entry.box + 1].squaredDistance(x)};
    if (far.squared_m2 < near.squared_m2) std::swap(near, far);
    if (far.squared_m2 < best.squared_m2) stack[depth++] = far;
    if (near.squared_m2 < best.squared_m2) stack[depth++] = near;
  }
  return best;
}

PathPlace EffectPath::onwards(Vec3 x, std::uint64_t segment, double part) const noexcept {
  /// Of a tick: what is left is gone over in the next ones.
  constexpr std::size_t kMaxSteps = 64;
  PathPlace best = nearestOn(segment, x);
  if (best.part < part) {
    best.part = part;
    best.point = segments_[segment].begin + part * segments_[segment].way;
    best.squared_m2 = squaredLength(x - best.point);
  }
  const std::size_t end = std::min(segment + 1 + kMaxSteps, segments_.size());
  for (std::size_t next = segment + 1; next < end; ++next) {
    const PathPlace place = nearestOn(next, x);
    if (place.squared_m2 > best.squared_m2) break;
    best = place;
  }
  return best;
}

Vec3 EffectPath::tangent(const PathPlace& place) const noexcept {
  const Vec3 between = glm::mix(tangents_[place.segment], tangents_[place.segment + 1], place.part);
  const double squared = squaredLength(between);
  constexpr double kOpposite = 1e-12;
  if (squared > kOpposite) return between / std::sqrt(squared);
  return segments_[place.segment].way * std::sqrt(segments_[place.segment].perSquaredLength);
}

}  // namespace haptics
