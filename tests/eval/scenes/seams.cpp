// Seams and cracks thinner than the skin, at rest and moving: S33 to S35, P1, P2.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/mesh/import.h"
#include "tests/eval/floors.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"
#include "tests/eval/winding.h"

namespace haptics::eval {
namespace {

/// Off the exact place by more than this, of the floor's scale (m), is wrong: the planes' skins lift an IHIP that several
/// surfaces hold by a part of it.
constexpr double kOffPlace = 1e-6;

struct Wrong {
  int ticks = 0;
  int wrong = 0;
  double aside = 0;   ///< Of the scale.
  double height = 0;  ///< Likewise.

  void see(const Felt& felt, Vec3 place, Vec3 hip, double scale) {
    const Vec3 off = (place - Vec3(hip.x, hip.y, std::max(hip.z, 0.0))) / scale;
    ++ticks;
    aside = std::max(aside, std::hypot(off.x, off.y));
    height = std::max(height, std::abs(off.z));
    // At the plane itself it may be held or not.
    const bool held = felt.touching == (hip.z < 0) || std::abs(hip.z) < kOffPlace * scale;
    wrong += held && isFinite(off) && glm::length(off) < kOffPlace ? 0 : 1;
  }
};

/// A hand that presses beside a seam, on it, or right into it, and goes over the floor in straight lines.
class Strokes {
 public:
  Strokes(const Floor& floor, Random& random) : floor_(floor), random_(random) {}

  /// Calls go(to, step) for each line, with place(from) before the first.
  template <class PlaceAt, class Go>
  void run(int lines, PlaceAt placeAt, Go go) {
    depth_ = random_.between(0.0003, 0.004) * floor_.scale;
    Vec3 at = somewhere();
    at.z = 0.002 * floor_.scale;
    placeAt(at);
    at.z = -depth_;
    go(at, step());
    for (int i = 0; i < lines; ++i) {
      Vec3 to = somewhere();
      if (random_.below(4) == 0) to.x = at.x;  // along a seam, where it is one
      go(to, step());
      at = to;
    }
    at.z = 0.002 * floor_.scale;
    go(at, step());
  }

 private:
  [[nodiscard]] double step() {
    return 0.00002 * std::pow(50, random_.between(0, 1)) * floor_.scale;  // 0.02 to 1 m/s of 0.1 m
  }
  /// On a seam by the sizes, within the vertices' rounding of it, or anywhere. Not where the rim is as near as the top.
  [[nodiscard]] Vec3 somewhere() {
    const double rim = 1.5 * depth_ + 0.0005 * floor_.scale;
    Vec3 place(random_.between(floor_.low.x + rim, floor_.high.x - rim),
               random_.between(floor_.low.y + rim, floor_.high.y - rim), -depth_);
    const int draw = random_.below(3);
    if (draw < 2)
      place.x = floor_.seams[static_cast<std::size_t>(random_.below(static_cast<int>(floor_.seams.size())))];
    if (draw == 1) place.x += random_.between(-1, 1) * 0x1p-25 * 0.1 * floor_.scale;
    return place;
  }

  const Floor& floor_;
  Random& random_;
  double depth_ = 0;
};

/// Its tolerances go by its largest coordinate.
Pose someFrame(const Floor& floor, Random& random) {
  return {random.rotation(), random.direction() * (random.between(0, 0.1) * floor.scale)};
}

void strokeFloor(Renderer& method, const Floor& floor, Random& random, Wrong& wrong) {
  Stage stage(method, someFrame(floor, random));
  for (const Tile& tile : floor.tiles) stage.add(tile.shape.build(), tile.pose);
  Strokes strokes(floor, random);
  Vec3 hip;
  bool begun = false;
  const auto placeAt = [&](Vec3 at) {
    if (!std::exchange(begun, true)) stage.begin(at);
    stage.place(at);
    hip = at;
  };
  const auto go = [&](Vec3 to, double step) {
    stage.lead(hip, to, step, [&](const Felt& felt, Vec3 at) { wrong.see(felt, felt.ihip, at, floor.scale); });
    hip = to;
  };
  for (int i = 0; i < 3; ++i) strokes.run(5, placeAt, go);
}

/// All of a floor goes to and fro and turns, as one.
struct Sway {
  Vec3 way;
  double rate;  ///< rad a tick
  Vec3 axis;
  double angle;
  double turnRate;  ///< rad a tick

