#pragma once

#include <optional>

#include "haptic_server/engine/geometry/dented_surface.h"
#include "haptic_server/engine/step/body_dents.h"
#include "haptic_server/engine/surface/force_shading.h"

namespace haptics {

/// A soft body that the IHIP is pressed into. Object frame, metres.
struct PressedBody {
  std::size_t body = 0;
  ClosestPoint atRest;         ///< What holds the IHIP, and the IHIP, on the shape without dents.
  int side = 1;                ///< As in ContactSurface.
  Vec3 h{0};                   ///< The HIP, or where the body sees it.
  bool below = false;          ///< It is below the shape without dents.
  double contact_N_per_m = 0;  ///< Of the contact's spring.
  bool alone = false;          ///< No other body holds the IHIP: force shading tells the way that the dent goes.
  double softness = 1;         ///< Factor of the tissue's stiffness.
};

/// One tick of one soft body that yields to the contact.
class DentSolver {
 public:
  /// On a body with some of its dents: where it is nearest to a point.
  struct Nearest {
    ClosestPoint foot;
    Vec3 normal{0};
    bool outside = false;  ///< The point is.
  };

  /// @param work  Of the contact core, which the triangles looked at are added to.
  DentSolver(const ServoScene& scene, HapticState& state, const StepConfig& config, ContactWork& work,
             const PressedBody& pressed) noexcept;

  /// Makes the contact's dent, or goes on in it, and lets the tissue yield. False where the other dents leave the HIP
  /// outside.
  [[nodiscard]] bool press() noexcept;

  /// y^2 of the tissue's energy t y^2 / 2, less that of what had stayed in a plastic tissue before; m^2. Of the last press().
  [[nodiscard]] double elastic_m2() const noexcept { return elastic_m2_; }

  /// The dented surface as force shading sees it from the HIP, of weight 0 without shading or dent. Of the last press(). In
  /// the middle of the contact's dent, where the falloff is level, it has the normal of before, and lies as much lower as
  /// the tissue yields; but its bulge is that of before.
  [[nodiscard]] const ShadedPoint& smooth() const noexcept { return smooth_; }
  /// Where that is without the contact's dent; object frame, m.
  [[nodiscard]] Vec3 foot() const noexcept { return Vec3(dent().dent.centre); }

  /// On the body with all of its dents, from what holds the IHIP at rest.
  [[nodiscard]] Nearest nearestTo(const Vec3& point) noexcept;

 private:
  [[nodiscard]] Nearest nearest(const BodyDents& dents, const Vec3& point) noexcept;
  [[nodiscard]] bool findFoot(const BodyDents& others, ClosestPoint& foot) noexcept;
  [[nodiscard]] bool isElsewhere(const ClosestPoint& foot) const noexcept;
  [[nodiscard]] bool begin() noexcept;
  [[nodiscard]] bool continueNewestDent() noexcept;
  void evictWeakestDent() noexcept;
  void yield(const BodyDents& others, ClosestPoint at) noexcept;
  void shadeFoot(ClosestPoint& foot, const BodyDents& others, Vec3& parts) noexcept;
  void moveOn(Vec3 foot) noexcept;
  void remember(BodyDent& pressed) const noexcept;
  [[nodiscard]] double room_m() const noexcept;
  [[nodiscard]] double seenOn(const BodyDents& others, const ClosestPoint& foot, const Dent& dent) const noexcept;
  [[nodiscard]] double seenOn(const TriangleRecord& triangle, const Vec3& parts, const Dent& dent) const noexcept;
  [[nodiscard]] BodyDent& dent() const noexcept { return state_.dents[*at_]; }

  /// The dents of a second hand go back: none is baked.
  [[nodiscard]] bool isPlastic() const noexcept { return tissue_.plastic > 0 && !state_.motion.follows; }

  const SoftTissue& tissue_;
  const ShadingNormals* shading_;  // null: as the polygons are
  HapticState& state_;
  const StepConfig& config_;
  ContactWork& work_;
  const PressedBody& pressed_;
  const Body& body_;
  std::optional<std::size_t> at_;  // the contact's dent
  double elastic_m2_ = 0;
  ShadedPoint smooth_;
};

}  // namespace haptics
