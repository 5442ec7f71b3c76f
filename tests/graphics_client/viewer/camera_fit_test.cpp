#include "graphics_client/viewer/camera_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace haptics::camera_fit_test {
namespace {

constexpr double kViewAngle_rad = 0.5, kAspect = 1.25, kSmallest_m = 0.05;
constexpr PictureArea kArea{.left = 0.1, .right = 0.95, .bottom = 0.3, .top = 0.8};

struct Seen {
  double x, y;  ///< Fractions of the picture from the lower left corner.
  double depth;
};

Seen seenFrom(const CameraPlace& place, Vec3 point) {
  const Vec3 ahead = glm::normalize(place.focus - place.position);
  const Vec3 right = glm::normalize(glm::cross(ahead, place.up)), up = glm::cross(right, ahead);
  const Vec3 d = point - place.position;
  const double depth = glm::dot(d, ahead), half = depth * std::tan(kViewAngle_rad / 2);
  return {0.5 + glm::dot(d, right) / (2 * half * kAspect), 0.5 + glm::dot(d, up) / (2 * half), depth};
}

/// How far the points reach beyond the area, in fractions of the picture; negative inside it.
double excess(const CameraPlace& place, std::span<const Vec3> points) {
  double worst = -1;
  for (const Vec3& p : points) {
    const Seen s = seenFrom(place, p);
    worst = std::max({worst, kArea.left - s.x, s.x - kArea.right, kArea.bottom - s.y, s.y - kArea.top});
  }
  return worst;
}

std::vector<Vec3> cloud(Vec3 size) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::vector<Vec3> points;
  constexpr std::size_t kPoints = 200;
  points.reserve(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i)
    points.push_back(Vec3(place(random), place(random), place(random)) * size + Vec3(3, -2, 1));
  return points;
}

TEST(CameraFit, ShowsEveryPointInsideTheAreaAndTouchesItsBorder) {
  for (const Vec3& size : {Vec3(1, 1, 1), Vec3(4, 0.2, 0.1), Vec3(0.1, 0.1, 5), Vec3(0.001, 0.002, 0.003)}) {
    for (const Vec3& direction : {Vec3(0, 1, 0), Vec3(-1, 1, -1), Vec3(0.3, -0.5, 0.4)}) {
      const std::vector<Vec3> points = cloud(size);
      const CameraPlace place = fitCamera(points, glm::normalize(direction), kViewAngle_rad, kAspect, kArea, 1e-6);
      EXPECT_NEAR(excess(place, points), 0, 1e-9);
      for (const Vec3& p : points) EXPECT_GT(seenFrom(place, p).depth, 0);
    }
  }
}

TEST(CameraFit, LooksAlongTheDirectionAtTheMiddleOfTheDepths) {
  const Vec3 direction = glm::normalize(Vec3(-0.4, 1, -0.6));
  const std::vector<Vec3> points = cloud({1, 1, 1});
  const CameraPlace place = fitCamera(points, direction, kViewAngle_rad, kAspect, kArea, kSmallest_m);
  EXPECT_NEAR(glm::dot(glm::normalize(place.focus - place.position), direction), 1, 1e-12);
  const auto [nearest, farthest] = std::ranges::minmax(points, {}, [&](Vec3 p) { return seenFrom(place, p).depth; });
  EXPECT_NEAR(glm::distance(place.position, place.focus),
              (seenFrom(place, nearest).depth + seenFrom(place, farthest).depth) / 2, 1e-9);
}

TEST(CameraFit, KeepsItsDistanceFromASinglePoint) {
  const Vec3 point(1, 2, 3);
  const CameraPlace place = fitCamera({&point, 1}, {0, 1, 0}, kViewAngle_rad, kAspect, kArea, kSmallest_m);
  EXPECT_NEAR(seenFrom(place, point).depth, kSmallest_m, 1e-12);
  EXPECT_LE(excess(place, {&point, 1}), 1e-9);
}

}  // namespace
}  // namespace haptics::camera_fit_test
