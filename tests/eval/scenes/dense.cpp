// Scenes that are dense: long triangles without number (S21), objects without number in one place (S22).

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/surface/make_field.h"
#include "tests/eval/or_throw.h"
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
  int inside = 0;
  int notFinite = 0;
  int touching = 0;
};

/// A hand that makes for one place of the room after another at one speed, and comes back where it is too far from the IHIP.
class DenseHand {
 public:
  DenseHand(Vec3 hip, double speed_m_per_s, Random& random)
      : random_(random), hip_(hip), step_m_(speed_m_per_s * kPeriod_s) {}

  [[nodiscard]] Vec3 hip() const { return hip_; }

  Vec3 next(Vec3 ihip) {
    constexpr double kDeepest_m = 0.004;
    if (left_-- == 0) {
      target_ = 0.9 * kRoom_m * Vec3(random_.between(-1, 1), random_.between(-1, 1), random_.between(-1, 1));
      left_ = 19 + random_.below(100);
    }
    const Vec3 way = target_ - hip_;
    const double far_m = glm::length(way);
    const double step_m = std::min(step_m_, far_m);
    if (far_m > 0) hip_ += way * (step_m / far_m);
    if (glm::distance(hip_, ihip) > kDeepest_m + step_m) hip_ += 0.2 * (ihip - hip_);
    return hip_;
  }

 private:
  Random& random_;
  Vec3 hip_;
  double step_m_;
  Vec3 target_{0};
  int left_ = 0;
};

/// At one speed for half a second: presses, strokes and crosses.
void exploreSoup(Renderer& method, const shapes::Shape& soup, const std::shared_ptr<const CollisionMesh>& surface,
                 double speed_m_per_s, Random& random, DenseCounts& counts) {
  constexpr int kTicks = 500;
  Stage stage(method, {});
  stage.add(surface);
  CrossingWatch watch(soup);
  const Vec3 start = kRoom_m * Vec3(1.3, 1.2, 1.4);
  const Vec3 sides = start;
  stage.begin(start);
  watch.follow(start, 0);
  Vec3 ihip = start;
  DenseHand hand(start, speed_m_per_s, random);
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip = hand.hip();
    const Vec3 next = hand.next(ihip);
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
  }
}

/// Boxes that overlap, without number. What is inside of them is told by their sides alone.
class BoxHeap {
 public:
  explicit BoxHeap(Random& random) {
    constexpr int kBoxCount = 256;
    const auto somewhere = [&](double far) {
      return far * Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    };
    for (int i = 0; i < kBoxCount; ++i) {
      const Vec3 size(random.between(0.004, 0.03), random.between(0.004, 0.03), random.between(0.004, 0.03));
      const Pose pose{random.rotation(), somewhere(0.8 * kRoom_m)};
      const shapes::Shape box = shapes::box(size);
      boxes_.push_back({0.5 * size, pose, box.build()});
      for (std::size_t t = 0; t < box.triangles.size(); ++t) {
        const auto first = static_cast<std::uint32_t>(faces_.vertices.size());
        for (std::size_t k = 0; k < 3; ++k) faces_.vertices.emplace_back(toWorld(pose, box.corner(t, k)));
        faces_.triangles.push_back({first, first + 1, first + 2});
      }
    }
  }

  void addTo(Stage& stage) const {
    for (const Box& box : boxes_) stage.add(box.surface, box.pose);
  }
  [[nodiscard]] const shapes::Shape& faces() const { return faces_; }

  /// @return How deep a place is in the box in which it is the deepest, m; 0 outside of all.
  [[nodiscard]] double depthOf(Vec3 place) const {
    double depth = 0;
    for (const Box& box : boxes_) {
      const Vec3 within = box.half - glm::abs(toLocal(box.pose, place));
      depth = std::max(depth, std::min({within.x, within.y, within.z}));
    }
    return depth;
  }

 private:
  struct Box {
    Vec3 half;
    Pose pose;
    std::shared_ptr<const CollisionMesh> surface;
  };
  std::vector<Box> boxes_;
  shapes::Shape faces_;
};

