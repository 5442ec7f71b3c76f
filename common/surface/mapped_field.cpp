#include "common/surface/mapped_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/maths/elementary.h"
#include "common/surface/fade.h"

namespace haptics {
namespace {

/// Faces of a box go over into each other where |a - b| / (a + b) is less, a and b their parts of half a side.
constexpr double kBlend = 1.0 / 9;
constexpr double kFlatWithin = 0.125;  ///< Of the radius: there the field is its mean,
constexpr double kWholeBeyond = 0.25;  ///< and from here on itself.

/// Plane field, scaled: coordinates in metres from the middle of a tile.
class Tiles {
 public:
  Tiles(std::shared_ptr<const SampledField> field, double tile_m)
      : field_(std::move(field)),
        perMetre_(field_->width() / tile_m),
        middle_(0.5 * (field_->width() - 1.0), 0.5 * (field_->height() - 1.0)) {}

  struct Sample {
    double value;
    glm::dvec2 gradient;  // 1/m
  };
  [[nodiscard]] Sample at(double x_m, double y_m) const noexcept {
    const SampledField::Sample s = field_->at(x_m * perMetre_ + middle_.x, y_m * perMetre_ + middle_.y);
    return {s.value, s.gradient * perMetre_};
  }
  [[nodiscard]] double mean() const noexcept { return field_->mean(); }
  [[nodiscard]] FieldBounds bounds() const noexcept {
    const SplineBounds& b = field_->bounds();
    return {b.lowest, b.highest, b.slope * perMetre_, b.curvature * perMetre_ * perMetre_};
  }
  /// Two samples: what the grid can hold.
  [[nodiscard]] double shortestWavelength_m() const noexcept { return 2 / perMetre_; }

 private:
  std::shared_ptr<const SampledField> field_;
  double perMetre_;
  glm::dvec2 middle_;
};

/// The frame of the intermediate surface.
class Frame {
 public:
  explicit Frame(const Mapping& mapping)
      : toSurface_(glm::transpose(glm::mat3_cast(mapping.rotation))), centre_(mapping.centre) {}

  [[nodiscard]] Vec3 local(Vec3 point) const noexcept { return toSurface_ * (point - centre_); }
  [[nodiscard]] Vec3 gradient(Vec3 local) const noexcept { return local * toSurface_; }

 private:
  glm::dmat3 toSurface_;
  Vec3 centre_;
};

/// A field and its mean: 0 gives the mean, 1 the field.
Ramp presence(double distance) noexcept {
  const double t = (distance - kFlatWithin) / (kWholeBeyond - kFlatWithin);
  if (t <= 0) return {0, 0};
  if (t >= 1) return {1, 0};
  const Ramp r = fade(t);
  return {r.value, r.slope / (kWholeBeyond - kFlatWithin)};
}

class OnPlane final : public ScalarField {
 public:
  OnPlane(const Tiles& tiles, const Mapping& mapping)
      : ScalarField(tiles.bounds(), tiles.shortestWavelength_m()), tiles_(tiles), frame_(mapping) {}

  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override {
    const Vec3 p = frame_.local(point);
    const Tiles::Sample s = tiles_.at(p.x, p.y);
    return {s.value, frame_.gradient({s.gradient, 0})};
  }

 private:
  Tiles tiles_;
  Frame frame_;
};

class AroundAxis final : public ScalarField {
 public:
  AroundAxis(const Tiles& tiles, const Mapping& mapping)
      : ScalarField(boundsOf(tiles, mapping), tiles.shortestWavelength_m()),
        tiles_(tiles),
        frame_(mapping),
        radius_m_(0.5 * mapping.size_m.x),
        sphere_(mapping.shape == Mapping::Shape::kSphere) {}

  /// Side of the tiles of which the turn holds a whole number.
  [[nodiscard]] static double wholeTile_m(const Mapping& mapping) {
    const double turn_m = std::numbers::pi * mapping.size_m.x;
    return turn_m / std::max(1.0, std::round(turn_m / mapping.tile_m));
  }

  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override {
    const Vec3 p = frame_.local(point);
    const double fromAxis = std::sqrt(p.x * p.x + p.y * p.y);
    const Ramp present = presence(fromAxis / radius_m_);
    if (present.value == 0) return {tiles_.mean(), Vec3(0)};

    const double perFromAxis = 1 / fromAxis;
    const Vec3 outward(p.x * perFromAxis, p.y * perFromAxis, 0);
    const Vec3 alongTurn = radius_m_ * perFromAxis * Vec3(-outward.y, outward.x, 0);
    const double turn_m = radius_m_ * elementary::atan2(p.y, p.x);
    double height_m = p.z;
    Vec3 alongHeight(0, 0, 1);
    if (sphere_) {
      height_m = radius_m_ * elementary::atan2(p.z, fromAxis);
      alongHeight = (radius_m_ / (fromAxis * fromAxis + p.z * p.z)) * (Vec3(0, 0, fromAxis) - p.z * outward);
    }

    const Tiles::Sample s = tiles_.at(turn_m, height_m);
    const double above = s.value - tiles_.mean();
    const Vec3 gradient = present.value * (s.gradient.x * alongTurn + s.gradient.y * alongHeight) +
                          above * present.slope / radius_m_ * outward;
    return {tiles_.mean() + present.value * above, frame_.gradient(gradient)};
  }

 private:
  Tiles tiles_;
  Frame frame_;
  double radius_m_;
  bool sphere_;

