#pragma once

#include "common/maths/vec.h"

namespace haptics {

/// A field's value at a point, and how it changes there.
struct FieldSample {
  double value = 0;  ///< Dimensionless.
  Vec3 gradient{0};  ///< 1/m, object frame.
};

/// Bounds of a field's values.
struct FieldBounds {
  double lowest = 0,
         highest = 0;  ///< Of the value: never passed anywhere, and come near to within about 1 % (LayeredField: less).
  double slope_per_m = 0;       ///< Of |gradient|. Found by sampling, as is the curvature, where a family says so.
  double curvature_per_m2 = 0;  ///< Of |second derivative| along any direction.
};

/// A dimensionless function of the place, C0 and C1 as the paper's section 4.3.3 asks: f of a texture's height and of
/// friction's variation. Given in all of the object's frame; of the gradient only the part along the surface is used.
/// Immutable: every method may be called from any thread; at() neither allocates nor locks.
class ScalarField {
 public:
  virtual ~ScalarField() = default;
  ScalarField(const ScalarField&) = delete;
  ScalarField& operator=(const ScalarField&) = delete;

  /// \param point object frame, m; finite.
  [[nodiscard]] virtual FieldSample at(Vec3 point) const noexcept = 0;

  [[nodiscard]] const FieldBounds& bounds() const noexcept { return bounds_; }
  [[nodiscard]] double lowest() const noexcept { return bounds_.lowest; }
  [[nodiscard]] double highest() const noexcept { return bounds_.highest; }
  /// Length of the finest detail: to be compared with a mesh's edges and an encoder's steps.
  [[nodiscard]] double shortestWavelength_m() const noexcept { return shortestWavelength_m_; }

 protected:
  ScalarField(const FieldBounds& bounds, double shortestWavelength_m) noexcept
      : bounds_(bounds), shortestWavelength_m_(shortestWavelength_m) {}

 private:
  FieldBounds bounds_;
  double shortestWavelength_m_;
};

/// A field around a point of a surface, to second order, along two tangents at right angles.
struct FieldShape {
  double value = 0;
  glm::dvec2 slope{0};      ///< 1/m.
  glm::dmat2 curvature{0};  ///< 1/m^2, symmetric.
};

/// What a clamp of lateral stiffness needs, exactly there: with h = a * (value - lowest), Eq. (4a) pushes back sideways
/// with k K (grad h grad h^T + h H), bump mapping with k d H, H = a * curvature. Second derivatives by central
/// differences of gradients. \param normal unit.
[[nodiscard]] FieldShape shapeAround(const ScalarField& field, Vec3 point, Vec3 normal) noexcept;

}  // namespace haptics
