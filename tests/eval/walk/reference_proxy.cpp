#include "tests/eval/walk/reference_proxy.h"

#include <algorithm>
#include <limits>

#include "tests/eval/random.h"

namespace haptics::eval {
namespace {

/// Of a skin: shorter than this is no motion, and deeper than this is below a wall.
constexpr double kStill = 0x1p-10;
/// In skins: as near is what the proxy lies on, also in a corner.
constexpr double kOnIt = 4;

/// The point nearest to h that lies on all of these walls: their normals made orthogonal one by one.
std::optional<Vec3> nearestOnAll(Vec3 h, std::span<const Wall* const> walls) {
  constexpr double kParallel = 1e-9;  // sine
  Vec3 x = h;
  std::array<Vec3, 3> axis;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    Vec3 free = walls[i]->normal;
    for (int twice = 0; twice < 2; ++twice) {
      for (std::size_t j = 0; j < i; ++j) free -= axis[j] * glm::dot(free, axis[j]);
    }
    const double sine = glm::length(free);
    if (sine < kParallel) return std::nullopt;
    axis[i] = free / sine;
    x += axis[i] * ((walls[i]->offset_m - glm::dot(walls[i]->normal, x)) / sine);
  }
  return x;
}

}  // namespace

ReferenceProxy::ReferenceProxy(const TriangleSoup& soup)
    : soup_(&soup),
      skin_(kSkin * soup.extent_m()),
      obstacles_(soup, skin_),
      sight_(soup.meanEdge_m()),
      nextSight_(sight_) {}

void ReferenceProxy::place(Vec3 hip) {
  at_ = hip_ = hip;
  lookAround();
}

void ReferenceProxy::resume(Vec3 ihip, Vec3 hip) {
  place(hip);
  if (ihip == hip) return;
  at_ = ihip;
  lookAround();
  at_ = pushedOff(obstacles_.touching(ihip, hip - ihip, skin_), ihip);
  if (soup_->isInside(at_, 0)) at_ = outsideNear(ihip);
  settle(hip);
}

/// The nearest of many places that is.
Vec3 ReferenceProxy::outsideNear(Vec3 place) const {
  constexpr int kDirections = 512;
  constexpr double kFarthest = 4096;  // in skins
  for (double away = 1; away <= kFarthest; away *= 4) {
    Random random(1);
    for (int i = 0; i < kDirections; ++i) {
      const Vec3 there = place + random.direction() * (away * skin_);
      if (!soup_->isInside(there, 0)) return there;
    }
  }
  return place;
}

void ReferenceProxy::follow(Vec3 hip, int parts) {
  const Vec3 from = hip_;
  const double part = glm::distance(from, hip) / parts;
  leap_ = 0;
  for (int i = 1; i <= parts; ++i) {
    const Vec3 before = at_;
    hip_ = i < parts ? glm::mix(from, hip, static_cast<double>(i) / parts) : hip;
    settle(hip_);
    leap_ = std::max(leap_, glm::distance(before, at_) - part);
  }
}

void ReferenceProxy::settle(Vec3 h) {
  constexpr int kMaxMoves = 1000;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxMoves && (hop(h) || move(h) || leaveCorner(h, nearest_m) || leaveRim(h)); ++i) {
  }
}

/// To the point nearest to h of the triangles that the proxy lies on, when that is a nearer one and the way is open:
/// straight, or, where the walls about a corner keep the proxy a few skins off it, from above that corner. For
/// corners' sake what is a few skins ahead is touched, too: on one surface the proxy waits until its minimum ends.
bool ReferenceProxy::hop(Vec3 h) {
  constexpr double kNearer = 1 - 0x1p-44;
  if (at_ == h) return false;
  keepInSight();
  const auto nearest = obstacles_.nearestOfTouched(at_, h);
  if (!nearest || glm::distance(nearest->point, at_) < 2 * skin_) return false;
  const auto above = [&](Vec3 place) { return pushedOff(obstacles_.touching(place, h - at_, skin_), place); };
  const Vec3 to = above(nearest->point);
  const bool nearer = glm::distance(to, h) < glm::distance(at_, h) * kNearer && glm::distance(to, at_) > skin_;
  if (!nearer || obstacles_.isAboveMinimum(at_, h)) return false;
  const Vec3 corner = above(nearest->beside);
  const auto isOpen = [&](double time) {
    if (!obstacles_.firstBlock(at_, glm::mix(at_, to, time))) return true;
    return !obstacles_.firstBlock(at_, corner) && !obstacles_.firstBlock(corner, glm::mix(corner, to, time));
  };
  const double seen = timeInSight(to);
  if (!isOpen(seen)) return false;
  if (seen < 1) {
    sight_ = 2 * glm::distance(at_, to);
    sightCentre_ = at_;
    obstacles_.gather(at_, sight_ + 4 * skin_);
    if (!isOpen(1)) return false;
  }
  at_ = to;
  return true;
}

/// One straight motion: until something is met, what carries ends, or the best place on what carries is reached.
/// Returns whether there may be more to come.
bool ReferenceProxy::move(Vec3 h) {
  keepInSight();
  Walls walls;
  Vec3 to = h;
  double time = 1;
  while (true) {
    time = timeInSight(to);
    const auto block = obstacles_.firstBlock(at_, glm::mix(at_, to, time));
    if (!block) break;
    const double above = glm::dot(block->wall.normal, at_) - block->wall.offset_m;
    const double below = glm::dot(block->wall.normal, to) - block->wall.offset_m;
    const double reach = above > 0 ? above / (above - below) : 0;
    if (reach * glm::distance(at_, to) > kStill * skin_) {
      time = std::min(time, reach);
      break;
    }
    if (walls.count == Walls::kMax) return false;
    walls.met[walls.count++] = block->wall;
    const auto best = walls.nearest(h, kStill * skin_);
    if (!best) return false;  // held in a point
    to = *best;
  }
  const double way = glm::distance(at_, to);
  const double carried = obstacles_.timeOnSupports(std::span(walls.pushing).first(walls.pushingCount), at_, to);
  time = std::min(time, std::max(carried, skin_ / way));  // on, whatever happens
  if (time < 1) {
    at_ = glm::mix(at_, to, time);
    return time * way > kStill * skin_;
  }
  at_ = to;
  return false;
}

