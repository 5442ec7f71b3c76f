#include "tests/eval/baselines/finite_proxy.h"

#include <algorithm>

#include "tests/eval/baselines/swept_sphere.h"

namespace haptics::eval {
namespace {

/// The point of the cone { x : normal . x >= 0 for all normals } nearest to `to`: `to` itself, its foot on one plane, on
/// the line of two, or the apex. The solution is one of them, and all that lie in the cone may compete.
Vec3 nearestInCone(const std::vector<Vec3>& normals, Vec3 to) {
  const double slack = 1e-9 * glm::length(to);
  Vec3 best(0);
  const auto consider = [&](Vec3 x) {
    const bool inCone = std::all_of(normals.begin(), normals.end(), [&](Vec3 n) { return glm::dot(n, x) >= -slack; });
    if (inCone && glm::distance(x, to) < glm::distance(best, to)) best = x;
  };
  consider(to);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    consider(to - normals[i] * glm::dot(normals[i], to));
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 line = glm::cross(normals[i], normals[j]);
      if (const double sine2 = squaredLength(line); sine2 > 0x1p-60) consider(line * (glm::dot(line, to) / sine2));
    }
  }
  return best;
}

}  // namespace

void FiniteProxy::place(Vec3 hip) {
  proxy_ = hip;
  for (int i = 0; i < kMaxMoves; ++i) {  // a HIP nearer to a surface than the radius
    const Vec3 before = proxy_;
    (void)touchedPlanes();
    if (proxy_ == before) break;
  }
}

Felt FiniteProxy::tick(std::span<const Pose> poses, Vec3 hip) {
  bodies_.setPoses(poses);
  for (int i = 0; i < kMaxMoves; ++i) {
    const Vec3 way = nearestInCone(touchedPlanes(), hip - proxy_);
    const double before = glm::distance(hip, proxy_);
    proxy_ += way * firstTouch(way);
    if (glm::distance(hip, proxy_) >= before - kTouching * kRadius_m) break;
  }
  const Vec3 toHip = hip - proxy_;
  const double distance = glm::length(toHip);
  if (distance <= kRadius_m) return {false, hip, Vec3(0), 0};
  const Vec3 ihip = proxy_ + toHip * (kRadius_m / distance);
  return {true, ihip, spring_N_per_m() * (ihip - hip), 0};
}

template <class Visit>
void FiniteProxy::forNear(int body, Vec3 centre, double radius, Visit visit) const {
  Allowance endless;
  bodies_.surface(body).hierarchy().visitNear(toLocal(bodies_.pose(body), centre), endless,
                                              [&](std::uint32_t begin, std::uint32_t end) {
                                                for (std::uint32_t t = begin; t < end; ++t) visit(t);
                                                return radius * radius;
                                              });
}

std::vector<Vec3> FiniteProxy::touchedPlanes() {
  constexpr double kSame = 1 - 1e-12;  // cosine
  std::vector<Vec3> normals;
  for (int body = 0; body < bodies_.count(); ++body) {
    const Pose& pose = bodies_.pose(body);
    Vec3 local = toLocal(pose, proxy_);
    forNear(body, proxy_, kRadius_m * (1 + kTouching), [&](std::uint32_t t) {
      const Vec3 away = local - closestOn(bodies_.surface(body).triangle(t), t, local).point;
      const double distance = glm::length(away);
      if (distance > kRadius_m * (1 + kTouching) || distance == 0) return;
      const Vec3 normal = pose.rotation * (away / distance);
      if (distance < kRadius_m) {
        proxy_ += normal * (kRadius_m - distance);
        local = toLocal(pose, proxy_);
      }
      const bool known =
          std::any_of(normals.begin(), normals.end(), [&](Vec3 other) { return glm::dot(normal, other) > kSame; });
      if (!known && normals.size() < kMaxPlanes) normals.push_back(normal);
    });
  }
  return normals;
}

/// With a radius that is smaller by the tolerance: what is touched already is not in the way of sliding along it.
double FiniteProxy::firstTouch(Vec3 way) const {
  constexpr double kRadius = kRadius_m * (1 - kTouching);
  double first = 1;
  for (int body = 0; body < bodies_.count(); ++body) {
    const Pose& pose = bodies_.pose(body);
    const SweptSphere sphere(toLocal(pose, proxy_), glm::conjugate(pose.rotation) * way, kRadius);
    forNear(body, proxy_ + way * 0.5, 0.5 * glm::length(way) + kRadius_m, [&](std::uint32_t t) {
      const TriangleRecord& r = bodies_.surface(body).triangle(t);
      first = sphere.firstTouch({r.corner(0), r.corner(1), r.corner(2)}, first);
    });
  }
  return first;
}

}  // namespace haptics::eval
