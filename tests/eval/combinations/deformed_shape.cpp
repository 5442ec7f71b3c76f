#include "tests/eval/combinations/deformed_shape.h"

#include <cmath>

namespace haptics::eval {
namespace {

double choose(std::uint32_t n, std::uint32_t k) {
  double product = 1;
  for (std::uint32_t i = 1; i <= k; ++i) product *= static_cast<double>(n - k + i) / i;
  return product;
}

double bernstein(std::uint32_t n, std::uint32_t k, double t) {
  return choose(n, k) * std::pow(t, k) * std::pow(1 - t, n - k);
}

Vec3 byLattice(const Lattice& lattice, Vec3 place) {
  const Vec3 t = (place - lattice.low_m) / lattice.size_m;
  Vec3 sum(0);
  for (std::uint32_t z = 0; z < lattice.points[2]; ++z) {
    for (std::uint32_t y = 0; y < lattice.points[1]; ++y) {
      for (std::uint32_t x = 0; x < lattice.points[0]; ++x) {
        const double weight = bernstein(lattice.points[0] - 1, x, t.x) * bernstein(lattice.points[1] - 1, y, t.y) *
                              bernstein(lattice.points[2] - 1, z, t.z);
        sum += Vec3(lattice.control_m[(z * lattice.points[1] + y) * lattice.points[0] + x]) * weight;
      }
    }
  }
  return sum;
}

Vec3 byDent(const DeformedShape::ExactDent& dent, Vec3 place) {
  const double part = glm::distance(place, dent.centre) / dent.radius_m;
  return part < 1 ? place + dent.displacement * std::pow(1 - part * part, dent.degree) : place;
}

}  // namespace

Vec3 DeformedShape::Point::gradient(Vec3 onMaterial) const {
  const Vec3 across = glm::cross(deformed[0], deformed[1]);
  const Vec3 first = glm::cross(deformed[1], across), second = glm::cross(across, deformed[0]);
  return (first * glm::dot(onMaterial, tangent[0]) + second * glm::dot(onMaterial, tangent[1])) /
         glm::dot(across, across);
}

Vec3 DeformedShape::onRest(Vec3 near) const {
  return radius_m_ > 0 ? glm::normalize(near) * radius_m_ : Vec3(near.x, near.y, height_m_);
}

Vec3 DeformedShape::restNormal(Vec3 material) const { return radius_m_ > 0 ? glm::normalize(material) : Vec3(0, 0, 1); }

Vec3 DeformedShape::walked(Vec3 material, Vec3 along) const {
  const double length = glm::length(along);
  if (!(radius_m_ > 0) || length == 0) return onRest(material + along);
  const double angle = length / radius_m_;
  return material * std::cos(angle) + along * (radius_m_ / length * std::sin(angle));
}

Vec3 DeformedShape::now(Vec3 material) const {
  Vec3 place = lattice_ ? byLattice(*lattice_, material) : material;
  for (const ExactDent& dent : dents_) place = byDent(dent, place);
  return place;
}

DeformedShape::Point DeformedShape::at(Vec3 material) const {
  constexpr double kApart_m = 1e-5;  // of central differences: their error is some 1e-7 of the slopes here
  Point point;
  point.material = onRest(material);
  const Vec3 up = restNormal(point.material);
  const Vec3 beside = std::abs(up.x) < 0.7 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  point.tangent[0] = glm::normalize(beside - glm::dot(beside, up) * up);
  point.tangent[1] = glm::cross(up, point.tangent[0]);
  point.place = now(point.material);
  for (int k = 0; k < 2; ++k) {
    const Vec3 step = point.tangent[k] * kApart_m;
    point.deformed[k] = (now(onRest(point.material + step)) - now(onRest(point.material - step))) / (2 * kApart_m);
  }
  point.normal = glm::normalize(glm::cross(point.deformed[0], point.deformed[1]));
  return point;
}

DeformedShape::Point DeformedShape::nearest(Vec3 h, Vec3 from) const {
  constexpr int kMaxSteps = 60;
  constexpr double kArrived_m = 1e-9;
  Point point = at(from);
  for (int i = 0; i < kMaxSteps; ++i) {
    const Vec3 missing = h - point.place;
    const Vec3 a = point.deformed[0], b = point.deformed[1];
    const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
    const double fa = glm::dot(a, missing), fb = glm::dot(b, missing);
    const double scale = 1 / (aa * bb - ab * ab);
    const Vec3 step =
        point.tangent[0] * ((bb * fa - ab * fb) * scale) + point.tangent[1] * ((aa * fb - ab * fa) * scale);
    point = at(point.material + step);
    if (glm::length(step) < kArrived_m) break;
  }
  return point;
}

}  // namespace haptics::eval
