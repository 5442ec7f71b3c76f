// Sharp, thin and scaled meshes: S12.

#include <algorithm>
#include <numbers>

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

/// Where the gash ends: a line along y.
constexpr double kGashBottom_m = -0.01;
/// Farther from there is not at its bottom. A proxy that keeps a micrometre's tenth clear of both sides stands so much
/// higher as they are steep.
constexpr double kAtBottom_m = 2e-5;

/// A cylinder about z with a pit as narrow as the gash in its top, its bottom in the origin. A sixth of the pit's side is
/// slivers, so that a mean of the faces there that does not weigh them by their angles points across the pit.
shapes::Shape pit() {
  constexpr std::uint32_t kBroad = 5;
  constexpr std::uint32_t kSlivers = 64;
  constexpr std::uint32_t kCount = kBroad + kSlivers;
  constexpr double kMouth_m = 0.005;
  constexpr double kRadius_m = 0.02;
  constexpr double kTop_m = 0.06;
  constexpr double kFoot_m = -0.04;
  shapes::Shape shape;
  shape.vertices = {Vec3f(0), Vec3f(0, 0, static_cast<float>(kFoot_m))};
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double sixths = i < kBroad ? i : kBroad + static_cast<double>(i - kBroad) / kSlivers;
    const double turn = std::numbers::pi / 3 * sixths;
    const Vec3 out(std::cos(turn), std::sin(turn), 0);
    const Vec3 up(0, 0, 1);
    for (const Vec3 v : {kMouth_m * out + kTop_m * up, kRadius_m * out + kTop_m * up, kRadius_m * out + kFoot_m * up}) {
      shape.vertices.emplace_back(v);
    }
  }
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::uint32_t a = 2 + 3 * i;
    const std::uint32_t b = 2 + 3 * ((i + 1) % kCount);
    for (const auto& t : {std::array{0U, a, b},
                          {a, b + 1, b},
                          {a, a + 1, b + 1},
                          {a + 1, b + 2, b + 1},
                          {a + 1, a + 2, b + 2},
                          {1U, b + 2, a + 2}}) {
      shape.triangles.push_back(t);
    }
  }
  return shape;
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

/// Pressed into the bottom of a gash and of a pit, and led about below it: for all that way the bottom is the nearest
/// place, which its side that the search came from sees from above as often as from below.
int strokeBottoms(Renderer& method, Random& random, int& ticks) {
  constexpr double kStep = 0.0004;
  int wrong = 0;
  for (const bool line : {true, false}) {
    Stage stage(method, random);
    stage.add(line ? crease(true) : pit());
    stage.begin({0, 0, 0.07});
    for (int i = 0; i < 50; ++i) {
      const Vec3 bottom = line ? Vec3(0, random.between(-0.04, 0.04), kGashBottom_m) : Vec3(0);
      const auto below = [&] {
        const double turn = random.between(0, 2 * std::numbers::pi);
        const double aside = random.between(0.001, 0.003);
        return bottom + Vec3(aside * std::cos(turn), line ? 0 : aside * std::sin(turn), random.between(-0.003, -0.001));
      };
      const auto check = [&](const Felt& felt, Vec3 hip) {
        const bool right = felt.touching && glm::distance(felt.ihip, bottom) < kAtBottom_m;
        wrong += hip.z > bottom.z - 0.0005 || right ? 0 : 1;
      };
      const Vec3 within = bottom + Vec3(random.between(-1e-4, 1e-4), 0, 0.005);
      Vec3 at = bottom - Vec3(0, 0, 0.001);
      stage.place(within);
      stage.lead(within, at, kStep, check);
      for (int stroke = 0; stroke < 4; ++stroke) {
        const Vec3 to = below();
        stage.lead(at, to, kStep, check);
        at = to;
      }
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
  constexpr double kMaxRelative = 1e-5;
  int ticks = 0;
  const int creases = strokeCreases(method, random, ticks);
  const int blade = strokeKnife(method, random, ticks);
  const int sliver = strokeSlivers(method, random, ticks);
  int different = 0;
  const auto once = walk(method, random, 1);
  for (const double scale : {0x1p-10, 0x1p-3, 0x1p10}) different += differentTicks(once, walk(method, random, scale));
  const int bottoms = strokeBottoms(method, random, ticks);
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
           {"bottom_wrong_ticks", bottoms},
           {"sliver_wrong_ticks", sliver},
           {"powers_of_two_different_ticks", different},
           {"powers_of_ten_relative_error_max", relative}},
          creases == 0 && blade == 0 && bottoms == 0 && sliver == 0 && different == 0 && relative <= kMaxRelative};
}

}  // namespace haptics::eval
