#include "haptic_server/engine/step/groove_shading.h"

#include "haptic_server/engine/step/held_planes.h"
#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/engine/step/material_map.h"
#include "haptic_server/engine/step/soft_contact.h"
#include "haptic_server/engine/surface/force_shading.h"

namespace haptics {
namespace {

constexpr int kGrooveRounds = 2;
/// Units (Allowance) of shading at one surface, over some polygons, and of each dent in it.
constexpr std::int64_t kShade = 1'000, kShadeDent = 400;

class ShadedGroove {
 public:
  ShadedGroove(const ServoScene& scene, HapticState& state, ContactWork& work) noexcept
      : scene_(scene), state_(state), work_(work) {}

  [[nodiscard]] bool run(Vec3& ihip) noexcept {
    if (!hasShading()) return false;
    for (int round = 0; round < kGrooveRounds; ++round) {
      const auto dents = static_cast<std::int64_t>(state_.dents.count);
      work_.allowance.spend((kShade + kShadeDent * dents) * state_.contact.holdingCount);
      if (work_.allowance.isSpent()) {
        state_.fallBehind(work_);
        break;
      }
      const HeldPlanes planes = planesAt(ihip);
      Vec3 parts;
      ihip = planes.nearestOutside(state_.estimate.hip, parts);
      for (std::size_t k = 0; k < planes.count; ++k) state_.groove.normal[k] = planes.plane[k].normal;
    }
    state_.groove.shaded = anyShaded_;
    return anyShaded_;
  }

 private:
  [[nodiscard]] const ShadingNormals* shadingOf(int body) const noexcept {
    const SurfaceDetail* detail = scene_.objects[static_cast<std::size_t>(body)].detail.get();
    return detail == nullptr ? nullptr : detail->shading.get();
  }

  [[nodiscard]] bool hasShading() const noexcept {
    const auto holding = state_.contact.surfaces();
    bool any = false;
    for (std::size_t k = 0; k < holding.size(); ++k) {
      any = any || shadingOf(holding[k].body) != nullptr;
      for (std::size_t j = 0; j < k; ++j) {
        if (holding[j].body == holding[k].body) return false;
      }
    }
    return any;
  }

  [[nodiscard]] HeldPlanes planesAt(const Vec3& ihip) noexcept {
    HeldPlanes planes;
    anyShaded_ = false;
    for (const ContactSurface& held : state_.contact.surfaces()) add(planes, held, ihip);
    return planes;
  }

  void add(HeldPlanes& planes, const ContactSurface& held, const Vec3& ihip) noexcept {
    const auto index = static_cast<std::size_t>(held.body);
    const Body& body = state_.bodies[index];
    const Vec3 h = body.frame.toLocal(ihip);
    const TriangleRecord polygon = dentedTriangle(scene_, state_, index, held.triangle);
    const double side = held.side;
    Vec3 normal = unitOrZero(polygon.areaNormal()) * side;
    Vec3 point = h + normal * glm::dot(normal, polygon.corner(0) - h);
    if (const ShadingNormals* shading = shadingOf(held.body)) {
      const SoftTissue* tissue = scene_.objects[index].tissue.get();
      ClosestPoint foot;
      foot.triangle = held.triangle;
      foot.point = point;
      const ShadedPoint smooth =
          tissue == nullptr ? shade(*body.surface, *shading, foot, h, 0)
                            : shade(*body.surface, *shading, dentsOf(state_, index).all(), tissue->falloff, foot, h, 0);
      if (smooth.weight > 0) {
        anyShaded_ = true;
        double bulge_m = smooth.bulge_m;
        if (tissue != nullptr)
          bulge_m = side * deformedBulge_m(scene_, state_, index, held.triangle, ihip, bulge_m * side);
        point = glm::mix(point, h + smooth.normal * (smooth.depth_m + bulge_m), smooth.weight);
        normal = unitOrZero(glm::mix(normal, smooth.normal * side, smooth.weight));
      }
    }
    planes.add(body.frame.toWorld(point), body.frame.rotate(normal));
  }

  const ServoScene& scene_;
  HapticState& state_;
  ContactWork& work_;
  bool anyShaded_ = false;
};

}  // namespace

bool shadeGroove(const ServoScene& scene, HapticState& state, Vec3& ihip, ContactWork& work) noexcept {
  return ShadedGroove(scene, state, work).run(ihip);
}

}  // namespace haptics
