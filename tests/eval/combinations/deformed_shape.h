#pragma once

#include <optional>
#include <vector>

#include "common/maths/vec.h"
#include "common/scene/deformation_properties.h"

namespace haptics::eval {

/// A smooth surface and what has deformed it, exact: a plane or a sphere, then a lattice, then dents, each by its
/// formula. Shares no code with the runtime, and has no mesh. Object frame, metres.
class DeformedShape {
 public:
  /// Of polynomial falloff (1 - (distance / radius)^2)^degree.
  struct ExactDent {
    Vec3 centre{0};
    Vec3 displacement{0};
    double radius_m = 0;
    unsigned degree = 2;
  };
  struct Point {
    Vec3 material{0};  ///< On the shape before anything deformed it.
    Vec3 place{0};     ///< Where that is now.
    Vec3 normal{0};    ///< There, unit: J^-T n as the cross product of what became of two tangents.
    Vec3 tangent[2];   ///< On the material, unit and square to each other,
    Vec3 deformed[2];  ///< and what they have become.

    /// Of a function with this gradient on the material, that along the deformed surface.
    [[nodiscard]] Vec3 gradient(Vec3 onMaterial) const;
  };

  /// z = height_m, seen from above.
  [[nodiscard]] static DeformedShape plane(double height_m) { return DeformedShape(height_m, 0); }
  /// About the origin, from outside.
  [[nodiscard]] static DeformedShape sphere(double radius_m) { return DeformedShape(0, radius_m); }
  void shapeBy(const Lattice& lattice) { lattice_ = lattice; }
  void dent(const ExactDent& dent) { dents_.push_back(dent); }

  [[nodiscard]] Vec3 now(Vec3 material) const;
  [[nodiscard]] Point at(Vec3 material) const;
  /// To h, from a material point near it: Gauss and Newton's method.
  [[nodiscard]] Point nearest(Vec3 h, Vec3 from) const;
  /// On the shape at rest: from a point of it, so far (m) along tangents. On a sphere along great circles.
  [[nodiscard]] Vec3 walked(Vec3 material, Vec3 along) const;
  [[nodiscard]] Vec3 restNormal(Vec3 material) const;

 private:
  DeformedShape(double height_m, double radius_m) : height_m_(height_m), radius_m_(radius_m) {}
  [[nodiscard]] Vec3 onRest(Vec3 near) const;

  double height_m_;
  double radius_m_;  // 0: a plane
  std::optional<Lattice> lattice_;
  std::vector<ExactDent> dents_;
};

}  // namespace haptics::eval
