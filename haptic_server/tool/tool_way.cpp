#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "haptic_server/tool/tool_contact.h"

// Which points a way may take into something, and the test of those.

namespace haptics {
namespace {

/// Of what tests cost, as margin; and of the estimate, from one way to the next where they cost less.
constexpr double kTestMargin = 1.5, kTestDecay = 0.95;

/// Of a place from a triangle's plane.
[[nodiscard]] double heightOver(const CollisionMesh& surface, std::uint32_t triangle, Vec3 at) noexcept {
  return std::abs(glm::dot(surface.faceNormal(triangle), at - surface.triangle(triangle).corner(0)));
}

/// Of a place from a surface, as far as `farthest`; a lower bound, 0 once the allowance is spent.
[[nodiscard]] double distanceFrom(const CollisionMesh& surface, Vec3 at, double farthest,
                                  Allowance& allowance) noexcept {
  constexpr double kNearEnough = 0.64;  // of the squared distance: what is hardly nearer is not looked for
  double nearest = farthest * farthest / kNearEnough;
  allowance.spend(Allowance::kQuery);
  surface.hierarchy().visitNear(
      at, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        allowance.spend(Allowance::kNearTriangle * (end - begin));
        for (std::uint32_t t = begin; t < end; ++t)
          nearest = std::min(nearest, closestOn(surface.triangle(t), t, at).squaredDistance);
        return kNearEnough * nearest;
      },
      kNearEnough * nearest);
  return allowance.isSpent() ? 0 : std::sqrt(kNearEnough * nearest);
}

}  // namespace

/// Does no point enter a surface on its way to that pose, as seen from each body and from the tool? Else hits_ are the first
/// ones found; or there are none, and the allowance was spent before the point tested_.
/// @param from  The points before it have been tested on this way.
bool ToolContact::isClear(std::span<const Body> bodies, const Pose& next, double bound, Allowance& allowance,
                          std::size_t from) noexcept {
  const std::int64_t before = allowance.left();
  tested_ = from;
  hitCount_ = 0;
  firstHit_ = 1;
  lowestHit_ = std::numeric_limits<double>::infinity();
  const Frame frame(next);
  std::int64_t tests = testPoints(bodies, frame, bound, allowance);
  if (!allowance.isSpent()) tests += testBodysPoints(bodies, frame, bound, allowance);
  learnTestCost(tests, before - allowance.left());
  return hitCount_ == 0 && !allowance.isSpent();
}

/// The tool's points from tested_ on, against the surfaces of bodies; how many needed it.
std::int64_t ToolContact::testPoints(std::span<const Body> bodies, const Frame& tool, double bound,
                                     Allowance& allowance) noexcept {
  const double travelled = travelled_ + moved_ + bound;
  const Frame now(proxy_);
  std::int64_t tests = 0;
  for (; tested_ < pointCount_; ++tested_) {
    if (travelled < clearTo_[tested_]) continue;
    ++tests;
    const Vec3 here = now.toWorld(point(tested_)), there = tool.toWorld(point(tested_));
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Body& body = bodies[b];
      const double radius = body.surface->radius_m() + bound + bodyMoved_[b];
      if (body.pendingRemoval || squaredLength(there - body.centre) > radius * radius) continue;
      const Vec3 from = toLocal(bodyAt_[b], here);
      const Vec3 to = body.frame.toLocal(there);
      const Crossing crossing = body.surface->firstCrossing(from, to, allowance);
      if (allowance.isSpent()) return tests;
      if (!crossing) continue;
      const auto point = static_cast<std::uint16_t>(tested_), of = static_cast<std::uint16_t>(b);
      addHit({false, point, of, crossing.triangle, crossing.side, search_, {}, {}, 0}, crossing.time,
             heightOver(*body.surface, crossing.triangle, from));
    }
  }
  return tests;
}

/// The sharp points of bodies from tested_ on, against the tool's own surface; how many needed it.
std::int64_t ToolContact::testBodysPoints(std::span<const Body> bodies, const Frame& tool, double bound,
                                          Allowance& allowance) noexcept {
  std::int64_t tests = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    const auto& [points, first] = sharp_[b];
    const double travelled = bodyTravelled_[b] + bodyMoved_[b] + bound;
    const double reach = tool_->shell.radius_m + bound + bodyMoved_[b];
    if (points.empty() || body.pendingRemoval) continue;
    if (glm::distance(body.centre, tool.origin) > body.surface->radius_m() + reach) continue;
    const std::size_t begin = pointCount_ + first;
    for (std::size_t j = std::max(tested_, begin) - begin; j < points.size(); ++j) {
      double& clearTo = sharpClearTo_[first + j];
      if (travelled < clearTo) continue;
      const Vec3 place = body.frame.toWorld(points[j]);
      const double beyond = glm::distance(place, tool.origin) - reach;
      if (beyond > 0) {
        clearTo = bodyTravelled_[b] + beyond;
        continue;
      }
      ++tests;
      tested_ = begin + j;
      const Vec3 from = toLocal(proxy_, toWorld(bodyAt_[b], points[j]));
      const Crossing crossing = tool_->surface->firstCrossing(from, tool.toLocal(place), allowance);
      if (allowance.isSpent()) return tests;
      if (!crossing) continue;
      const auto point = static_cast<std::uint16_t>(j), of = static_cast<std::uint16_t>(b);
      addHit({true, point, of, crossing.triangle, crossing.side, search_, place, {}, 0}, crossing.time,
             heightOver(*tool_->surface, crossing.triangle, from));
    }
  }
  return tests;
}

