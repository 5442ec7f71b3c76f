// A closed mesh that passes through itself: S32.

#include <cmath>
#include <numbers>

#include "common/deform/dent.h"
#include "tests/eval/random_motion.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

/// Of a curve in the plane z = 0.
struct CurvePoint {
  Vec3 at;
  Vec3 along;  ///< Any length but 0.
};

/// Rings of `across` vertices around the points of a curve, closed by a fan at each end unless the curve is.
shapes::Shape tube(const std::vector<CurvePoint>& curve, double radius, int across, bool closedCurve) {
  shapes::Shape shape;
  const auto sides = static_cast<std::uint32_t>(across);
  for (const CurvePoint& point : curve) {
    const Vec3 normal = glm::normalize(Vec3(-point.along.y, point.along.x, 0));
    for (int i = 0; i < across; ++i) {
      const double angle = 2 * std::numbers::pi * i / across;
      shape.vertices.emplace_back(point.at + radius * (std::cos(angle) * normal + std::sin(angle) * Vec3(0, 0, 1)));
    }
  }
  const auto rings = static_cast<std::uint32_t>(curve.size());
  for (std::uint32_t ring = 0; ring + (closedCurve ? 0 : 1) < rings; ++ring) {
    const std::uint32_t a = ring * sides;
    const std::uint32_t b = (ring + 1) % rings * sides;
    for (std::uint32_t i = 0; i < sides; ++i) {
      const std::uint32_t j = (i + 1) % sides;
      shape.triangles.push_back({a + i, a + j, b + j});
      shape.triangles.push_back({a + i, b + j, b + i});
    }
  }
  if (closedCurve) return shape;
  const auto first = static_cast<std::uint32_t>(shape.vertices.size());
  shape.vertices.emplace_back(curve.front().at);
  shape.vertices.emplace_back(curve.back().at);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t j = (i + 1) % sides;
    shape.triangles.push_back({first, j, i});
    shape.triangles.push_back({first + 1, (rings - 1) * sides + i, (rings - 1) * sides + j});
  }
  return shape;
}

/// A loop whose ends pass through each other: a prolate trochoid.
shapes::Shape bentTube() {
  constexpr int kRings = 60;
  constexpr double kForward_m = 0.006;
  constexpr double kRound_m = 0.015;
  std::vector<CurvePoint> curve;
  for (int i = 0; i < kRings; ++i) {
    const double t = -4.5 + 9.0 * i / (kRings - 1);
    curve.push_back({Vec3(kForward_m * t - kRound_m * std::sin(t), kRound_m * std::cos(t), 0),
                     Vec3(kForward_m - kRound_m * std::cos(t), -kRound_m * std::sin(t), 0)});
  }
  return tube(curve, 0.005, 10, false);
}

/// A torus about a figure of eight, Gerono's lemniscate.
shapes::Shape figureEight() {
  constexpr int kRings = 64;
  constexpr double kHalf_m = 0.03;
  std::vector<CurvePoint> curve;
  for (int i = 0; i < kRings; ++i) {
    const double t = 2 * std::numbers::pi * (i + 0.25) / kRings;
    curve.push_back(
        {kHalf_m * Vec3(std::sin(t), std::sin(t) * std::cos(t), 0), kHalf_m * Vec3(std::cos(t), std::cos(2 * t), 0)});
  }
  return tube(curve, 0.006, 10, true);
}

shapes::Shape twoBalls() {
  shapes::Shape shape = shapes::sphere(0.02, 6);
  shape.add(shapes::sphere(0.016, 5), Vec3(0.02, 0.007, 0.004));
  return shape;
}

shapes::Shape shapeOf(FoldedCase::Shape shape) {
  switch (shape) {
    case FoldedCase::Shape::kTwoBalls:
      return twoBalls();
    case FoldedCase::Shape::kBentTube:
      return bentTube();
    case FoldedCase::Shape::kFigureEight:
      break;
  }
  return figureEight();
}

class Folded final : public RandomMotion {
 public:
  Folded(Random from, FoldedCase which) : RandomMotion(from), state_(which.state), atRest_(shapeOf(which.shape)) {
    add(atRest_, Pose{});
    startHip({0, 0, 0.05});
    direction_ = random().direction();
    axis_ = random().direction();
    way_m_ = random().between(0, 0.02);
    rate_rad_per_s_ = random().between(2, 30);
    turns_rad_per_s_ = random().between(0, 5);
  }

 private:
  void moveBodies(Vec3 /*ihip*/) override {
    time_s_ += kPeriod_s;
    if (state_ == FoldedCase::State::kMoving) {
      const Vec3 place = way_m_ * std::sin(rate_rad_per_s_ * time_s_) * direction_;
      setPose(0, {glm::angleAxis(turns_rad_per_s_ * time_s_, axis_), place});
    }
    if (state_ == FoldedCase::State::kDented && --ticksToDent_ <= 0) dent();
  }

  /// One or two dents in the shape at rest; those before go back.
  void dent() {
    const Falloff falloff(random().between(0.008, 0.02), 2);
    std::vector<Dent> dents;
    for (int i = 1 + random().below(2); i > 0; --i) {
      const Vec3f at = atRest_.vertices[static_cast<std::size_t>(random().below(int(atRest_.vertices.size())))];
      dents.push_back({at, Vec3f(random().between(0, maxDentDepth_m(falloff) / 2) * random().direction())});
    }
    shapes::Shape moved = atRest_;
    for (Vec3f& v : moved.vertices) v = dented(v, dents, falloff);
    refit(0, moved);
    ticksToDent_ = 350 + random().below(300);
  }

  FoldedCase::State state_;
  shapes::Shape atRest_;
  Vec3 direction_;
  Vec3 axis_;
  double way_m_ = 0;
  double rate_rad_per_s_ = 0;
  double turns_rad_per_s_ = 0;
  double time_s_ = 0;
  int ticksToDent_ = 400;
};

}  // namespace

FoldedCase foldedCase(int number) {
  return {static_cast<FoldedCase::Shape>(number / 3 % 3), static_cast<FoldedCase::State>(number % 3)};
}

std::unique_ptr<RandomMotion> makeFolded(Random random, FoldedCase which) {
  return std::make_unique<Folded>(random, which);
}

/// The IHIP is in the mesh for no more than a tick in a row, also where it passes through itself.
SceneResult strokeFoldedMeshes(Renderer& method, Random& random) {
  constexpr int kTicks = 3000;
  constexpr std::array kStates{"fixed", "moving", "dented"};
  std::array<MotionCounts, kStates.size()> counts;
  for (int i = 0; i < kFoldedCases; ++i) {
    const FoldedCase which = foldedCase(i);
    const auto motion = makeFolded(Random(static_cast<std::uint64_t>(random.below(1 << 30))), which);
    leadThrough(method, *motion, kTicks, random, counts[static_cast<std::size_t>(which.state)]);
  }
  SceneResult result;
  result.pass = true;
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    const std::string name = kStates[i];
    const MotionCounts& count = counts[i];
    result.measures[name + "_contact_ticks"] = count.contact;
    result.measures[name + "_inside_ticks"] = count.inside.all();
    result.measures[name + "_inside_ticks_in_a_row"] = count.inside.longest();
    result.measures[name + "_inside_depth_max_mm"] = count.inside.deepest_m() * 1e3;
    result.measures[name + "_non_finite_ticks"] = count.notFinite;
    result.pass =
        result.pass && count.inside.longest() <= 1 && count.notFinite == 0 && count.contact > count.ticks / 10;
  }
  return result;
}

}  // namespace haptics::eval
