#pragma once

#include <memory>
#include <vector>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// A soft body as usually written: the contact is found on the surface as the last tick left it, the surface is then moved
/// by its force, and its boxes are refitted. Elastic tissue only; the first body only.
class SurfaceAfterContact final : public Renderer {
 public:
  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override;
  void setSurfaceProperties(const FeltSurface& surface) override { tissue_ = surface.tissue; }
  void place(Vec3 hip) override { haptics::resetContact(state_, hip); }
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;
  [[nodiscard]] std::vector<Dent> dents(std::size_t /*body*/) const override { return {dent_}; }

 private:
  void moveSurface(const ContactResult& contact, Vec3 hip);

  std::optional<SoftTissue> tissue_;
  std::shared_ptr<const CollisionMesh> rest_, now_;
  std::vector<Vec3f> vertices_;  // at rest
  std::vector<Body> bodies_;
  ContactState state_;
  ContactCache cache_;
  Dent dent_;
};

}  // namespace haptics::eval
