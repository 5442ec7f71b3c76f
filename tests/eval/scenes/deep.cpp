// Limits of the search and of the crossing test: S5, S6, S7.

#include <algorithm>
#include <array>

#include "haptic_server/engine/contact/neighborhood_watch.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

/// The search's budget, and at most one triangle for each step of the motion after it is spent.
constexpr int kMaxTriangles = kSearchBudget + 48;
constexpr std::array kValences{8, 64, 700, 4096};

/// A place on the mesh where a test may fail: a vertex, or a point of an edge or of a diagonal.
Vec3 delicatePlace(const shapes::Shape& shape, Random& random) {
  const auto t = static_cast<std::size_t>(random.below(static_cast<int>(shape.triangles.size())));
  const auto k = static_cast<std::size_t>(random.below(3));
  const Vec3 a = shape.corner(t, k);
  if (random.below(2) == 0) return a;
  const Vec3 b = shape.corner(t, (k + 1) % 3);
  return random.below(2) == 0 ? (a + b) * 0.5 : glm::mix(a, b, random.between(0, 1));
}

}  // namespace

SceneResult aimAtVerticesAndEdges(Renderer& method, Random& random) {
  constexpr int kSegments = 100'000;
  constexpr double kMaxTilt_rad = 0.5;  // against the radius: within, the far end is inside of either shape
  int leaks = 0;
  for (const shapes::Shape& upright : {shapes::sphere(0.05, 6), shapes::box(Vec3(0.08), 4)}) {
    const Quat rotation = random.rotation();
    const shapes::Shape shape = upright.mapped([&](Vec3 v) { return rotation * v; });
    Stage stage(method, Pose{});
    stage.add(shape);
    stage.begin(Vec3(0, 0, 0.2));
    for (int i = 0; i < kSegments / 2; ++i) {
      const Vec3 place = delicatePlace(shape, random);
      const Quat tilt = glm::angleAxis(random.between(0, kMaxTilt_rad), random.direction());
      const Vec3 out = tilt * glm::normalize(place) * random.between(0.0001, 0.002);
      stage.place(place + out);
      leaks += stage.tick(place - out).touching ? 0 : 1;
    }
  }
  return {{{"segments", kSegments}, {"leaks", leaks}}, leaks == 0};
}

/// Strokes under the bottom of a pit, the nearest place of all to a HIP that passes there, whose polygons must then all be
/// looked at.
struct PitStrokes {
  int most = 0;  // triangles in a tick
  int lost = 0;
  int ticks = 0;

  PitStrokes(Renderer& method, Random& random, const std::shared_ptr<const CollisionMesh>& pit) {
    constexpr int kSteps = 12;
    Stage stage(method, random);
    stage.add(pit);
    const Quat turn = glm::angleAxis(random.between(0, 6), Vec3(0, 0, 1));
    const auto at = [&](double x, double z) { return turn * Vec3(x, 1e-4, z); };
    stage.begin(at(-0.01, 0));
    stage.tick(at(-0.01, -0.006));
    for (int i = -kSteps; i <= kSteps; ++i) {
      const double x = 0.01 * i / kSteps;
      const Felt felt = stage.tick(at(x, -0.0105 + 0.45 * std::abs(x)));
      lost += felt.touching ? 0 : 1;
      most = std::max(most, felt.triangles);
    }
    ticks = stage.ticks();
  }
};

/// Stroked around the apex; then the HIP stands still, and the IHIP has to arrive.
SceneResult strokeFans(Renderer& method, Random& random) {
  constexpr double kMaxStall = 0.05;  // of the depth: the side that holds need not be the nearest one
  int most = 0;
  int lost = 0;
  int ticks = 0;
  double stall = 0;
  static const auto fans = [] {  // the same for every method
    std::vector<std::shared_ptr<const CollisionMesh>> built;
    for (const int valence : kValences) built.push_back(shapes::cone(0.05, 0.02, valence).build());
    return built;
  }();
  static const auto pits = [] {
    std::vector<std::shared_ptr<const CollisionMesh>> built;
    for (const int valence : kValences) {
      built.push_back(shapes::cone(0.02, 1, valence)
                          .mapped([](Vec3 v) {
                            const bool rim = v.x != 0 || v.y != 0;
                            return rim ? v : Vec3(0, 0, v.z > 0 ? -0.01 : -0.04);
                          })
                          .build());
    }
    return built;
  }();
  for (const auto& fan : fans) {
    Stage stage(method, random);
    const int cone = stage.add(fan);
    stage.begin({0, 0, 0.021});
    stage.tick({0.0001, 0, 0.015});
    const double start = random.between(0, 6);
    const double turn = random.between(0.02, 0.08) * random.sign();
    for (int i = 0; i < 400; ++i) {
      const double angle = start + turn * i;
      const double radius = 0.006 * std::sin(0.02 * i);
      const Felt felt = stage.tick({radius * std::cos(angle), radius * std::sin(angle), 0.012});
      lost += felt.touching ? 0 : 1;
      most = std::max(most, felt.triangles);
    }
    const Vec3 rest{0.005 * std::cos(start), 0.005 * std::sin(start), 0.012};
    Felt felt;
    for (int i = 0; i < 20; ++i) felt = stage.tick(rest);
    const double depth = stage.depthIn(cone, rest);
    stall = std::max(stall, std::abs(glm::distance(felt.ihip, rest) - depth) / depth);
    ticks += stage.ticks();
  }
  for (const auto& pit : pits) {
    const PitStrokes strokes(method, random, pit);
    most = std::max(most, strokes.most);
    lost += strokes.lost;
    ticks += strokes.ticks;
  }
  return {{{"ticks", ticks}, {"triangles_per_tick_max", most}, {"stall_of_depth_ratio", stall}, {"lost_ticks", lost}},
          most <= kMaxTriangles && stall <= kMaxStall && lost == 0};
}

