#include "tests/eval/walk/random_walker.h"

#include <cmath>

#include "tests/eval/renderer.h"

namespace haptics::eval {
namespace {

constexpr double kSlowest_m_per_s = 0.02;

}  // namespace

RandomWalker::RandomWalker(const TriangleSoup& soup, Random random, const WalkRange& range)
    : soup_(soup), random_(random), range_(range) {
  hip_ = random_.direction() * (1.1 * soup.extent_m() + range.startsApart_m);
  choose();
  if (range.startsApart_m > 0) speed_ = range.fastest_m_per_s;  // it comes at once
}

Vec3 RandomWalker::next() {
  constexpr double kInertia = 0.8;  // of the velocity, a tick
  const Vec3 way = target_ - hip_;
  const double left = glm::length(way);
  if (left < 2 * speed_ * kPeriod_s) choose();
  const Vec3 wanted = left > 0 ? way * (speed_ / left) : Vec3(0);
  velocity_ = velocity_ * kInertia + wanted * (1 - kInertia);
  hip_ += velocity_ * kPeriod_s;
  return hip_;
}

void RandomWalker::choose() {
  const TriangleSoup::Face& face = someFace();
  double u = random_.between(0, 1);
  double v = random_.between(0, 1);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const Vec3 place = face.corner[0] + (face.corner[1] - face.corner[0]) * u + (face.corner[2] - face.corner[0]) * v;
  target_ = place - face.normal * random_.between(-range_.highest_m, range_.deepest_m);
  speed_ = kSlowest_m_per_s * std::pow(range_.fastest_m_per_s / kSlowest_m_per_s, random_.between(0, 1));
}

/// Mostly one of those about the HIP, sometimes the nearest of a few from anywhere.
const TriangleSoup::Face& RandomWalker::someFace() {
  constexpr int kTries = 8;
  constexpr double kFarthest_m = 0.01;
  const double reach = random_.between(0, kFarthest_m);
  std::vector<const TriangleSoup::Face*> about;
  soup_.visitBox(hip_ - reach, hip_ + reach, [&](const TriangleSoup::Face& face) { about.push_back(&face); });
  if (!about.empty() && random_.below(kTries) > 0) {
    return *about[static_cast<std::size_t>(random_.below(static_cast<int>(about.size())))];
  }
  const auto count = static_cast<int>(soup_.faces().size());
  const TriangleSoup::Face* best = nullptr;
  for (int i = 0; i < kTries; ++i) {
    const TriangleSoup::Face& face = soup_.faces()[static_cast<std::size_t>(random_.below(count))];
    if (best == nullptr || glm::distance(face.corner[0], hip_) < glm::distance(best->corner[0], hip_)) best = &face;
  }
  return *best;
}

}  // namespace haptics::eval
