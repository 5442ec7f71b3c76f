#pragma once

#include <optional>
#include <vector>

#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/engine/surface/shading_normals.h"
#include "tests/eval/renderer.h"

namespace haptics::eval {

/// Section 4 of the paper as printed, over the production contact core: force shading by Eq. (1) at the IHIP, however
/// deep; friction that sticks again as soon as its force is below the dynamic one; Eq. (4) with K as it was set, or bump
/// mapping, whichever the texture asks for.
class SurfaceAsPrinted : public Renderer {
 public:
  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override;
  void setSurfaceProperties(const FeltSurface& surface) override { given_ = surface; }
  void place(Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 protected:
  FeltSurface& given() { return *given_; }

 private:
  [[nodiscard]] Vec3 shadedNormal(const ContactResult& contact) const;
  [[nodiscard]] Vec3 textureForce_N(const ContactResult& contact, Vec3 normal, double depth_m) const;
  [[nodiscard]] Vec3 frictionForce_N(const ContactResult& contact, Vec3 normal, double normal_N);

  std::optional<FeltSurface> given_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<ShadingNormals> normals_;  // of each surface, where there is shading
  std::vector<Body> bodies_;
  ContactState contact_;
  ContactCache cache_;
  FrictionState friction_ = FrictionState::kNone;
  Vec3 stickingPoint_{0};  // world
};

/// The same with bump mapping in place of Eq. (4): "the most intuitive way" (4.3.2), which the paper replaced.
class BumpMapping final : public SurfaceAsPrinted {
 public:
  void setSurfaceProperties(const FeltSurface& surface) override {
    SurfaceAsPrinted::setSurfaceProperties(surface);
    if (given().properties.texture) given().properties.texture->law = Texture::Law::kBump;
  }
};

}  // namespace haptics::eval