/// Part of the ticks in which a fast hand under hills and valleys has its IHIP elsewhere than a slow hand on the same
/// straight way, 64 ticks for one. Strokes begin anew, so that one that is lost does not count for the next.
double notWhereASlowHandIs(Renderer& method, Random& random) {
  constexpr double kRadius = 0.05;
  constexpr double kSpeed_m_per_s = 5;
  constexpr double kElsewhere = 1e-4;  // metres, a tenth of an edge
  constexpr int kStrokes = 400;
  constexpr int kTicks = 8;
  static const auto hills =
      shapes::sphere(1, 64)  // the same for every method
          .mapped([](Vec3 v) {
            return v * kRadius * (1 + 0.06 * std::sin(20 * v.x) * std::sin(19 * v.y + 1) * std::cos(18 * v.z));
          })
          .build();
  Stage stage(method, Pose{});
  stage.add(hills);
  stage.begin(Vec3(0, 0, 2 * kRadius));
  int elsewhere = 0;
  for (int stroke = 0; stroke < kStrokes; ++stroke) {
    const Vec3 over = random.direction() * (1.1 * kRadius);
    const Vec3 way = glm::normalize(glm::cross(over, random.direction())) * (kSpeed_m_per_s * kPeriod_s);
    std::array<Vec3, kTicks> slow;
    const auto hip = [&](int tick) {
      return tick == 0 ? over : glm::normalize(over + way * static_cast<double>(tick)) * (0.88 * kRadius);
    };
    stage.place(over);
    for (int i = 1; i <= kTicks; ++i) {
      for (int j = 1; j <= 64; ++j)
        slow[static_cast<std::size_t>(i - 1)] = stage.tick(glm::mix(hip(i - 1), hip(i), j / 64.0)).ihip;
    }
    stage.place(over);
    for (int i = 1; i <= kTicks; ++i) {
      elsewhere += glm::distance(stage.tick(hip(i)).ihip, slow[static_cast<std::size_t>(i - 1)]) > kElsewhere ? 1 : 0;
    }
  }
  return static_cast<double>(elsewhere) / (kStrokes * kTicks);
}

SceneResult runDeepAndFast(Renderer& method, Random& random) {
  constexpr double kRadius = 0.05;
  constexpr double kDepth = 0.04;
  constexpr double kSpeed_m_per_s = 5;
  constexpr double kMaxLag = 0.1 * kDepth;
  constexpr double kMaxElsewhere = 0.03;
  int lost = 0;
  int most = 0;
  Stage stage(method, random);
  static const auto ball = shapes::sphere(kRadius, 128).build();  // the same for every method
  stage.add(ball);
  const Quat plane = random.rotation();
  const auto at = [&](double angle, double radius) {
    return plane * Vec3(std::sin(angle), 0, std::cos(angle)) * radius;
  };
  double lag = 0;
  const auto check = [&](const Felt& felt, Vec3 hip) {
    lost += felt.touching ? 0 : 1;
    most = std::max(most, felt.triangles);
    lag = std::max(lag, glm::distance(felt.ihip, hip) - kDepth);
  };
  stage.begin(at(0, kRadius + 0.001));
  stage.lead(at(0, kRadius + 0.001), at(0, kRadius - kDepth), kSpeed_m_per_s * kPeriod_s, check);
  const double turn = kSpeed_m_per_s * kPeriod_s / (kRadius - kDepth);
  for (int i = 1; i <= 500; ++i) {
    const Vec3 hip = at(turn * i, kRadius - kDepth);
    check(stage.tick(hip), hip);
  }
  const double elsewhere = notWhereASlowHandIs(method, random);
  return {{{"ticks", stage.ticks()},
           {"lost_ticks", lost},
           {"lag_beyond_penetration_mm", lag * 1e3},
           {"not_where_a_slow_hand_is_ratio", elsewhere},
           {"triangles_per_tick_max", most}},
          lost == 0 && lag <= kMaxLag && elsewhere <= kMaxElsewhere && most <= kMaxTriangles};
}

}  // namespace haptics::eval
