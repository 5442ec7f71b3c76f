#include "tests/eval/baselines/surface_as_printed.h"

namespace haptics::eval {

void SurfaceAsPrinted::begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
                             Vec3 hip) {
  surfaces_.assign(bodies.begin(), bodies.end());
  bodies_.clear();
  cache_ = {};
  normals_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Body& body = bodies_.emplace_back();
    body.surface = bodies[i].get();
    body.previous = body.current = poses[i];
    body.update();
    if (const auto& shading = given().properties.shading) {
      normals_.emplace_back(*bodies[i], shading->crease_rad, shading->creases);
    }
  }
  place(hip);
}

void SurfaceAsPrinted::place(Vec3 hip) {
  haptics::resetContact(contact_, hip);
  friction_ = FrictionState::kNone;
}

Felt SurfaceAsPrinted::tick(std::span<const Pose> /*poses*/, Vec3 hip) {
  const ContactResult contact = followContact(bodies_, contact_, hip, cache_);
  if (!contact.touching) {
    friction_ = FrictionState::kNone;
    return {false, hip, Vec3(0), contact.work.triangles};
  }
  const Vec3 normal = shadedNormal(contact);
  const double depth_m = contact.penetration_m / glm::dot(contact.normal, normal);
  const Vec3 pressed_N = textureForce_N(contact, normal, depth_m);
  const Vec3 dragged_N = frictionForce_N(contact, normal, glm::dot(pressed_N, normal));
  return {true, contact.ihip, pressed_N + dragged_N, contact.work.triangles, friction_ == FrictionState::kSliding};
}

/// Eq. (1): the vertices' normals weighted by the areas of the subtriangles opposite to them.
Vec3 SurfaceAsPrinted::shadedNormal(const ContactResult& contact) const {
  const ContactSurface& held = contact_.holding[0];
  const auto body = static_cast<std::size_t>(held.body);
  const bool one = contact_.mode == ContactState::Mode::kOneSurface;
  if (normals_.empty() || !one || !normals_[body][held.triangle].hasNormals()) return contact.normal;
  const TriangleRecord& triangle = surfaces_[body]->triangle(held.triangle);
  const Vec3 ihip = bodies_[body].frame.toLocal(contact.ihip);
  Vec3 normal(0);
  for (int k = 0; k < 3; ++k) {
    const Vec3 next = triangle.corner((k + 1) % 3) - ihip;
    const Vec3 last = triangle.corner((k + 2) % 3) - ihip;
    normal += glm::length(glm::cross(next, last)) * normals_[body][held.triangle].normal(k);
  }
  return bodies_[body].frame.rotate(glm::normalize(normal)) * static_cast<double>(held.side);
}

/// Eqs. (2) to (4).
Vec3 SurfaceAsPrinted::textureForce_N(const ContactResult& contact, Vec3 normal, double depth_m) const {
  const double k = given_->spring_N_per_m;
  const auto& texture = given_->properties.texture;
  if (!texture) return k * depth_m * normal;
  const Body& body = bodies_[static_cast<std::size_t>(contact.body)];
  const FieldSample field = given_->texture->at(body.frame.toLocal(contact.ihip));
  const double height_m = texture->amplitude_m * (field.value - (texture->literal ? 0 : given_->texture->lowest()));
  const Vec3 gradient = body.frame.rotate(texture->amplitude_m * field.gradient);
  const Vec3 perturbed = normal - gradient + glm::dot(gradient, normal) * normal;
  const double d = std::max(0.0, depth_m + height_m);
  const double part = texture->gain_K * height_m;
  if (texture->law == Texture::Law::kBump || d < part) return k * d * perturbed;
  return k * ((d - part) * normal + part * perturbed);
}

/// Section 4.2, with k_s = mu_s k and k_d = mu_d k.
Vec3 SurfaceAsPrinted::frictionForce_N(const ContactResult& contact, Vec3 normal, double normal_N) {
  const auto& friction = given_->properties.friction;
  if (!friction) return Vec3(0);
  if (friction_ == FrictionState::kNone) {
    friction_ = FrictionState::kSticking;
    stickingPoint_ = contact.ihip;
  }
  Vec3 stretch = stickingPoint_ - contact.ihip;
  stretch -= glm::dot(stretch, normal) * normal;
  const double length_m = glm::length(stretch);
  const double limit_m = normal_N / given_->spring_N_per_m;  // both laws' force is the allowed one here
  if (length_m > limit_m) {
    friction_ = FrictionState::kSliding;
    stretch *= limit_m / length_m;
    stickingPoint_ = contact.ihip + stretch;
  } else if (length_m < limit_m) {
    friction_ = FrictionState::kSticking;
  }
  const double mu = friction_ == FrictionState::kSliding ? friction->mu_dynamic : friction->mu_static;
  return mu * given_->spring_N_per_m * stretch;
}

}  // namespace haptics::eval
