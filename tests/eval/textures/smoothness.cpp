#include "tests/eval/textures/smoothness.h"

#include <algorithm>
#include <cmath>

namespace haptics::eval {
namespace {

constexpr int kPoints = 4000;
constexpr int kWalks = 40;

/// Central differences over a step so short that what they leave out is nothing beside 1e-4.
Vec3 differenced(const ScalarField& field, Vec3 point) {
  const double step_m = 1e-4 * field.shortestWavelength_m();
  Vec3 gradient(0);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 step(0);
    step[axis] = step_m;
    gradient[axis] = (field.at(point + step).value - field.at(point - step).value) / (2 * step_m);
  }
  return gradient;
}

double valueChange(const FieldSample& a, const FieldSample& b) { return std::abs(a.value - b.value); }
double gradientChange(const FieldSample& a, const FieldSample& b) { return glm::length(a.gradient - b.gradient); }

/// What is left of the change between two points after 24 halvings.
template <class Change>
double jumpBetween(const ScalarField& field, Vec3 a, Vec3 b, FieldSample atA, FieldSample atB, Change change) {
  for (int i = 0; i < 24; ++i) {
    const Vec3 middle = (a + b) * 0.5;
    const FieldSample atMiddle = field.at(middle);
    if (change(atA, atMiddle) > change(atMiddle, atB)) {
      b = middle;
      atB = atMiddle;
    } else {
      a = middle;
      atA = atMiddle;
    }
  }
  return change(atA, atB);
}

class JumpSearch {
 public:
  explicit JumpSearch(const ScalarField& field) : field_(field) {}

  void walk(const Walk& walk) {
    constexpr double kPerWavelength = 24;
    const double length_m = glm::distance(walk.from, walk.to);
    const int steps = std::max(2, static_cast<int>(kPerWavelength * length_m / field_.shortestWavelength_m()));
    Vec3 before = walk.from;
    FieldSample atBefore = field_.at(before);
    for (int i = 1; i <= steps; ++i) {
      const Vec3 here = glm::mix(walk.from, walk.to, static_cast<double>(i) / steps);
      const FieldSample atHere = field_.at(here);
      value_ = std::max(value_, jumpBetween(field_, before, here, atBefore, atHere, valueChange));
      gradient_ = std::max(gradient_, jumpBetween(field_, before, here, atBefore, atHere, gradientChange));
      before = here;
      atBefore = atHere;
    }
  }
  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] double gradient() const { return gradient_; }

 private:
  const ScalarField& field_;
  double value_ = 0;
  double gradient_ = 0;
};

/// About the middle, half of `length_m` each way.
Walk through(Vec3 middle, Vec3 direction, double length_m) {
  const Vec3 half = glm::normalize(direction) * (length_m / 2);
  return {middle - half, middle + half};
}

/// In the mapping's own frame.
std::vector<Walk> seamsOf(const Mapping& mapping, Random& random) {
  constexpr int kEach = 12;
  const double tile_m = mapping.tile_m;
  const double length_m = 0.3 * tile_m;
  const Vec3 half = mapping.size_m * 0.5;
  std::vector<Walk> seams;
  for (int i = 0; i < kEach; ++i) {
    const double anywhere = random.between(-1, 1);
    switch (mapping.shape) {
      case Mapping::Shape::kPlane:  // borders of tiles, across and along
        seams.push_back(through({tile_m / 2, anywhere * tile_m, 0}, {1, 0.3, 0}, length_m));
        seams.push_back(through({anywhere * tile_m, -tile_m / 2, 0}, {0.2, 1, 0}, length_m));
        break;
      case Mapping::Shape::kCylinder:  // where the turn closes, and the axis in the ends
        seams.push_back(through({-half.x, 0, anywhere * half.z}, {0, 1, 0.3}, length_m));
        seams.push_back(through({0, 0, half.z}, {anywhere, 1, 0}, half.x));
        break;
      case Mapping::Shape::kSphere: {
        const double latitude = 1.5 * anywhere;
        const Vec3 closing = half.x * Vec3(-std::cos(latitude), 0, std::sin(latitude));
        seams.push_back(through(closing, {0.1 * anywhere, 1, 0.2}, length_m));
        seams.push_back(through({0, 0, std::copysign(half.x, anywhere)}, {anywhere, 1, 0}, half.x));
        break;
      }
      case Mapping::Shape::kCube: {  // edges, corners, and the middle
        const Vec3 sign(random.sign(), random.sign(), random.sign());
        seams.push_back(through(sign * half * Vec3(1, 1, anywhere), sign * Vec3(1, -1, 0.2), length_m));
        seams.push_back(through(sign * half * Vec3(1, anywhere, 1), sign * Vec3(-1, 0.1, 1), length_m));
        seams.push_back(through(sign * half, random.direction(), length_m));
        seams.push_back(through(Vec3(0), random.direction(), half.x));
        break;
      }
    }
  }
  return seams;
}

/// On the intermediate surface, in its own frame.
Vec3 onSurface(const Mapping& mapping, Random& random) {
  const Vec3 half = mapping.size_m * 0.5;
  const auto within = [&] { return random.between(-1, 1); };
  switch (mapping.shape) {
    case Mapping::Shape::kPlane:
      return {2 * mapping.tile_m * within(), 2 * mapping.tile_m * within(), 0};
    case Mapping::Shape::kSphere:
      return half.x * random.direction();
    case Mapping::Shape::kCylinder: {
      const double turn = std::numbers::pi * within();
      const double height = within();
      const bool end = random.below(4) == 0;
      const double radius = half.x * (end ? std::sqrt(random.between(0, 1)) : 1);
      return {radius * std::cos(turn), radius * std::sin(turn), half.z * (end ? std::copysign(1.0, height) : height)};
    }
    case Mapping::Shape::kCube: {
      Vec3 place(within(), within(), within());
      place[random.below(3)] = random.sign();
      return place * half;
    }
  }
  return Vec3(0);
}

}  // namespace

Region cubeOf(double side_m) {
  const auto within = [side_m](Random& random) { return side_m * random.between(-0.5, 0.5); };
  return {[within](Random& random) {
            const double x = within(random);
            const double y = within(random);
            return Vec3(x, y, within(random));
          },
          {}};
}

Region regionOf(const Mapping& mapping, Random& random) {
  const auto inObject = [mapping](Vec3 point) { return mapping.rotation * point + mapping.centre; };
  Region region;
  region.point = [mapping, inObject](Random& any) {
    const Vec3 place = onSurface(mapping, any);
    return inObject(place * any.between(0.9, 1.1));
  };
  for (const Walk& seam : seamsOf(mapping, random)) region.seams.push_back({inObject(seam.from), inObject(seam.to)});
  return region;
}

Smoothness smoothnessOf(const ScalarField& field, const Region& region, Random& random) {
  double steepest = 0;
  double error = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3 point = region.point(random);
    const Vec3 gradient = field.at(point).gradient;
    steepest = std::max(steepest, glm::length(gradient));
    error = std::max(error, glm::length(gradient - differenced(field, point)));
  }
  JumpSearch search(field);
  const double length_m = 12 * field.shortestWavelength_m();
  for (int i = 0; i < kWalks; ++i) search.walk(through(region.point(random), random.direction(), length_m));
  for (const Walk& seam : region.seams) search.walk(seam);
  return {error / steepest, search.value() / (field.highest() - field.lowest()), search.gradient() / steepest};
}

}  // namespace haptics::eval
