#pragma once

#include <array>

#include "haptic_server/engine/geometry/triangle_record.h"
#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/friction_forces.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/held_springs.h"

namespace haptics {

/// Section 4 of the paper, for scenes in which some object has surface properties, moves or is soft. Its stages, in this order:
/// force shading gives the direction N_s, a texture adds its height to the depth and turns the force, a spring with a
/// damper acts along N_s, and friction follows from what is felt along it. The stages are in surface_stages.h.
class SurfaceForceModel {
 public:
  /// @param[in,out] result  Its contact as it is held; after writeResult() as it is felt: IHIP, N_s and depth with shading and
  /// texture, touching also where only a bump reaches the HIP. Forces, height and friction are added.
  SurfaceForceModel(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& result) noexcept
      : scene_(scene),
        state_(state),
        memory_(state.surface),
        config_(config),
        contact_(result.contact),
        result_(result),
        held_m_(result.contact.ihip - state.estimate.hip) {}

  /// What the contact core holds, or is met within its dent, along the shading normal where there is one (paper 4.1).
  void addShading() noexcept;
  /// Its height, and what else reaches the HIP with a bump (paper 4.3.1): "there may be a collision between the HIP and
  /// the texture-mapped surface even when no collision exists between the HIP and the original surface".
  void addTexture() noexcept;
  /// The springs of all of them along N_s, with what textures make of the force (paper 3 and 4.3.2), and their dampers.
  void addSpringDamper() noexcept;
  /// On what is touched, or on the bump that reaches the HIP (paper 4.2).
  void addFriction() noexcept;
  void writeResult() noexcept;

 private:
  /// Objects felt at once, beside the touched one those whose bumps reach the HIP. More are left out.
  static constexpr std::size_t kMaxTouches = 8;

  /// A surface as it is felt in this tick; world frame. Without initialisers: not all of the list is used.
  struct SurfaceContact {
    std::size_t body;
    std::uint32_t triangle;
    Vec3 from;           ///< The HIP; the IHIP on another body, where that is what comes near this one.
    Vec3 normal;         ///< N_s, unit, towards the hand.
    double geometric_m;  ///< Depth of `from` below the geometric surface along it; negative outside.
    double bulge_m;      ///< Of shading, beyond that; addTextureHeight() adds it to the depth.
    double height_m;     ///< Of the texture.
    Vec3 gradient;
    double depth_m;  ///< d: below the textured surface.
    double speed_m_per_s;
    bool shaded;      ///< N_s is a shading normal.
    bool inHollow;    ///< The HIP is above the dents of a soft body, in the shape that it has without them or near it.
    bool heightOnly;  ///< One of several bodies that hold the IHIP: what is without the height is felt with the first.

    [[nodiscard]] Vec3 ihip() const noexcept { return from + geometric_m * normal; }
  };
  /// Of a body, the place that is nearest to a point of its frame; m.
  struct NearPlace {
    ClosestPoint foot;
    Vec3 normal{0};
    int side = 1;           ///< On which of a surface that is not closed the point is.
    bool isOutside = true;  ///< The point is.
  };
  [[nodiscard]] const ServoObject& object(std::size_t body) const noexcept { return scene_.objects[body]; }
  [[nodiscard]] const SurfaceDetail* detail(std::size_t body) const noexcept { return object(body).detail.get(); }
  [[nodiscard]] bool hasTexture(std::size_t body) const noexcept {
    return detail(body) != nullptr && detail(body)->texture.has_value();
  }
  [[nodiscard]] bool hasShading(std::size_t body) const noexcept {
    return detail(body) != nullptr && detail(body)->shading != nullptr;
  }
  [[nodiscard]] Stiffness stiffness(const SurfaceContact& touch) const noexcept {
    return state_.objects[touch.body].stiffness.value();
  }

  [[nodiscard]] bool isTouched(std::size_t body) const noexcept {
    return contact_.touching && static_cast<std::size_t>(contact_.body) == body;
  }
  /// Two points this far apart: does their difference say more than how they were rounded? Without a texture it does not
  /// matter, for then the force is as small.
  [[nodiscard]] bool exceedsRounding(double apart_m, std::size_t body) const noexcept {
    constexpr double kRounding = 0x1p-30;  // of the coordinates, which leaves the direction 2^-22
    return apart_m > kRounding * state_.bodies[body].extent_m;
  }
  [[nodiscard]] bool hasVaryingStiffness(std::size_t body) const noexcept {
    return detail(body) != nullptr && detail(body)->stiffness.has_value();
  }
  /// Its stiffness is that of the shaded point.
  [[nodiscard]] bool isShadedRigid(std::size_t body) const noexcept {
    return memory_.fade.mode == ShadingFade::Mode::kAlone && object(body).tissue == nullptr;
  }

  // surface_stages.h
  void shadeTouched(SurfaceContact& touch) noexcept;
  void fadeShading(SurfaceContact& touch, ShadingFade::Mode mode, Vec3 unshaded, double unshaded_m) noexcept;
  void updateStiffnesses() noexcept;

  // surface_shading.cpp
  [[nodiscard]] bool shadeTogether(SurfaceContact& touch) noexcept;
  /// Returns whether there is a shading normal.
  [[nodiscard]] bool shadeAt(SurfaceContact& touch, const ClosestPoint& foot, int side) const noexcept;
  [[nodiscard]] ShadedPoint shadeDented(const SurfaceContact& touch, const SoftTissue& tissue, const ClosestPoint& foot,
                                        const Vec3& h, double depth_m) const noexcept;
  void fadeSwitch() noexcept;
  [[nodiscard]] double maxSwitched_N() const noexcept;

  // surface_texture.cpp
  void computeBumpForces() noexcept;
  /// Of a body that holds the IHIP with others. Returns whether its texture is felt.
  [[nodiscard]] bool takeHeldSurface(SurfaceContact& touch, std::size_t held) noexcept;
  /// Of a surface that is not touched. Returns whether its bumps reach there.
  [[nodiscard]] bool findNearestPoint(SurfaceContact& touch) noexcept;
  /// Of a body without its dents, makes the one with them.
  void moveOntoDents(NearPlace& near, std::size_t body, const Vec3& h) noexcept;
  void addTextureHeight(SurfaceContact& touch, BumpState& bump) noexcept;
  [[nodiscard]] HeightSample reliefOnMaterial(const SurfaceContact& touch, const Vec3& place) noexcept;

  // surface_forces.cpp
  void varyBeside(const SurfaceContact& touch) noexcept;
  void addForce(const SurfaceContact& touch) noexcept;
  void pushAlong() noexcept;
  void computeFrictionOnEach(const PressedSurface& all, const Vec3& ihip) noexcept;

  const ServoScene& scene_;
  HapticState& state_;
  SurfaceMemory& memory_;
  const StepConfig& config_;
  ContactResult& contact_;
  ForceResult& result_;
  Vec3 held_m_;      // from the HIP to the IHIP of the contact core
  Vec3 unshaded_m_;  // of the touched one, without shading
  std::array<SurfaceContact, kMaxTouches> touches_;
  std::size_t count_ = 0;
  TriangleRecord dented_;       // the last that dentedTriangle() was asked for
  std::size_t dentedBody_ = 0;  // of that
  std::uint32_t dentedIndex_ = kNoTriangle;
  bool switched_ = false;  // from one body's shading to that of several together, or back
};

}  // namespace haptics
