#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/deform/triangle_map.h"
#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"
#include "haptic_server/engine/surface/friction.h"
#include "haptic_server/engine/surface/shading_normals.h"
#include "haptic_server/engine/surface/texture_law.h"

namespace haptics {

/// A texture as the tick evaluates it. Object frame.
class TextureDetail {
 public:
  /// Places at which the height is sampled. More find a steeper one on a large surface.
  static constexpr std::uint32_t kSamples = 4096;

  /// Samples the height over the surface for what gainFor() needs: some milliseconds.
  /// `material` as in SurfaceDetail.
  TextureDetail(const CollisionMesh& surface, const Texture& texture, std::shared_ptr<const ScalarField> field,
                const std::vector<Vec3f>* material = nullptr);

  /// At a place of the material.
  [[nodiscard]] HeightSample at(Vec3 place) const noexcept;
  [[nodiscard]] Texture::Law law() const noexcept { return law_; }
  /// Largest height: no contact is farther outside.
  [[nodiscard]] double highest_m() const noexcept { return highest_m_; }
  /// Largest eigenvalue of grad h grad h^T + h H(h) over the surface: times k K it is the largest lateral stiffness of
  /// Eq. (4a). Dimensionless; found by sampling, so that it may be a little less than the true one.
  [[nodiscard]] double steepness() const noexcept { return steepness_; }
  /// K as it was asked for, or less: so that the texture is sideways no stiffer than `most_N_per_m` on a surface of this
  /// stiffness.
  [[nodiscard]] double gainFor(double stiffness_N_per_m, double most_N_per_m) const noexcept;
  /// The same for bump mapping, which has no K: the part of the slopes, all or less, with which it is felt at a depth.
  /// Sideways it is a spring of k (grad h grad h^T + d H(h)), stiffer the deeper. With less than all it is not
  /// conservative.
  [[nodiscard]] double slopeShareFor(double depth_m, double stiffness_N_per_m, double most_N_per_m) const noexcept {
    const double lateral = stiffness_N_per_m * (squaredSlope_ + depth_m * curvature_per_m_);
    return lateral > most_N_per_m ? most_N_per_m / lateral : 1;
  }

 private:
  std::shared_ptr<const ScalarField> field_;
  Texture::Law law_;
  double amplitude_m_;
  double zero_;  // the value of the field where h = 0
  double gain_;
  double highest_m_;
  double steepness_ = 0;
  double squaredSlope_ = 0;     // of grad h, the largest
  double curvature_per_m_ = 0;  // eigenvalue of H(h), the largest
};

/// What a factor over a surface is made of: a field, a value >= 0 for each vertex (canonical numbering), or nothing.
struct FactorSource {
  std::shared_ptr<const ScalarField> field = nullptr;
  std::shared_ptr<const std::vector<float>> scale = nullptr;
};

/// A factor at a place, and how it changes along the surface as it is there (1/m, object frame).
struct FactorSample {
  double value = 1;
  Vec3 gradient{0};
};

/// A factor over a surface, of friction or of a stiffness; 1 without a map.
class SurfaceFactor {
 public:
  /// \param variation with which it is 1 + variation * f over a field.
  /// \param least below which it nowhere is.
  SurfaceFactor(double variation, FactorSource source, double least = 0);

  /// As FrictionDetail::at.
  [[nodiscard]] double at(const TriangleRecord& triangle, const Vec3& place, const Vec3& onMaterial) const noexcept;
  /// At a place on a triangle of the surface at rest. The gradient is 0 where the factor is at its least, and at `most`.
  /// \param material as in SurfaceDetail.
  /// \param most above which the factor nowhere is.
  [[nodiscard]] FactorSample sample(const TriangleRecord& triangle, const Vec3& place,
                                    const std::vector<Vec3f>* material, double most) const noexcept;
  [[nodiscard]] bool varies() const noexcept { return source_.field != nullptr || source_.scale != nullptr; }
  [[nodiscard]] double highest() const noexcept;
  /// Largest stiffness along the surface of a spring of k times the factor that is d long: by E = k f d^2 / 2 the second
  /// derivatives are k f'' d^2 / 2 along it and k f' d beside it. 0 for values per vertex, which have none.
  [[nodiscard]] double lateralStiffness_N_per_m(double spring_N_per_m, double length_m) const noexcept {
    return spring_N_per_m * length_m * (length_m / 2 * curvature_per_m2_ + slope_per_m_);
  }