  /// The coordinates' own curvature adds slope / radius.
  [[nodiscard]] static FieldBounds boundsOf(const Tiles& tiles, const Mapping& mapping) {
    FieldBounds bounds = tiles.bounds();
    bounds.curvature_per_m2 += bounds.slope_per_m / (0.5 * mapping.size_m.x);
    return bounds;
  }
};

class OnBox final : public ScalarField {
 public:
  OnBox(const Tiles& tiles, const Mapping& mapping)
      : ScalarField(boundsOf(tiles, mapping), tiles.shortestWavelength_m()),
        tiles_(tiles),
        frame_(mapping),
        perHalf_(2.0 / mapping.size_m) {}

  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override {
    const Vec3 p = frame_.local(point);
    const Vec3 part = glm::abs(p) * perHalf_;
    const double fromMiddle = glm::length(part);
    const Ramp present = presence(fromMiddle);
    if (present.value == 0) return {tiles_.mean(), Vec3(0)};

    const Share xy = share(part, 0, 1), yz = share(part, 1, 2), zx = share(part, 2, 0);
    const std::array<Share, 3> weights{xy * rest(zx), yz * rest(xy), zx * rest(yz)};
    Share all{0, Vec3(0)};
    double sum = 0;
    Vec3 slope(0), bySide(0);  // of the sum, from the faces and from the weights
    for (int axis = 0; axis < 3; ++axis) {
      const Share& weight = weights[axis];
      if (weight.value == 0) continue;
      const FieldSample face = onFace(axis, p);
      all = {all.value + weight.value, all.slope + weight.slope};
      sum += weight.value * face.value;
      slope += weight.value * face.gradient;
      bySide += face.value * weight.slope;
    }
    const double perAll = 1 / all.value;
    const double blended = sum * perAll;
    const double above = blended - tiles_.mean();
    bySide = present.value * perAll * (bySide - blended * all.slope) + above * present.slope / fromMiddle * part;
    const Vec3 outward(std::copysign(1, p.x), std::copysign(1, p.y), std::copysign(1, p.z));
    return {tiles_.mean() + present.value * above,
            frame_.gradient(present.value * perAll * slope + bySide * outward * perHalf_)};
  }

 private:
  Tiles tiles_;
  Frame frame_;
  Vec3 perHalf_;  // 1/m: 1 / half a side

  /// A weight and its derivatives by |x|, |y| and |z| over half a side.
  struct Share {
    double value;
    Vec3 slope;

    friend Share operator*(const Share& a, const Share& b) noexcept {
      return {a.value * b.value, a.value * b.slope + b.value * a.slope};
    }
  };
  [[nodiscard]] static Share rest(const Share& a) noexcept { return {1 - a.value, -a.slope}; }
  /// Blend weight of the faces of the first axis against those of the second: 1 where its part is larger by far.
  [[nodiscard]] static Share share(Vec3 part, int first, int second) noexcept {
    const double sum = part[first] + part[second];
    const double t = 0.5 + (part[first] - part[second]) / (2 * kBlend * sum);
    if (!(t > 0)) return {0, Vec3(0)};
    if (t >= 1) return {1, Vec3(0)};
    const Ramp r = fade(t);
    Share result{r.value, Vec3(0)};
    result.slope[first] = r.slope * part[second] / (kBlend * sum * sum);
    result.slope[second] = -r.slope * part[first] / (kBlend * sum * sum);
    return result;
  }

  /// The field on the face that the axis goes through, laid on it so that it is not mirrored from outside.
  [[nodiscard]] FieldSample onFace(int axis, Vec3 p) const noexcept {
    const double side = std::copysign(1, p[axis]);
    const auto [right, up, sign] = std::array{Face{1, 2, side}, Face{0, 2, -side}, Face{0, 1, side}}[axis];
    const Tiles::Sample s = tiles_.at(sign * p[right], p[up]);
    Vec3 gradient(0);
    gradient[right] = sign * s.gradient.x;
    gradient[up] = s.gradient.y;
    return {s.value, gradient};
  }
  struct Face {
    int right, up;
    double sign;
  };

  /// Blending from one face to another adds the weights' slope, at most 15/8 / length, to that of the field.
  [[nodiscard]] static FieldBounds boundsOf(const Tiles& tiles, const Mapping& mapping) {
    FieldBounds bounds = tiles.bounds();
    const double length_m = 2 * kBlend * std::min({mapping.size_m.x, mapping.size_m.y, mapping.size_m.z});
    const double range = bounds.highest - bounds.lowest, slope = bounds.slope_per_m;
    bounds.slope_per_m += 1.9 * range / length_m;
    bounds.curvature_per_m2 += 4 * slope / length_m + 6 * range / (length_m * length_m);
    return bounds;
  }
};

}  // namespace

std::shared_ptr<const ScalarField> makeMappedField(std::shared_ptr<const SampledField> field, const Mapping& mapping) {
  switch (mapping.shape) {
    case Mapping::Shape::kPlane:
      return std::make_shared<const OnPlane>(Tiles(std::move(field), mapping.tile_m), mapping);
    case Mapping::Shape::kCube:
      return std::make_shared<const OnBox>(Tiles(std::move(field), mapping.tile_m), mapping);
    case Mapping::Shape::kCylinder:
    case Mapping::Shape::kSphere:
      return std::make_shared<const AroundAxis>(Tiles(std::move(field), AroundAxis::wholeTile_m(mapping)), mapping);
  }
  return nullptr;
}

}  // namespace haptics
