#include "tests/eval/baselines/surface_after_contact.h"

#include <algorithm>

namespace haptics::eval {

void SurfaceAfterContact::begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies,
                                std::span<const Pose> poses, Vec3 hip) {
  setSpring();
  cache_ = {};
  rest_ = now_ = bodies.front();
  vertices_.clear();
  for (std::uint32_t t = 0; t < rest_->triangleCount(); ++t) {
    const TriangleRecord& r = rest_->triangle(t);
    for (int k = 0; k < 3; ++k) {
      vertices_.resize(std::max<std::size_t>(vertices_.size(), r.vertexAt(k) + 1));
      vertices_[r.vertexAt(k)] = Vec3f(r.corner(k));
    }
  }
  dent_ = {};
  bodies_.assign(1, Body{});
  bodies_[0].previous = bodies_[0].current = poses.front();
  bodies_[0].surface = now_.get();
  bodies_[0].update();
  place(hip);
}

Felt SurfaceAfterContact::tick(std::span<const Pose> /*poses*/, Vec3 hip) {
  const ContactResult contact = followContact(bodies_, state_, hip, cache_);
  moveSurface(contact, hip);
  return {contact.touching, contact.ihip, spring_N_per_m() * (contact.ihip - hip), contact.work.triangles};
}

/// Springs in series, by the penetration below the surface as it was.
void SurfaceAfterContact::moveSurface(const ContactResult& contact, Vec3 hip) {
  const Vec3 moved_m(dent_.displacement);
  dent_ = {};
  if (contact.touching && tissue_) {
    const Vec3 way = toLocal(bodies_[0].current, hip) - toLocal(bodies_[0].current, contact.ihip);
    const Vec3 whole = way + moved_m;
    const double share = spring_N_per_m() / (spring_N_per_m() + tissue_->stiffness_N_per_m);
    const double most = maxDentDepth_m(tissue_->falloff) / std::max(glm::length(share * whole), 1e-12);
    dent_.centre = Vec3f(toLocal(bodies_[0].current, contact.ihip) - moved_m);
    dent_.displacement = Vec3f(share * whole * std::min(1.0, most));
  }
  std::vector<Vec3f> now(vertices_.size());
  std::ranges::transform(vertices_, now.begin(), [&](Vec3f v) {
    return tissue_ ? dented(v, {&dent_, 1}, tissue_->falloff) : v;
  });
  cache_ = {};
  now_ = refitCollisionMesh(*rest_, now);
  bodies_[0].surface = now_.get();
  bodies_[0].update();
}

}  // namespace haptics::eval
