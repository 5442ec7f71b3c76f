#include "graphics_client/viewer/effect_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

using Kind = Effect::Kind;
using Region = Effect::Region;

/// Of what has no end: so far about its point (metres).
constexpr double kPiece_m = 0.04;
constexpr double kCross_m = 0.003, kArrow_m = 0.02, kHead_m = 0.004;
constexpr int kRing = 32;
/// Rings round a tube, at most: more hide what is within. The reach of a path is shown at its ends alone, so that the path is seen.
constexpr std::size_t kTubeRings = 12, kReachRings = 2;

class Lines {
 public:
  void line(Vec3 from, Vec3 to) { ends_.insert(ends_.end(), {from, to}); }
  void path(const std::vector<Vec3>& points) {
    for (std::size_t i = 1; i < points.size(); ++i) line(points[i - 1], points[i]);
  }
  void cross(Vec3 at) {
    for (const Vec3 axis : {Vec3(kCross_m, 0, 0), Vec3(0, kCross_m, 0), Vec3(0, 0, kCross_m)})
      line(at - axis, at + axis);
  }
  void ring(Vec3 centre, Vec3 axis, double radius_m) {
    const Vec3 x = anyAcross(axis), y = glm::cross(axis, x);
    const auto at = [&](int i) {
      const double angle = 2 * std::numbers::pi * i / kRing;
      return centre + radius_m * (std::cos(angle) * x + std::sin(angle) * y);
    };
    for (int i = 0; i < kRing; ++i) line(at(i), at(i + 1));
  }
  void ball(Vec3 centre, double radius_m) {
    for (const Vec3 axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) ring(centre, axis, radius_m);
  }
  void box(Vec3 centre, Vec3 size_m) {
    const auto corner = [&](unsigned k) {
      return centre + size_m * Vec3((k & 1) != 0 ? 0.5 : -0.5, (k & 2) != 0 ? 0.5 : -0.5, (k & 4) != 0 ? 0.5 : -0.5);
    };
    for (unsigned k = 0; k < 8; ++k) {
      for (const unsigned bit : {1U, 2U, 4U}) {
        if ((k & bit) == 0) line(corner(k), corner(k | bit));
      }
    }
  }
  void square(Vec3 centre, Vec3 normal) {
    const Vec3 x = kPiece_m * anyAcross(normal), y = glm::cross(normal, x);
    path({centre + x + y, centre - x + y, centre - x - y, centre + x - y, centre + x + y});
  }
  void arrow(Vec3 from, Vec3 along, double length_m) {
    const Vec3 to = from + length_m * along, side = anyAcross(along);
    line(from, to);
    for (const Vec3 across : {side, glm::cross(along, side)}) {  // one of them is seen from anywhere
      for (const double s : {-1.0, 1.0}) line(to, to - kHead_m * along + s * kHead_m / 2 * across);
    }
  }
  [[nodiscard]] std::vector<Vec3> take() { return std::move(ends_); }

 private:
  std::vector<Vec3> ends_;
};

/// So many rings across a path at most, evenly over its points, the ends included.
void ringsAlong(Lines& lines, const std::vector<Vec3>& path, double radius_m, std::size_t most) {
  const std::size_t count = std::min(most, path.size());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * (path.size() - 1) / (count - 1);
    const Vec3 way = path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0];
    if (glm::length(way) > 0) lines.ring(path[i], glm::normalize(way), radius_m);
  }
}

void addRegion(Lines& lines, const Effect& effect) {
  if (effect.region == Region::kBox) lines.box(effect.point_m, effect.size_m);
  if (effect.region == Region::kSphere) lines.ball(effect.point_m, effect.size_m.x / 2);
}

}  // namespace

std::vector<Vec3> effectLines(const Effect& effect) {
  Lines lines;
  const Vec3 at = effect.point_m, n = effect.direction;
  const double reach_m = effect.reach_m;
  switch (effect.kind) {
    case Kind::kSpringToPoint:
      lines.cross(at);
      if (reach_m > 0) lines.ball(at, reach_m);
      break;
    case Kind::kSpringToLine: {
      const std::vector<Vec3> piece{at - kPiece_m * n, at, at + kPiece_m * n};
      lines.path(piece);
      if (reach_m > 0) ringsAlong(lines, piece, reach_m, kReachRings);
      break;
    }
    case Kind::kSpringToPlane:
      for (const double side : {-1.0, 0.0, 1.0}) {
        if (side == 0 || reach_m > 0) lines.square(at + side * reach_m * n, n);
      }
      break;
    case Kind::kSpringToPath:
    case Kind::kGuide:
    case Kind::kTube: {
      const std::vector<Vec3>& path = effect.path_m;
      lines.path(path);
      if (effect.kind == Kind::kTube) {
        ringsAlong(lines, path, effect.size_m.x / 2, kTubeRings);
      } else if (reach_m > 0) {
        ringsAlong(lines, path, reach_m, kReachRings);
      }
      const Vec3 last = path.back() - path[path.size() - 2];
      if (effect.kind == Kind::kGuide) lines.arrow(path.back(), glm::normalize(last), kHead_m);
      break;
    }
    case Kind::kForbiddenSide:
      lines.square(at, n);
      lines.arrow(at, n, kArrow_m);
      break;
    case Kind::kConstant:
      addRegion(lines, effect);
      if (effect.region != Region::kEverywhere) lines.arrow(at, n, kArrow_m);
      break;
    case Kind::kVibration:
    case Kind::kSamples:
      addRegion(lines, effect);
      if (effect.region == Region::kEverywhere) break;
      lines.arrow(at, n, kArrow_m / 2);
      lines.arrow(at, -n, kArrow_m / 2);
      break;
    case Kind::kViscosity:
    case Kind::kInertia:
      addRegion(lines, effect);
      break;
    case Kind::kMagnet:
    case Kind::kSpringToVertex:
    case Kind::kSpringToEdge:
    case Kind::kRecordedTexture:
      break;
  }
  return lines.take();
}

palette::Shade effectShade(Kind kind) {
  switch (kind) {
    case Kind::kForbiddenSide:
    case Kind::kTube:
      return palette::kKeepsOut;
    case Kind::kViscosity:
    case Kind::kInertia:
      return palette::kDrags;
    case Kind::kConstant:
    case Kind::kVibration:
    case Kind::kSamples:
    case Kind::kRecordedTexture:
      return palette::kActs;
    default:
      return palette::kPulls;
  }
}

}  // namespace haptics