  Sway(Random& random, double scale)
      : way(random.direction() * (random.between(0, 0.05) * scale)),
        rate(random.between(0.001, 0.02)),
        axis(random.direction()),
        angle(random.below(3) == 0 ? 0 : random.between(0, 1)),
        turnRate(random.between(0.001, 0.01)) {}
  [[nodiscard]] Pose at(int tick) const {
    return {glm::angleAxis(angle * std::sin(turnRate * tick), axis), way * std::sin(rate * tick)};
  }
};

/// The same on a floor that moves: the place is judged in the floor's frame.
void strokeMovingFloor(Renderer& method, const Floor& floor, Random& random, Wrong& wrong) {
  Stage stage(method, someFrame(floor, random));
  for (const Tile& tile : floor.tiles) stage.add(tile.shape.build(), tile.pose);
  const Sway sway(random, floor.scale);
  Strokes strokes(floor, random);
  int tick = 0;
  Vec3 hip;
  const auto moveAll = [&] {
    const Pose now = sway.at(tick);
    for (std::size_t i = 0; i < floor.tiles.size(); ++i) {
      const Pose& own = floor.tiles[i].pose;
      stage.move(static_cast<int>(i), {now.rotation * own.rotation, toWorld(now, own.position)});
    }
    return now;
  };
  bool begun = false;
  const auto placeAt = [&](Vec3 at) {
    const Pose now = sway.at(tick);
    if (!std::exchange(begun, true)) stage.begin(toWorld(now, at));
    stage.place(toWorld(now, at));
    hip = at;
  };
  const auto go = [&](Vec3 to, double step) {
    const int ticks = static_cast<int>(std::ceil(glm::distance(hip, to) / step));
    for (int i = 1; i <= ticks; ++i) {
      ++tick;
      const Pose now = moveAll();
      const Vec3 at = glm::mix(hip, to, static_cast<double>(i) / ticks);
      const Felt felt = stage.tick(toWorld(now, at));
      wrong.see(felt, toLocal(now, felt.ihip), at, floor.scale);
    }
    hip = to;
  };
  for (int i = 0; i < 3; ++i) strokes.run(5, placeAt, go);
}

/// Of 48 by 24 squares; the last meridian is computed at 2 pi, so that its y is the first one's but for sin(2 pi).
TriMesh meridianSphere(double radius_m) {
  constexpr int kAround = 48, kDown = 24;
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
  const auto place = [&](int u, int v) {
    const double a = 2 * std::numbers::pi * u / kAround, b = std::numbers::pi * v / kDown;
    return radius_m * Vec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
  };
  const auto triangle = [&](Vec3 a, Vec3 b, Vec3 c) {
    const auto k = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), {a, b, c});
    triangles.push_back({k, k + 1, k + 2});
  };
  for (int u = 0; u < kAround; ++u) {
    for (int v = 0; v < kDown; ++v) {
      const Vec3 a = place(u, v), b = place(u + 1, v), c = place(u + 1, v + 1), d = place(u, v + 1);
      if (v > 0) triangle(a, d, b);
      if (v < kDown - 1) triangle(b, d, c);
    }
  }
  return canonicalise(vertices, triangles, {})->mesh;
}

