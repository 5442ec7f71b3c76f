// Motion along bodies at rest: S1, S2, S3, S8, S9, S10.

#include <algorithm>

#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {

/// Over an edge and over corners along both diagonals of the top, two triangles to a side and many.
SceneResult slideOffCube(Renderer& method, Random& random) {
  constexpr double kHalf = 0.05;
  constexpr double kDepth = 0.002;
  double ghost_N = 0;
  double lag = 0;
  int lost = 0;
  int ticks = 0;
  for (const int n : {1, 7}) {
    const auto cube = shapes::box(Vec3(2 * kHalf), n).build();
    const double aside = random.between(-0.04, 0.04);
    for (const Vec3 to : {Vec3(0.09, aside, 0), Vec3(aside, -0.09, 0), Vec3(0.09, 0.09, 0), Vec3(-0.09, 0.09, 0)}) {
      Stage stage(method, random);
      stage.add(cube);
      const Vec3 height{0, 0, kHalf - kDepth};
      const Vec3 from = (std::abs(to.x) == std::abs(to.y) ? to * -0.5 : Vec3(to.y, to.x, 0) * 0.3) + height;
      stage.begin(from + Vec3(0, 0, 2 * kDepth));
      stage.tick(from);
      stage.lead(from, to + height, random.between(0.0003, 0.001), [&](const Felt& felt, Vec3 hip) {
        const double out = std::max(std::abs(hip.x), std::abs(hip.y)) - kHalf;
        if (out > kInside_m) ghost_N = std::max(ghost_N, glm::length(felt.force_N));
        if (out > -kInside_m) return;
        lost += felt.touching ? 0 : 1;
        lag = std::max(lag, glm::distance(felt.ihip, hip) - kDepth);
      });
      ticks += stage.ticks();
    }
  }
  return {
      {{"ticks", ticks}, {"ghost_force_N", ghost_N}, {"lag_beyond_penetration_mm", lag * 1e3}, {"lost_ticks", lost}},
      ghost_N == 0 && lag < kInside_m && lost == 0};
}

namespace {

struct FloorAndBox {
  int inside = 0;
  int lost = 0;
  int ticks = 0;
  double minLateral_N = std::numeric_limits<double>::infinity();
  double before_N = 0;
  double alongLag = 0;
};

/// 3 mm under the floor into the box, along its side, and out again. As one mesh, the two pass through each other.
void slideOnFloor(Renderer& method, Random& random, double sunk, bool oneMesh, FloorAndBox& result) {
  constexpr double kDepth = 0.003;
  constexpr double kBeforeBox = 0.014;  // x of no part of the box, however it is turned
  constexpr double kHalfBox = 0.02;
  const Quat yaw = glm::angleAxis(random.between(-0.3, 0.3), Vec3(0, 0, 1));
  const Pose boxPose{yaw, {0.04, 0, kHalfBox - sunk}};
  const shapes::Shape box = shapes::box(Vec3(2 * kHalfBox), 2);
  shapes::Shape floor = shapes::box({0.3, 0.3, 0.1}, 4).mapped([](Vec3 v) { return v - Vec3(0, 0, 0.05); });
  if (oneMesh) floor.add(box.mapped([&](Vec3 v) { return toWorld(boxPose, v); }));
  Stage stage(method, random);
  stage.add(floor);
  if (!oneMesh) stage.add(box.build(), boxPose);

  const Vec3 from{random.between(-0.04, -0.01), random.between(-0.008, 0.008), -kDepth};
  const Vec3 to{0.05, random.between(-0.008, 0.008), -kDepth};
  stage.begin({from.x, from.y, 0.001});
  stage.tick(from);
  double lateral_N = 0;
  const auto check = [&](const Felt& felt, Vec3 hip) {
    result.lost += felt.touching ? 0 : 1;
    const Vec3 inBox = glm::abs(toLocal(boxPose, felt.ihip));
    result.inside += std::max({inBox.x, inBox.y, inBox.z}) < kHalfBox - kInside_m ? 1 : 0;
    const double now_N = std::hypot(felt.force_N.x, felt.force_N.y);
    lateral_N = std::max(lateral_N, now_N);
    if (hip.x < kBeforeBox) result.before_N = std::max(result.before_N, now_N);
  };
  const auto step = [&] { return random.between(0.0003, 0.001); };
  stage.lead(from, to, step(), check);
  const Vec3 inWall = Vec3(0.04, 0, -kDepth) + yaw * Vec3(-0.017, random.between(-0.01, -0.005), 0);
  const Vec3 alongWall = yaw * Vec3(0, random.between(0.012, 0.018), 0);
  stage.lead(to, inWall, step(), check);
  stage.lead(inWall, inWall + alongWall, step(), [&](const Felt& felt, Vec3 hip) {
    check(felt, hip);
    result.alongLag = std::max(result.alongLag, std::abs(glm::dot(felt.ihip - hip, yaw * Vec3(0, 1, 0))));
  });
  stage.lead(inWall + alongWall, from, step(), check);
  result.minLateral_N = std::min(result.minLateral_N, lateral_N);
  result.ticks += stage.ticks();
}

}  // namespace