/// Along the line of two of the walls that the proxy lies on, as far as they carry, when that leads nearer and the way is
/// open. An edge that juts out between two other walls ends in a corner for each of its faces. The skin parts those
/// corners, and keeps the proxy in one where the other, which is the same place of the bodies, holds nothing. Where a motion
/// then leads back into the corner it is not left again, unless to a place nearer than `nearest_m`, the last.
bool ReferenceProxy::leaveCorner(Vec3 h, double& nearest_m) {
  constexpr double kClear = 16;  // in skins
  if (at_ == h) return false;
  const std::vector<Wall> walls = obstacles_.touching(at_, h - at_, kOnIt * skin_);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const std::array pair{&walls[i], &walls[j]};
      const std::optional<Vec3> nearest = nearestOnAll(h, pair);
      if (!nearest) continue;
      const double time = std::min(timeInSight(*nearest), obstacles_.timeOnSupports(pair, at_, *nearest));
      const Vec3 to = glm::mix(at_, *nearest, time);
      const double distance = glm::distance(to, h);
      if (glm::distance(at_, to) < kClear * skin_ || distance >= glm::distance(at_, h)) continue;
      if (distance > nearest_m - skin_) continue;
      if (obstacles_.firstBlock(at_, to)) continue;
      nearest_m = distance;
      at_ = to;
      return true;
    }
  }
  return false;
}

/// Over the rim of a sheet, from the corner in which several of its triangles hold the proxy: the skin keeps it beside that
/// corner, over one of them, also where from the corner itself the way is open.
bool ReferenceProxy::leaveRim(Vec3 h) {
  constexpr double kBeside = 16;  // in skins
  constexpr double kBeyond = 256;
  if (at_ == h) return false;
  const std::vector<Wall> walls = obstacles_.touching(at_, h - at_, kOnIt * skin_);
  if (walls.size() < 2) return false;
  Vec3 out(0);
  for (const Wall& wall : walls) {
    if (!obstacles_.isSheet(wall)) return false;
    out += glm::normalize(at_ - obstacles_.middle(wall));
  }
  const Vec3 beside = at_ + glm::normalize(out) * (kBeside * skin_);
  const Vec3 to = glm::mix(beside, h, std::min(1.0, kBeyond * skin_ / glm::distance(beside, h)));
  if (glm::distance(to, h) >= glm::distance(at_, h)) return false;
  if (obstacles_.firstBlock(at_, beside) || obstacles_.firstBlock(beside, to)) return false;
  at_ = to;
  return true;
}

void ReferenceProxy::keepInSight() {
  if (glm::any(glm::greaterThan(glm::abs(at_ - sightCentre_), Vec3(sight_ / 2)))) lookAround();
}

void ReferenceProxy::lookAround() {
  constexpr std::size_t kFew = 12;   // widens the sight
  constexpr std::size_t kMany = 64;  // narrows it
  sight_ = nextSight_;
  sightCentre_ = at_;
  while (true) {
    obstacles_.gather(at_, sight_ + 4 * skin_);
    if (obstacles_.count() <= kMany || sight_ < 256 * skin_) break;
    nextSight_ = sight_ *= 0.5;
  }
  if (obstacles_.count() < kFew) nextSight_ = std::min(sight_ * 1.5, soup_->extent_m() / 8);
}

/// Fraction of the way to `to` that stays within sight.
double ReferenceProxy::timeInSight(Vec3 to) const {
  double time = 1;
  for (int d = 0; d < 3; ++d) {
    const double way = to[d] - at_[d];
    const double wall = sightCentre_[d] + (way > 0 ? sight_ : -sight_);
    if (way > 0 ? to[d] > wall : to[d] < wall) time = std::min(time, (wall - at_[d]) / way);
  }
  return time;
}

/// The point nearest to h above all walls: of the points nearest to h on each wall, on each line and in each corner of
/// theirs, the nearest that is above all.
std::optional<Vec3> ReferenceProxy::Walls::nearest(Vec3 h, double slack) {
  std::optional<Vec3> best;
  double least = std::numeric_limits<double>::infinity();
  std::array<const Wall*, 3> of{};
  const auto consider = [&](std::size_t size) {
    const std::optional<Vec3> x = nearestOnAll(h, std::span(of).first(size));
    if (!x || glm::distance(*x, h) >= least) return;
    for (std::size_t i = 0; i < count; ++i) {
      if (glm::dot(met[i].normal, *x) < met[i].offset_m - slack) return;
    }
    least = glm::distance(*x, h);
    best = x;
    pushing = of;
    pushingCount = size;
  };
  for (std::size_t i = 0; i < count; ++i) {
    of[0] = &met[i];
    consider(1);
    for (std::size_t j = 0; j < i; ++j) {
      of[1] = &met[j];
      consider(2);
      for (std::size_t k = 0; k < j; ++k) {
        of[2] = &met[k];
        consider(3);
      }
    }
  }
  return best;
}

}  // namespace haptics::eval
