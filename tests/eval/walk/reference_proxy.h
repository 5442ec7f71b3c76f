#pragma once

#include <array>
#include <optional>

#include "tests/eval/walk/obstacles.h"

namespace haptics::eval {

/// What the IHIP should be: the HIP's motion is cut into many parts, and in each the proxy descends to the next local
/// minimum of its distance to the HIP, outside of every body. As long as it can it goes to the nearest point of the
/// triangles that it lies on: where a minimum ends, that rule, which is the paper's, decides for the next one. Where
/// several surfaces hold it, and in the air, it moves straight, on a triangle at most to that triangle's end, along what
/// stands in its way, as the god-object does (Zilles and Salisbury 1995). Knows triangles only: no neighbours, no
/// features, no hierarchy of the server. World, metres; bodies at rest.
class ReferenceProxy {
 public:
  /// The proxy keeps this fraction of the largest coordinate above what it rests on.
  static constexpr double kSkin = 0x1p-34;

  explicit ReferenceProxy(const TriangleSoup& soup);

  /// Free.
  void place(Vec3 hip);
  /// Goes on from another proxy's place. Where that is on walls that no place near it is above all of, as at the bottom
  /// of a narrow crack, from a place beside it that is outside of every body.
  void resume(Vec3 ihip, Vec3 hip);
  void follow(Vec3 hip, int parts);
  /// By how much, at most, the proxy went farther than the HIP in a part of the last follow(): as long as it keeps to a
  /// minimum it does not, so that this is how far it went from one that ended.
  [[nodiscard]] double leap_m() const { return leap_; }

  [[nodiscard]] Vec3 ihip() const { return at_; }
  [[nodiscard]] bool touching() const { return at_ != hip_; }

 private:
  /// The walls that the proxy has met in one place.
  struct Walls {
    static constexpr std::size_t kMax = 8;
    std::array<Wall, kMax> met;
    std::size_t count = 0;
    std::array<const Wall*, 3> pushing{};
    std::size_t pushingCount = 0;

    [[nodiscard]] std::optional<Vec3> nearest(Vec3 h, double slack);
  };

  [[nodiscard]] Vec3 outsideNear(Vec3 place) const;
  void settle(Vec3 h);
  [[nodiscard]] bool hop(Vec3 h);
  [[nodiscard]] bool move(Vec3 h);
  [[nodiscard]] bool leaveCorner(Vec3 h, double& nearest_m);
  [[nodiscard]] bool leaveRim(Vec3 h);
  void keepInSight();
  void lookAround();
  [[nodiscard]] double timeInSight(Vec3 to) const;

  const TriangleSoup* soup_;
  double skin_;
  Obstacles obstacles_;
  Vec3 at_{0};
  Vec3 hip_{0};
  Vec3 sightCentre_{0};  // of the cube that was gathered
  double sight_;         // half of its side, m
  double nextSight_;
  double leap_ = 0;
};

}  // namespace haptics::eval
