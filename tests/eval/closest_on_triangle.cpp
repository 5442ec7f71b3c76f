#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {

Vec3 closestOnTriangle(Vec3 p, const std::array<Vec3, 3>& t) {
  const Vec3 ab = t[1] - t[0];
  const Vec3 ac = t[2] - t[0];
  const double d1 = glm::dot(ab, p - t[0]);
  const double d2 = glm::dot(ac, p - t[0]);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const double d3 = glm::dot(ab, p - t[1]);
  const double d4 = glm::dot(ac, p - t[1]);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + ab * (d1 / (d1 - d3));
  const double d5 = glm::dot(ab, p - t[2]);
  const double d6 = glm::dot(ac, p - t[2]);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return glm::mix(t[1], t[2], (d4 - d3) / ((d4 - d3) + (d5 - d6)));
  return t[0] + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc));
}

}  // namespace haptics::eval