void ToolContact::addHit(const Touch& hit, double time, double height) noexcept {
  firstHit_ = std::min(firstHit_, time);
  lowestHit_ = std::min(lowestHit_, height);
  if (hitCount_ < kMaxHits) hits_[hitCount_++] = hit;
}

/// False: no new one is among them, and the planes that are known do not keep the points where they are to be.
bool ToolContact::addHits() noexcept {
  bool added = false;
  for (const Touch& hit : std::span(hits_).first(hitCount_)) {
    std::size_t end = touchCount_;  // behind the last one of the same point
    while (end > 0 && !touches_[end - 1].isOf(hit)) --end;
    const bool known = std::any_of(touches_.begin(), touches_.begin() + static_cast<std::ptrdiff_t>(end),
                                   [&](const Touch& t) { return t.isOf(hit) && t.triangle == hit.triangle; });
    if (known || touchCount_ == kMaxHalfSpaces) continue;
    const std::size_t place = end == 0 ? touchCount_ : end;  // those of a point one after another
    const auto last = touches_.begin() + static_cast<std::ptrdiff_t>(touchCount_);
    std::copy_backward(touches_.begin() + static_cast<std::ptrdiff_t>(place), last, last + 1);
    touches_[place] = hit;
    ++touchCount_;
    added = true;
  }
  return added;
}

/// How many points would have to be tested on a way of this length.
std::int64_t ToolContact::testsWithin(double bound) const noexcept {
  const auto countDue = [](const double* clearTo, std::size_t count, double travelled) {
    return std::count_if(clearTo, clearTo + count, [=](double until) { return until <= travelled; });
  };
  auto due = countDue(clearTo_.data(), pointCount_, travelled_ + moved_ + bound);
  for (std::size_t b = 0; b < bodyCount_; ++b) {
    due += countDue(sharpClearTo_.data() + sharp_[b].first, sharp_[b].points.size(),
                    bodyTravelled_[b] + bodyMoved_[b] + bound);
  }
  return due;
}

/// Does the allowance last for the tests of a way of this length?
bool ToolContact::canTest(double bound, const Allowance& allowance) const noexcept {
  return static_cast<double>(allowance.left()) >= testCost_ * static_cast<double>(testsWithin(bound));
}

void ToolContact::learnTestCost(std::int64_t tests, std::int64_t spent) noexcept {
  if (tests == 0) return;
  const double measured = static_cast<double>(spent) / static_cast<double>(tests);
  testCost_ = std::max({kCheapestTest, kTestDecay * testCost_, kTestMargin * measured});
}

/// Asks the next `count` points, in turn, how far everything was from them when the proxy moved last, those that may have met
/// something by then; as long as the allowance has more than `keep` left.
void ToolContact::renewClearances(std::span<const Body> bodies, std::size_t count, std::int64_t keep,
                                  Allowance& allowance) noexcept {
  const std::size_t all = pointCount_ + sharpCount_;
  const Frame tool(proxy_);
  for (std::size_t i = 0; i < count && allowance.left() > keep; ++i) {
    std::size_t at = cursor_;
    cursor_ = cursor_ + 1 == all ? 0 : cursor_ + 1;
    if (at < pointCount_) {
      if (travelled_ >= clearTo_[at]) clearTo_[at] = travelled_ + clearance(bodies, tool.toWorld(point(at)), allowance);
      continue;
    }
    at -= pointCount_;
    double& clearTo = sharpClearTo_[at];
    const auto end = sharp_.begin() + static_cast<std::ptrdiff_t>(bodyCount_);
    const auto next =
        std::upper_bound(sharp_.begin(), end, at, [](std::size_t p, const Sharp& s) { return p < s.first; });
    const auto b = static_cast<std::size_t>(next - sharp_.begin()) - 1;
    if (bodyTravelled_[b] < clearTo) continue;
    const Vec3 place = tool.toLocal(toWorld(bodyAt_[b], sharp_[b].points[at - sharp_[b].first]));
    const double arm = glm::length(place), radius = tool_->shell.radius_m;
    const double distance = distanceFrom(*tool_->surface, place, kFarthestClearance_m, allowance);
    // Beyond the tool's sphere a turn takes it farther than the tool's own points.
    clearTo = bodyTravelled_[b] + std::max(arm - radius, distance * std::min(1.0, radius / (arm + distance)));
  }
}

/// How far the place may move before it can meet anything; a lower bound.
double ToolContact::clearance(std::span<const Body> bodies, Vec3 place, Allowance& allowance) const noexcept {
  double clear = kFarthestClearance_m;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].pendingRemoval) continue;
    const CollisionMesh& surface = *bodies[b].surface;
    const Vec3 at = toLocal(bodyAt_[b], place);
    if (glm::distance(at, surface.centre()) - surface.radius_m() < clear)
      clear = distanceFrom(surface, at, clear, allowance);
  }
  return clear;
}

}  // namespace haptics
