// Sharp, thin and scaled meshes: S12.

#include <algorithm>

#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

/// A blade, or a gash into a block, of about one degree.
shapes::Shape crease(bool inwards) {
  return shapes::box({0.02, 0.1, 0.1}, 4).mapped([&](Vec3 v) {
    return inwards ? Vec3(v.x, v.y, v.z - 0.06 * std::max(0.0, 1 - std::abs(v.x) / 0.004))
                   : Vec3(v.x * (0.06 - v.z) * 1.6, v.y, v.z);
  });
}

/// A cube with strips of 1 um across the middle of each side.
shapes::Shape slivers() {
  return shapes::cubeGrid(8).mapped([](Vec3 v) {
    const auto squeeze = [](double x) { return std::abs(x) < 0.3 ? x * 4e-5 : x; };
    return Vec3(squeeze(v.x), squeeze(v.y), v.z) * 0.05;
  });
}

int strokeCreases(Renderer& method, Random& random, int& ticks) {
  int wrong = 0;
  for (const bool inwards : {false, true}) {
    Stage stage(method, random);
    stage.add(crease(inwards));
    stage.begin({0, 0, 0.07});
    for (int i = 0; i < 100; ++i) {
      const Vec3 over{random.between(-0.003, 0.003), random.between(-0.04, 0.04), 0.053};
      stage.place(over);
      const Vec3 to{-0.5 * over.x, over.y + random.between(-0.004, 0.004), random.between(0.043, 0.049)};
      stage.lead(over, to, 0.0011,
                 [&](const Felt& felt, Vec3) { wrong += stage.depthInside(felt.ihip) > kInside_m ? 1 : 0; });
    }
    ticks += stage.ticks();
  }
  return wrong;
}

/// A knife along y with its edge at z = 0, up: sides of half the slope each to the plane x = 0.
shapes::Shape knife(double slope) {
  shapes::Shape shape;
  for (const float y : {-0.03F, 0.03F}) {
    const auto half = static_cast<float>(0.025 * slope);
    for (const Vec3f v : {Vec3f(-half, y, -0.05F), Vec3f(half, y, -0.05F), Vec3f(0, y, 0)}) shape.vertices.push_back(v);
  }
  shape.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {0, 2, 5}, {0, 5, 3}};
  return shape;
}

/// Through the knife's side, and up beyond its edge: held, as by any thin plate, until the edge is passed.
int strokeKnife(Renderer& method, Random& random, int& ticks) {
  int wrong = 0;
  Stage stage(method, random);
  const int body = stage.add(knife(0.05));
  stage.begin({0, 0, 0.05});
  const auto check = [&](const Felt& felt, Vec3 hip) {
    const bool ghost = felt.touching && hip.z > 0;
    wrong += ghost || stage.depthIn(body, felt.ihip) > kInside_m ? 1 : 0;
  };
  for (int i = 0; i < 50; ++i) {
    const double way = random.sign();
    const Vec3 from{0.001 * way, random.between(-0.02, 0.02), random.between(-0.004, -0.001)};
    const Vec3 through{random.between(-0.001, -0.0002) * way, from.y + random.between(-0.005, 0.005), from.z};
    stage.place(from);
    stage.lead(from, through, random.between(0.0001, 0.0004), check);
    // Slowly, and so fast that a single step leads over the edge.
    const double step = i % 2 == 0 ? random.between(0.0001, 0.0004) : random.between(0.003, 0.005);
    stage.lead(through, {through.x, through.y, 0.001}, step, check);
  }
  ticks += stage.ticks();
  return wrong;
}