/// The box just stands on the floor, or has sunk into it a little, or a lot.
SceneResult slideIntoBox(Renderer& method, Random& random) {
  FloorAndBox r;
  for (const double sunk : {0.0, random.between(0.0002, 0.002), 0.01}) slideOnFloor(method, random, sunk, false, r);
  for (const double sunk : {random.between(0.0002, 0.002), 0.01}) slideOnFloor(method, random, sunk, true, r);
  return {{{"ticks", r.ticks},
           {"inside_box_ticks", r.inside},
           {"lateral_force_N", r.minLateral_N},
           {"lateral_force_before_box_N", r.before_N},
           {"lag_along_box_mm", r.alongLag * 1e3},
           {"lost_ticks", r.lost}},
          r.inside == 0 && r.minLateral_N > 1 && r.before_N < kSpring_N_per_m * kInside_m && r.alongLag < kInside_m &&
              r.lost == 0};
}

/// Teeth of 2 mm as one mesh and as a body each, crossed to and fro below their tops.
SceneResult crossComb(Renderer& method, Random& random) {
  constexpr int kTeeth = 7;
  constexpr double kPitch = 0.0025;
  constexpr double kTooth = 0.002;
  int without = 0;
  int inside = 0;
  int ticks = 0;
  for (const bool oneMesh : {true, false}) {
    for (int stroke = 0; stroke < 8; ++stroke) {
      Stage stage(method, random);
      if (oneMesh) stage.add(shapes::comb(kTeeth, kPitch, kTooth, 0.02, 0.02));
      for (int i = 0; i < kTeeth && !oneMesh; ++i) {
        stage.add(shapes::box({kTooth, 0.02, 0.02}, 3), {kPitch * (i - 0.5 * (kTeeth - 1)), 0, 0});
      }
      const double way = random.sign();
      const double z = 0.01 - random.between(0.0002, 0.005);
      const Vec3 from{-way * kPitch * 3 + random.between(-0.0008, 0.0008), random.between(-0.008, 0.008), z};
      const Vec3 to{way * 0.012, random.between(-0.008, 0.008), z};
      stage.begin({from.x, from.y, 0.011});
      const auto check = [&](const Felt& felt, Vec3 hip) {
        if (stage.depthInside(hip) <= kInside_m) return;
        ++inside;
        without += glm::length(felt.force_N) > 0 ? 0 : 1;
      };
      check(stage.tick(from), from);
      for (int i = 0; i < 2; ++i) {
        stage.lead(from, to, 0.001, check);
        stage.lead(to, from, 0.001, check);
      }
      ticks += stage.ticks();
    }
  }
  return {{{"ticks", ticks}, {"inside_ticks", inside}, {"inside_without_force_ticks", without}},
          inside > 50 && without == 0};
}

