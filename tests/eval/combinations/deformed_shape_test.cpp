#include "tests/eval/combinations/deformed_shape.h"

#include <gtest/gtest.h>

namespace haptics::eval::deformed_shape_test {
namespace {

TEST(DeformedShape, IsNearestToAPointAlongItsNormal) {
  const Vec3 h(0.013, -0.02, 0.035);
  const auto onBall = DeformedShape::sphere(0.05).nearest(h, Vec3(0, 0, 0.05));
  EXPECT_LT(glm::distance(onBall.place, glm::normalize(h) * 0.05), 1e-9);
  EXPECT_LT(glm::distance(onBall.normal, glm::normalize(h)), 1e-8);
  const auto onPlane = DeformedShape::plane(0.05).nearest(h, Vec3(0, 0, 0.05));
  EXPECT_LT(glm::distance(onPlane.place, Vec3(h.x, h.y, 0.05)), 1e-9);

  DeformedShape dented = DeformedShape::sphere(0.05);
  dented.dent({Vec3(0, 0, 0.05), Vec3(0.0005, 0, -0.003), 0.02, 2});
  const auto found = dented.nearest(Vec3(0.004, 0.003, 0.044), Vec3(0, 0, 0.05));
  EXPECT_LT(glm::length(glm::cross(found.place - Vec3(0.004, 0.003, 0.044), found.normal)), 1e-8);
}

TEST(DeformedShape, TurnsTheNormalOfADentByTheInverseTransposeOfItsJacobian) {
  const DeformedShape::ExactDent dent{Vec3(0.002, -0.001, 0.05), Vec3(0.001, 0, -0.004), 0.02, 2};
  DeformedShape shape = DeformedShape::plane(0.05);
  shape.dent(dent);
  const Vec3 material(0.009, 0.004, 0.05);
  const Vec3 away = material - dent.centre;
  const double part = 1 - glm::dot(away, away) / (dent.radius_m * dent.radius_m);
  const Vec3 gradient = away * (-4 * part / (dent.radius_m * dent.radius_m));
  const glm::dmat3 jacobian = glm::dmat3(1) + glm::outerProduct(dent.displacement, gradient);
  const Vec3 normal = glm::normalize(glm::transpose(glm::inverse(jacobian)) * Vec3(0, 0, 1));
  EXPECT_LT(glm::distance(shape.at(material).normal, normal), 1e-7);
}

TEST(DeformedShape, IsWhereAnAffineLatticeTakesIt) {
  const glm::dmat3 matrix(1.1, 0.05, 0, -0.1, 0.9, 0.02, 0.03, 0.07, 1.05);
  Lattice lattice{.low_m = Vec3(-0.06), .size_m = Vec3(0.12), .points = {3, 3, 3}, .control_m = {}};
  for (int z = 0; z < 3; ++z) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 3; ++x) lattice.control_m.emplace_back(matrix * (Vec3(x, y, z) * 0.06 - Vec3(0.06)));
    }
  }
  DeformedShape shape = DeformedShape::plane(0.05);
  shape.shapeBy(lattice);
  const Vec3 material(0.02, -0.03, 0.05);
  EXPECT_LT(glm::distance(shape.now(material), matrix * material), 1e-8) << "control points are floats";
  const auto found = shape.nearest(matrix * material - shape.at(material).normal * 0.003, Vec3(0, 0, 0.05));
  EXPECT_LT(glm::distance(found.material, material), 1e-8);
  // Of a height that goes up along x on the material.
  const Vec3 gradient = found.gradient(Vec3(1, 0, 0));
  EXPECT_NEAR(glm::dot(gradient, matrix * Vec3(1, 0, 0)), 1, 1e-6);
  EXPECT_NEAR(glm::dot(gradient, matrix * Vec3(0, 1, 0)), 0, 1e-6);
}

}  // namespace
}  // namespace haptics::eval::deformed_shape_test
