#include "tests/eval/walk/obstacles.h"

#include <algorithm>
#include <cmath>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {
namespace {

// In skins. A triangle blocks as far beyond its edges as kBlockBeyond, so that nothing slips between neighbours, and
// carries as far as kCarryBeyond, so that what leaves it is clear of it.
constexpr double kBlockBeyond = 0.5;
constexpr double kCarryBeyond = 2;
/// What keeps a point a skin above several triangles can lift it this far off each.
constexpr double kTouchWithin = 64;
/// What keeps it a skin above a minimum on one surface lifts it no farther.
constexpr double kAboveWithin = 2;
/// Of the largest coordinate: some hundred times what the arithmetic rounds off a place.
constexpr double kRounding = 0x1p-44;

}  // namespace

Obstacles::Face::Face(const TriangleSoup::Face& face)
    : normal(face.normal), offset_m(face.offset_m), sheet(face.sheet), corner(face.corner) {
  for (std::size_t k = 0; k < 3; ++k) {
    inward[k] = glm::normalize(glm::cross(normal, corner[(k + 1) % 3] - corner[k]));
    inwardOffset_m[k] = glm::dot(inward[k], corner[k]);
  }
}

void Obstacles::gather(Vec3 centre, double reach) {
  faces_.clear();
  soup_->visitBox(centre - reach, centre + reach, [&](const TriangleSoup::Face& face) { faces_.emplace_back(face); });
}

std::optional<Obstacles::Block> Obstacles::firstBlock(Vec3 from, Vec3 to) const {
  std::optional<Block> first;
  double firstInside = 0;
  const double way = glm::distance(from, to);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    const double start = glm::dot(face.normal, from) - face.offset_m;
    const double end = glm::dot(face.normal, to) - face.offset_m;
    const bool down = start >= 0 && end < 0;
    const bool up = face.sheet && start < 0 && end >= 0;
    if (!down && !up) continue;
    const double time = start / (start - end);
    if (first && (time - first->time) * way > skin_) continue;
    const Vec3 at = glm::mix(from, to, time);
    const double inside = face.inside(at);
    if (inside < -kBlockBeyond * skin_) continue;
    // Of two in one place the one that the way really meets: its neighbour, beyond their edge, could hold it falsely.
    const bool together = first && (first->time - time) * way <= skin_;
    const double within = std::min(inside, 0.0);
    if (together && (within < firstInside || (within == firstInside && time >= first->time))) continue;
    if (inside < 0 && glm::distance(closestOnTriangle(at, face.corner), at) > kBlockBeyond * skin_) continue;
    first = Block{time, face.wall(down ? 1 : -1, skin_, f)};
    firstInside = within;
  }
  return first;
}

double Obstacles::timeOnSupports(std::span<const Wall* const> walls, Vec3 from, Vec3 to) const {
  double time = 1;
  const Vec3 way = to - from;
  for (const Wall* wall : walls) {
    const Face& face = faces_[wall->face];
    for (std::size_t k = 0; k < 3; ++k) {
      const double speed = glm::dot(face.inward[k], way);
      if (speed < 0) time = std::min(time, -(face.insideEdge(k, from) + kCarryBeyond * skin_) / speed);
    }
  }
  return time;
}

std::optional<Obstacles::Place> Obstacles::nearestOfTouched(Vec3 at, Vec3 h) const {
  std::optional<Place> nearest;
  for (const Face& face : faces_) {
    const double height = std::abs(glm::dot(face.normal, at) - face.offset_m);
    if (height > kTouchWithin * skin_ || face.inside(at) < -kTouchWithin * skin_) continue;
    const Vec3 point = closestOnTriangle(h, face.corner);
    if (nearest && glm::distance(point, h) >= glm::distance(nearest->point, h)) continue;
    nearest = Place{point, closestOnTriangle(at, face.corner)};
  }
  return nearest;
}

bool Obstacles::isMinimum(Vec3 place, Vec3 h) const {
  const double rounding = kRounding * soup_->extent_m();
  bool held = false;
  for (const Face& face : faces_) {
    if (std::abs(glm::dot(face.normal, place) - face.offset_m) > rounding || face.inside(place) < -rounding) continue;
    if (glm::distance(closestOnTriangle(place, face.corner), place) > rounding) continue;
    const bool hides = face.sheet ? face.inside(place) > rounding : glm::dot(face.normal, h) < face.offset_m;
    if (!hides || glm::distance(closestOnTriangle(h, face.corner), place) > rounding) return false;
    held = true;
  }
  return held;
}

bool Obstacles::isAboveMinimum(Vec3 at, Vec3 h) const {
  const double within = kAboveWithin * skin_;
  return std::any_of(faces_.begin(), faces_.end(), [&](const Face& face) {
    if (std::abs(glm::dot(face.normal, at) - face.offset_m) > within || face.inside(at) < -within) return false;
    const Vec3 foot = closestOnTriangle(h, face.corner);
    return glm::distance(foot, at) <= within && isMinimum(foot, h);
  });
}

std::vector<Wall> Obstacles::touching(Vec3 at, Vec3 inward, double within) const {
  std::vector<Wall> walls;
  double steepest = 0;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    if (std::abs(glm::dot(face.normal, at) - face.offset_m) > within || face.inside(at) < -within) continue;
    if (glm::distance(closestOnTriangle(at, face.corner), at) > within) continue;
    walls.push_back(face.wall(1, skin_, f));
    const double steep = glm::dot(face.normal, inward);
    if (face.sheet && std::abs(steep) > std::abs(steepest)) steepest = steep;
  }
  for (Wall& wall : walls) {
    const Face& face = faces_[wall.face];
    if (face.sheet && steepest > 0) wall = face.wall(-1, skin_, wall.face);
  }
  return walls;
}

Vec3 pushedOff(std::span<const Wall> walls, Vec3 at) {
  constexpr int kMaxRounds = 64;
  constexpr double kSlack = 0x1p-45;  // of the coordinates
  for (int round = 0; round < kMaxRounds; ++round) {
    bool good = true;
    for (const Wall& wall : walls) {
      const double missing = wall.offset_m - glm::dot(wall.normal, at);
      if (missing <= kSlack * std::abs(wall.offset_m)) continue;
      good = false;
      at += wall.normal * missing;
    }
    if (good) break;
  }
  return at;
}

}  // namespace haptics::eval