/// Of every box. The bumps can be felt so far from it.
constexpr double kBumps_m = 1e-4;

FeltSurface everyFeature(Random& random) {
  FourierFamily waves;
  for (int i = 0; i < 8; ++i) {
    waves.terms.push_back({1.0 / 8, random.direction(), random.between(0.002, 0.02), random.between(0, 6)});
  }
  FeltSurface surface;
  surface.device.maxForce_N = 1e9;
  surface.properties.shading = Shading{.crease_rad = std::numbers::pi / 3, .creases = {}};
  surface.properties.texture = Texture{.family = waves, .amplitude_m = kBumps_m / 2};
  surface.properties.friction = Friction{.mu_static = 0.5, .mu_dynamic = 0.3};
  surface.texture = orThrow(makeField(surface.properties.texture->family, [](const ContentHash&) { return nullptr; }));
  return surface;
}

/// Rigid boxes.
void exploreHeap(Renderer& method, const BoxHeap& heap, double speed_m_per_s, Random& random, DenseCounts& counts) {
  constexpr int kTicks = 300;
  Stage stage(method, {});
  heap.addTo(stage);
  CrossingWatch watch(heap.faces());
  const Vec3 start = kRoom_m * Vec3(0.2, 0.1, 1.4);
  stage.begin(start);
  watch.follow(start, 0);
  Vec3 ihip = start;
  double reach_m = 0;
  DenseHand hand(start, speed_m_per_s, random);
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip = hand.hip();
    const Vec3 next = hand.next(ihip);
    const Felt felt = stage.tick(next);
    counts.notFinite += isFinite(felt.ihip) && isFinite(felt.force_N) ? 0 : 1;
    counts.touching += felt.touching ? 1 : 0;
    reach_m += glm::distance(ihip, hip) + 2 * glm::distance(hip, next) + glm::distance(felt.ihip, next);
    ihip = felt.ihip;
    // A bump alone may be what is felt of a box that is not touched: then this is the nearest place of that box.
    if (glm::distance(ihip, next) <= 1.1 * kBumps_m && heap.depthOf(next) == 0) continue;
    counts.inside += heap.depthOf(ihip) > kInside_m ? 1 : 0;
    counts.crossed += watch.follow(ihip, reach_m);
    reach_m = 0;
  }
}

/// Boxes that yield: the IHIP is in their dents.
void exploreSoftHeap(Renderer& method, const BoxHeap& heap, Random& random, DenseCounts& counts) {
  constexpr int kTicks = 300;
  constexpr double kSpeed_m_per_s = 0.2;
  Stage stage(method, {});
  heap.addTo(stage);
  const Vec3 start = kRoom_m * Vec3(0.2, 0.1, 1.4);
  stage.begin(start);
  Vec3 ihip = start;
  DenseHand hand(start, kSpeed_m_per_s, random);
  for (int i = 0; i < kTicks; ++i) {
    const Felt felt = stage.tick(hand.next(ihip));
    counts.notFinite += isFinite(felt.ihip) && isFinite(felt.force_N) ? 0 : 1;
    counts.touching += felt.touching ? 1 : 0;
    ihip = felt.ihip;
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

SceneResult exploreHeaps(Renderer& method, Random& random) {
  DenseCounts counts;
  const BoxHeap heap(random);
  FeltSurface surface = everyFeature(random);
  method.setSurfaceProperties(surface);
  for (const double speed_m_per_s : {0.1, 0.4, 1.0}) exploreHeap(method, heap, speed_m_per_s, random, counts);
  surface.tissue = SoftTissue{Falloff(0.01, 3), 300, 0.1, 0.3};
  method.setSurfaceProperties(surface);
  exploreSoftHeap(method, heap, random, counts);
  SceneResult result;
  result.measures = {{"crossed", counts.crossed},
                     {"inside_ticks", counts.inside},
                     {"non_finite_ticks", counts.notFinite},
                     {"contact_ticks", counts.touching}};
  result.pass = counts.crossed == 0 && counts.inside == 0 && counts.notFinite == 0 && counts.touching > 300;
  return result;
}

}  // namespace haptics::eval