/// 20 mm under the top: the side gets nearer than the top by far, and still the top holds.
SceneResult approachMedialAxis(Renderer& method, Random& random) {
  double ratio = 0;
  int lost = 0;
  int ticks = 0;
  for (const int n : {1, 6, 12}) {
    Stage stage(method, random);
    stage.add(shapes::box(Vec3(0.1), n));
    const double y = random.between(-0.02, 0.02);
    const Vec3 deep{random.between(0, 0.02), y, 0.03};
    const Vec3 start{deep.x, y, 0.06};
    stage.begin(start);
    stage.lead(start, deep, 0.001, [](const Felt&, Vec3) {});
    Vec3 lastHip = deep;
    Vec3 lastIhip = stage.tick(deep).ihip;
    stage.lead(deep, {0.049, y, 0.03}, random.between(0.0001, 0.0005), [&](const Felt& felt, Vec3 hip) {
      lost += felt.touching ? 0 : 1;
      ratio = std::max(ratio, glm::distance(felt.ihip, lastIhip) / glm::distance(hip, lastHip));
      lastHip = hip;
      lastIhip = felt.ihip;
    });
    ticks += stage.ticks();
  }
  return {{{"ticks", ticks}, {"ihip_step_per_hip_step_max_ratio", ratio}, {"lost_ticks", lost}},
          ratio <= 1.5 && lost == 0};
}

SceneResult pressThinPlates(Renderer& method, Random& random) {
  int popped = 0;
  int ticks = 0;
  for (const double thickness : {0.0005, 0.001}) {
    for (const int n : {1, 9}) {
      Stage stage(method, random);
      stage.add(shapes::box({0.1, 0.1, thickness}, n));
      const double top = thickness / 2;
      const auto check = [&](const Felt& felt, Vec3 hip) {
        if (hip.z > top - kInside_m) return;
        popped += felt.touching && felt.ihip.z > top - kInside_m ? 0 : 1;
      };
      const auto anywhere = [&](double z) {
        return Vec3(random.between(-0.048, 0.048), random.between(-0.048, 0.048), z);
      };
      Vec3 at = anywhere(0.003);
      stage.begin(at);
      for (const Vec3 to : {Vec3(at.x, at.y, top - 0.005), anywhere(top - 0.005), anywhere(top - 0.005)}) {
        stage.lead(at, to, random.between(0.0001, 0.002), check);
        at = to;
      }
      ticks += stage.ticks();
    }
  }
  return {{{"ticks", ticks}, {"pop_through_ticks", popped}}, popped == 0};
}

/// At a constant depth the force should keep its magnitude. Faceting alone changes it by k * step * e / 2R a tick. A
/// tangent plane that is put anew f times a second leaves the sphere by (v/f)^2 / 2R until then and jumps back; the tilt
/// of the facet that it was put on comes on top. What jumps by half as much as a plane at 100 Hz has lost the surface.
SceneResult slideOverSphere(Renderer& method, Random& random) {
  constexpr double kRadius = 0.05;
  constexpr double kSpeed_m_per_s = 0.1;
  const auto planeJump_N = [](double rate_Hz) {
    return kSpring_N_per_m * (kSpeed_m_per_s / rate_Hz) * (kSpeed_m_per_s / rate_Hz) / (2 * kRadius);
  };
  double jump_N = 0;
  int lost = 0;
  Stage stage(method, random);
  static const auto ball = shapes::sphere(kRadius, 64).build();  // the same for every method
  stage.add(ball);
  const double turn = kSpeed_m_per_s * kPeriod_s / kRadius;
  const auto at = [](double angle, double radius) { return Vec3(std::sin(angle), 0, std::cos(angle)) * radius; };
  const double start = random.between(0, 1);
  stage.begin(at(start, kRadius + 0.001));
  stage.lead(at(start, kRadius + 0.001), at(start, kRadius - 0.002), 0.0001, [](const Felt&, Vec3) {});
  double last_N = kSpring_N_per_m * 0.002;
  for (int i = 0; i < 500; ++i) {
    const Felt felt = stage.tick(at(start + turn * i, kRadius - 0.002));
    const double now_N = glm::length(felt.force_N);
    lost += felt.touching ? 0 : 1;
    if (i > 0) jump_N = std::max(jump_N, std::abs(now_N - last_N));
    last_N = now_N;
  }
  return {{{"ticks", stage.ticks()},
           {"force_step_max_N", jump_N},
           {"predicted_plane_step_30Hz_N", planeJump_N(30)},
           {"predicted_plane_step_100Hz_N", planeJump_N(100)},
           {"lost_ticks", lost}},
          jump_N <= 0.5 * planeJump_N(100) && lost == 0};
}

}  // namespace haptics::eval
