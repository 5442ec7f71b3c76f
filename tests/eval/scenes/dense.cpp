// A scene that is dense, of long triangles without number: S21.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kRoom_m = 0.05;  ///< Half of the cube in which everything is.

/// A path over triangles, tick by tick. Between two ticks it may have gone anywhere in a ball; a crossing is certain where
/// the way from one side of a triangle to the other leads through a part of it from which the ball does not reach the rim.
class CrossingWatch {
 public:
  explicit CrossingWatch(const shapes::Shape& shape) {
    for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
      Face face;
      for (std::size_t k = 0; k < 3; ++k) face.corner[k] = shape.corner(t, k);
      const Vec3 normal = glm::cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
      if (!(glm::length(normal) > 0)) continue;
      face.normal = glm::normalize(normal);
      faces_.push_back(face);
    }
  }

  /// @param reach_m  No place that the path came by since the last call is farther from either end.
  /// @return Triangles that were crossed for certain.
  int follow(Vec3 place, double reach_m) {
    constexpr double kCertain_m = 2e-6;
    int crossed = 0;
    for (Face& face : faces_) {
      face.reach_m += reach_m;
      const double height = glm::dot(face.normal, place - face.corner[0]);
      if (std::abs(height) < kCertain_m) continue;
      if (face.known && (height > 0) != (face.height > 0)) {
        const Vec3 at = glm::mix(face.place, place, face.height / (face.height - height));
        crossed += rim_m(face, at) > 2 * face.reach_m ? 1 : 0;
      }
      face.known = true;
      face.place = place;
      face.height = height;
      face.reach_m = 0;
    }
    return crossed;
  }

 private:
  struct Face {
    std::array<Vec3, 3> corner;
    Vec3 normal{0};
    bool known = false;  // on a side for certain, there:
    Vec3 place{0};
    double height = 0;
    double reach_m = 0;  // since then
  };
  /// How far within a triangle a point of its plane is; negative outside.
  static double rim_m(const Face& face, Vec3 at) {
    double rim = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 side = face.corner[(k + 1) % 3] - face.corner[k];
      const Vec3 inward = glm::normalize(glm::cross(face.normal, side));
      rim = std::min(rim, glm::dot(inward, at - face.corner[k]));
    }
    return rim;
  }

  std::vector<Face> faces_;
};

/// Long triangles anywhere, and walls that part the room into eight: nothing leads round a wall.
shapes::Shape soupWithWalls(Random& random) {
  constexpr int kTriangles = 1000;
  shapes::Shape soup;
  const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vec3 v : {a, b, c}) soup.vertices.emplace_back(v);
    soup.triangles.push_back({first, first + 1, first + 2});
  };
  const auto somewhere = [&] {
    return kRoom_m * Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  };
  for (int i = 0; i < kTriangles; ++i) add(somewhere(), somewhere(), somewhere());
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 u(0), v(0);
    u[(axis + 1) % 3] = v[(axis + 2) % 3] = 20 * kRoom_m;
    add(-u - v, u - v, u + v);
    add(-u - v, u + v, v - u);
  }
  return soup;
}

struct DenseCounts {
  int crossed = 0;
  int otherRoom = 0;
  int notFinite = 0;
  int touching = 0;
};

/// At one speed for half a second: presses, strokes and crosses, and comes back where it is too far from the IHIP.
void exploreSoup(Renderer& method, const shapes::Shape& soup, const std::shared_ptr<const Surface>& surface,
                 double speed_m_per_s, Random& random, DenseCounts& counts) {
  constexpr int kTicks = 500;
  constexpr double kDeepest_m = 0.004;
  Stage stage(method, {});
  stage.add(surface);
  CrossingWatch watch(soup);
  Vec3 hip = kRoom_m * Vec3(1.3, 1.2, 1.4);
  const Vec3 sides = hip;
  stage.begin(hip);
  watch.follow(hip, 0);
  Vec3 ihip = hip;
  Vec3 target(0);
  for (int i = 0, left = 0; i < kTicks; ++i, --left) {
    if (left == 0) {
      target = 0.9 * kRoom_m * Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
      left = 20 + random.below(100);
    }
    const Vec3 way = target - hip;
    const double far_m = glm::length(way);
    const double step_m = std::min(speed_m_per_s * kPeriod_s, far_m);
    Vec3 next = far_m > 0 ? hip + way * (step_m / far_m) : hip;
    if (glm::distance(next, ihip) > kDeepest_m + step_m) next += 0.2 * (ihip - next);
    const Felt felt = stage.tick(next);
    const bool finite = isFinite(felt.ihip) && isFinite(felt.force_N);
    counts.notFinite += finite ? 0 : 1;
    counts.touching += felt.touching ? 1 : 0;
    const Vec3 place = felt.ihip;
    const double reach_m = glm::distance(ihip, hip) + 2 * glm::distance(hip, next) + glm::distance(place, next);
    counts.crossed += watch.follow(place, reach_m);
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kOnWall_m = 1e-6;
      counts.otherRoom += place[axis] * (sides[axis] > 0 ? 1 : -1) < -kOnWall_m ? 1 : 0;
    }
    ihip = place;
    hip = next;
  }
}

}  // namespace

SceneResult exploreSoups(Renderer& method, Random& random) {
  DenseCounts counts;
  const shapes::Shape soup = soupWithWalls(random);
  const auto surface = soup.build();
  for (const double speed_m_per_s : {0.1, 0.4, 1.0, 5.0}) {
    exploreSoup(method, soup, surface, speed_m_per_s, random, counts);
  }
  SceneResult result;
  result.measures = {{"crossed", counts.crossed},
                     {"other_room_ticks", counts.otherRoom},
                     {"non_finite_ticks", counts.notFinite},
                     {"contact_ticks", counts.touching}};
  result.pass = counts.crossed == 0 && counts.otherRoom == 0 && counts.notFinite == 0 && counts.touching > 500;
  return result;
}

}  // namespace haptics::eval