/// Pressed on the last meridian and the poles and led over them: the IHIP is on the sphere's facets wherever the hand is
/// inside, and the force points away from the middle, to within what facets turn it.
void strokeMeridian(Renderer& method, Random& random, Wrong& wrong) {
  constexpr double kRadius_m = 0.03, kStep_m = 1e-4;
  constexpr double kFacet = 0.98;  // cosine of 11 degrees; facets are 7.5 wide and high
  const TriMesh ball = meridianSphere(kRadius_m);
  const WindingMesh exact(ball.vertices, ball.triangles);
  Stage stage(method, random);
  stage.add(buildCollisionMesh(ball.vertices, ball.triangles));
  const Vec3 far(0.05, 0, 0.001);
  stage.begin(far);
  const auto check = [&](const Felt& felt, Vec3 hip) {
    ++wrong.ticks;
    const bool isIn = exact.depthInside(hip) > kOffPlace;
    const double off_m = felt.touching ? exact.distanceTo(felt.ihip) : 0;
    wrong.height = std::max(wrong.height, off_m);
    const bool isRight = felt.touching && off_m < kOffPlace &&
                         glm::dot(felt.force_N, hip) > kFacet * glm::length(felt.force_N) * glm::length(hip);
    wrong.wrong += isIn && !isRight ? 1 : 0;
    wrong.wrong += !felt.touching && felt.force_N != Vec3(0) ? 1 : 0;
  };
  const double depth_m = random.between(0.001, 0.006);
  const auto below = [&](Vec3 direction) { return glm::normalize(direction) * (kRadius_m - depth_m); };
  Vec3 at = far;
  const auto go = [&](Vec3 to) {
    stage.lead(at, to, kStep_m, check);
    at = to;
  };
  go(below({1, 0, 0.05}));
  for (int i = 0; i < 6; ++i) go(below({1, random.between(-0.3, 0.3), random.between(-1, 1)}));
  go(below({1, 0, 0.5}));
  go(below({1, 0, -0.5}));  // along it
  go(far);
  go(Vec3(0.05, 0, 0.05));
  for (const double pole : {1.0, -1.0}) {
    const Vec3 above(0, 0, 0.05 * pole);
    stage.place(above);
    at = above;
    go(below({0, 0, pole}));
    for (int i = 0; i < 4; ++i) go(below({random.between(-0.2, 0.2), random.between(-0.2, 0.2), pole}));
    go(above);
  }
}

SceneResult resultOf(const Wrong& wrong) {
  return {{{"ticks", wrong.ticks},
           {"wrong_ticks", wrong.wrong},
           {"aside_max_um_of_0.1_m", 1e6 * wrong.aside},
           {"height_error_max_um_of_0.1_m", 1e6 * wrong.height}},
          wrong.wrong == 0};
}

constexpr int kFloors = 6, kFlushFloors = 10;

double someScale(Random& random) { return std::pow(10.0, random.below(5) - 2); }

}  // namespace

SceneResult strokeFlushBoxes(Renderer& method, Random& random) {
  Wrong wrong;
  for (int i = 0; i < kFlushFloors; ++i) strokeFloor(method, flushBoxes(someScale(random), random), random, wrong);
  return resultOf(wrong);
}

SceneResult strokeCrackedMeshes(Renderer& method, Random& random) {
  Wrong wrong;
  for (int i = 0; i < kFloors; ++i) strokeFloor(method, crackedMesh(someScale(random), random), random, wrong);
  return resultOf(wrong);
}

SceneResult strokeMovingSeams(Renderer& method, Random& random) {
  Wrong wrong;
  for (int i = 0; i < kFloors; ++i)
    strokeMovingFloor(method,
                      i % 2 == 0 ? flushBoxes(someScale(random), random) : crackedMesh(someScale(random), random),
                      random, wrong);
  return resultOf(wrong);
}

SceneResult strokeTilesAsReported(Renderer& method, Random& random) {
  Wrong wrong;
  for (const double gap_m : {0.0, 1e-9, 1e-8, 1e-7, -1e-9, -1e-6})
    strokeFloor(method, fiveBoxes(1.0 / 64, gap_m), random, wrong);
  strokeFloor(method, fiveBoxes(0.02, 0), random, wrong);
  return resultOf(wrong);
}

SceneResult strokeCracksAsReported(Renderer& method, Random& random) {
  Wrong wrong;
  for (const double gap_m : {0.0, 1e-9, 1e-8, 5e-8}) {
    for (const bool closed : {true, false}) strokeFloor(method, patchedBlock(gap_m, closed), random, wrong);
  }
  strokeMeridian(method, random, wrong);
  return resultOf(wrong);
}

}  // namespace haptics::eval