int strokeSlivers(Renderer& method, Random& random, int& ticks) {
  constexpr double kDepth = 0.003;
  int wrong = 0;
  Stage stage(method, random);
  stage.add(slivers());
  Vec3 at{0.001, 0.002, 0.05 - kDepth};
  stage.begin(at + Vec3(0, 0, 2 * kDepth));
  stage.tick(at);
  for (int i = 0; i < 20; ++i) {
    const Vec3 to{random.between(-0.045, 0.045), random.between(-0.045, 0.045), 0.05 - kDepth};
    stage.lead(at, to, 0.0013, [&](const Felt& felt, Vec3 hip) {
      const bool right = felt.touching && glm::distance(felt.ihip, hip + Vec3(0, 0, kDepth)) < kInside_m;
      wrong += right ? 0 : 1;
    });
    at = to;
  }
  ticks += stage.ticks();
  return wrong;
}

/// IHIPs, in units of `scale`, of the same walk over overlapping bodies, about where they meet; all lengths times
/// `scale`.
std::vector<Vec3> walk(Renderer& method, Random random, double scale) {
  Stage stage(method, Pose{});
  stage.add(shapes::bumpy(0.03, 8).scaled(scale));
  stage.add(shapes::torus(0.03, 0.01, 24, 12).scaled(scale), Vec3(0.02, 0, 0.01) * scale);
  const Vec3 seam{0.016, 0.026, 0.009};
  Vec3 hip{0, 0, 0.07};
  Vec3 step(0);
  stage.begin(hip * scale);
  std::vector<Vec3> ihips;
  for (int i = 0; i < 600; ++i) {
    step = step * 0.95 + Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)) * 0.0005 -
           (hip - seam) * 0.01;
    hip += step;
    ihips.push_back(stage.tick(hip * scale).ihip / scale);
  }
  return ihips;
}

/// The same for strokes over a sphere. Rounding the vertices anew moves them by 2^-24.
std::vector<Vec3> stroke(Renderer& method, Random random, double scale) {
  constexpr double kRadius = 0.05;
  Stage stage(method, Pose{});
  stage.add(shapes::sphere(kRadius, 16).scaled(scale));
  stage.begin(Vec3(0, 0, 2 * kRadius) * scale);
  std::vector<Vec3> ihips;
  for (int i = 0; i < 100; ++i) {
    const Vec3 over = random.direction() * (kRadius + 0.0005);
    const Vec3 along = glm::normalize(glm::cross(over, random.direction()));
    const Vec3 step = along * random.between(0.0001, 0.002) - glm::normalize(over) * 0.0005;
    stage.place(over * scale);
    for (int j = 1; j <= 8; ++j)
      ihips.push_back(stage.tick((over + step * static_cast<double>(j)) * scale).ihip / scale);
  }
  return ihips;
}

int differentTicks(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  int different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different += a[i] == b[i] ? 0 : 1;
  return different;
}

}  // namespace

SceneResult strokeSharpAndScaledShapes(Renderer& method, Random& random) {
  constexpr double kMostRelative = 1e-5;
  int ticks = 0;
  const int creases = strokeCreases(method, random, ticks);
  const int blade = strokeKnife(method, random, ticks);
  const int sliver = strokeSlivers(method, random, ticks);
  int different = 0;
  const auto once = walk(method, random, 1);
  for (const double scale : {0x1p-10, 0x1p-3, 0x1p10}) different += differentTicks(once, walk(method, random, scale));
  double relative = 0;
  const auto stroked = stroke(method, random, 1);
  for (const double scale : {1e-3, 0.1, 1e3}) {
    const auto scaled = stroke(method, random, scale);
    for (std::size_t i = 0; i < stroked.size(); ++i) {
      relative = std::max(relative, glm::distance(scaled[i], stroked[i]) / 0.05);
    }
  }
  return {{{"ticks", ticks},
           {"crease_wrong_side_ticks", creases},
           {"knife_wrong_side_ticks", blade},
           {"sliver_wrong_ticks", sliver},
           {"powers_of_two_different_ticks", different},
           {"powers_of_ten_relative_error_max", relative}},
          creases == 0 && blade == 0 && sliver == 0 && different == 0 && relative <= kMostRelative};
}

}  // namespace haptics::eval