 private:
  double variation_;
  FactorSource source_;
  double least_;
  double slope_per_m_ = 0, curvature_per_m2_ = 0;  // of the factor over a field, the largest
};

/// Friction coefficients over a surface. Object frame.
class FrictionDetail {
 public:
  /// `own` is mu_dynamic's instead of `both`, if it varies: mu_dynamic(x) is then cut off at mu_static(x), as StickSlip
  /// needs it.
  FrictionDetail(const Friction& friction, SurfaceFactor both, SurfaceFactor own);

  /// At a place on a triangle of the surface, as it is, and where that is on the material.
  [[nodiscard]] FrictionCoefficients at(const TriangleRecord& triangle, const Vec3& place,
                                        const Vec3& onMaterial) const noexcept;
  [[nodiscard]] bool varies() const noexcept { return varies_; }
  /// Without the maps.
  [[nodiscard]] FrictionCoefficients mean() const noexcept { return mean_; }
  /// The largest static one.
  [[nodiscard]] double most() const noexcept { return most_; }
  /// c of paper 4.2: friction's spring is nowhere stiffer than the surface, nor than `most_N_per_m`.
  [[nodiscard]] double stiffnessFor(double stiffness_N_per_m, double most_N_per_m) const noexcept {
    return std::min(stiffness_N_per_m, most_N_per_m) / most_;
  }

 private:
  FrictionCoefficients mean_;
  SurfaceFactor factor_;         // of both
  SurfaceFactor dynamicFactor_;  // of the dynamic one instead, if it varies
  double most_;
  bool varies_;
};

/// How an object's surface feels beyond its shape (paper 4). Immutable; built off the servo thread.
struct SurfaceDetail {
  std::shared_ptr<const ShadingNormals> shading;  ///< Null: as the polygons are.
  std::optional<FrictionDetail> friction;
  std::optional<TextureDetail> texture;
  std::optional<SurfaceFactor> stiffness;  ///< Of the contact's spring and damper.
  std::optional<SurfaceFactor> softness;   ///< Of the tissue's spring.
  /// Where lattice and residue have moved the surface at rest, its vertices on the material, canonical numbering: fields are
  /// given there. Null where nothing moved them, or there is no field.
  std::shared_ptr<const std::vector<Vec3f>> material;
  SurfaceScalars<double> scalars;
  double reach_m = 0;  ///< Nothing of it is felt farther outside of the polygons.

  [[nodiscard]] bool hasHeight() const noexcept { return shading != nullptr || texture.has_value() || reach_m > 0; }
  /// Nor is the felt surface.
  [[nodiscard]] double highest_m() const noexcept {
    return std::max(0.0, (shading ? shading->highestBulge_m() : 0) + (texture ? texture->highest_m() : 0));
  }
};

/// What a detail is made of beside the records: the fields that they name, null where they name none.
struct DetailFields {
  std::shared_ptr<const ScalarField> texture;
  std::shared_ptr<const ScalarField> friction;
  std::shared_ptr<const std::vector<float>> frictionScale;  ///< A factor >= 0 for each vertex, canonical numbering.
  std::shared_ptr<const std::vector<Vec3f>> material = nullptr;  ///< As in SurfaceDetail.
  /// Field of the dynamic coefficient's own map.
  std::shared_ptr<const ScalarField> dynamicFriction = nullptr;
  std::shared_ptr<const std::vector<float>> dynamicFrictionScale = nullptr;
  FactorSource stiffness = {}, softness = {};
};

/// Corners of a triangle, or of the same triangle at rest on the material where that is not null.
[[nodiscard]] TriangleMap::Corners cornersOf(const TriangleRecord& triangle,
                                             const std::vector<Vec3f>* material = nullptr) noexcept;

/// Null when there is nothing beyond the shape. For the builder thread; an object keeps its detail, the same pointer,
/// until its mesh or one of its properties changes. `normals` are those of an earlier detail of the same surface with the
/// same shading, or null.
[[nodiscard]] std::shared_ptr<const SurfaceDetail> makeSurfaceDetail(
    const CollisionMesh& surface, const SurfaceProperties& properties, const DetailFields& fields,
    std::shared_ptr<const ShadingNormals> normals = {});

}  // namespace haptics
