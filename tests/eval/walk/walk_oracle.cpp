#include "tests/eval/walk/walk_oracle.h"

#include <algorithm>

#include "tests/eval/random.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

/// Of the largest coordinate: above the core's own skin, 2^-20, times what a narrow groove makes of it.
constexpr double kSkin = 0x1p-18;

}  // namespace

WalkOracle::WalkOracle(const TriangleSoup& soup)
    : soup_(soup), skin_(kSkin * soup.extent_m()), obstacles_(soup, 0x1p-8 * skin_) {}

bool WalkOracle::isInside(Vec3 ihip) const { return soup_.isInside(ihip, kInside_m); }

bool WalkOracle::isHeldByNothing(Vec3 ihip, Vec3 hip) {
  const double depth = glm::distance(ihip, hip);
  const double look = std::min(16 * skin_, depth / 2);
  if (look < 2 * skin_) return false;  // too shallow to tell
  const Vec3 way = (hip - ihip) * (look / depth);
  obstacles_.gather(ihip, 2 * look);
  return !obstacles_.firstBlock(ihip - way, ihip + way) && !isHeldAtAGraze(ihip, hip);
}

/// Does the way to the HIP enter, farther on, a triangle that the IHIP rests on? Pushed nearly along it, it does so only
/// after many times the height that the IHIP keeps.
bool WalkOracle::isHeldAtAGraze(Vec3 ihip, Vec3 hip) {
  constexpr double kFarthest = 256;  // in skins
  const Vec3 way = hip - ihip;
  const double reach = std::min(kFarthest * skin_, glm::length(way));
  obstacles_.gather(ihip, reach);
  const auto block = obstacles_.firstBlock(ihip, ihip + way * (reach / glm::length(way)));
  if (!block) return false;
  const std::vector<Wall> walls = obstacles_.touching(ihip, way, skin_);
  return std::any_of(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.face == block->wall.face; });
}

bool WalkOracle::isLocalMinimum(Vec3 ihip, Vec3 hip, double step) {
  constexpr int kOtherWays = 256;
  obstacles_.gather(ihip, 2 * step);
  if (obstacles_.isMinimum(ihip, hip)) return true;
  const Vec3 inward = hip - ihip;
  const std::vector<Wall> walls = obstacles_.touching(ihip, inward, skin_);
  const Vec3 from = pushedOff(walls, ihip);
  std::vector<Vec3> ways{inward};
  for (const Wall& a : walls) {
    ways.push_back(inward - a.normal * glm::dot(a.normal, inward));
    for (const Wall& b : walls) {
      const Vec3 line = glm::cross(a.normal, b.normal);
      ways.push_back(line * glm::dot(line, inward));
    }
  }
  Random random(1);
  for (int i = 0; i < kOtherWays; ++i) {
    const Vec3 way = random.direction();
    ways.push_back(way);
    if (!walls.empty()) {
      const Vec3 n = walls[static_cast<std::size_t>(i) % walls.size()].normal;
      ways.push_back(way - n * glm::dot(n, way));
    }
  }
  return std::none_of(ways.begin(), ways.end(), [&](Vec3 way) { return isBetter(from, way, step, hip); });
}

/// Nearer by more than a thousandth of the way, and open. A place inside of a body is none: where two faces stand back
/// to back, pushing off each in turn can end between them, in the body, from where every way is open.
bool WalkOracle::isBetter(Vec3 from, Vec3 way, double step, Vec3 hip) const {
  constexpr double kSlope = 1e-3;
  const double length = glm::length(way);
  if (!(length > 0)) return false;
  const Vec3 to = from + way * (std::min(step, length) / length);
  const double gain = glm::distance(from, hip) - glm::distance(to, hip);
  return gain > kSlope * glm::distance(from, to) + skin_ && !obstacles_.firstBlock(from, to) && !soup_.isInside(to, 0);
}

}  // namespace haptics::eval
