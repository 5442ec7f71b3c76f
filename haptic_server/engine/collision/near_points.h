#pragma once

#include <span>

#include "haptic_server/engine/collision/body_pairs.h"
#include "haptic_server/engine/contact/frame.h"

namespace haptics {

/// Normals are much the same where their cosine is larger.
inline constexpr double kSameSide = 0.9;
/// What the four points of a leaf may take in the worst case, units (Allowance).
inline constexpr std::int64_t kOneNode = 60'000;

/// Finds the places of two bodies that are near each other's surfaces, in as many ticks as it takes. Wait-free.
class NearPoints {
 public:
  /// @param mayExceed  The first node is searched whatever it takes up to kOneNode: each tick gets on.
  NearPoints(PairSearch& search, bool mayExceed) noexcept : search_(search), mayExceed_(mayExceed) {}

  /// @param pose  Of the points' body in the surface's frame.
  /// @return False: the allowance is spent on the way.
  [[nodiscard]] bool find(const CollisionPoints& points, const CollisionMesh& surface, const Pose& pose, bool ofSecond,
                          Allowance& allowance) noexcept;

  /// Lowers PairSearch::clear_m to what is surely between two bodies, but not below the range.
  /// @param pose  Of the smaller body in the other's frame.
  void lowerClearance(const CollisionMesh& smaller, const CollisionMesh& other, const Pose& pose,
                      Allowance& allowance) noexcept;

  /// Finds the places where a polytope and a mesh are near each other, at once. False: too many triangles are near, or the
  /// bodies are deep in each other.
  [[nodiscard]] bool findOn(const Collider& solid, const Collider& ground, const Pose& pose, bool solidIsFirst,
                            double step_m, double period_s, BodyPair& pair, Allowance& allowance) noexcept;

  /// As PolytopeContact::isOneOfTwo.
  [[nodiscard]] bool isOneOfTwo() const noexcept { return isOneOfTwo_; }

  /// Of points whose normals are much the same those that span the largest area, and the deepest one. Where bodies are deep in
  /// each other, only the shortest way out counts.
  void choose(std::span<NearPoint> near, BodyPair& pair) const noexcept;
  /// Of all points at once, where they are on one side. `near` is not empty.
  static void chooseOf(std::span<const NearPoint> near, Vec3 normal, const BodyPair& before, BodyPair& pair) noexcept;

  /// Has bodies go over what is no step: a contact with the side of something whose top the point is level with, and that it
  /// comes to by the side, is left out, or is one with the top where the point has got there.
  static void passSteps(const Collider& first, const Collider& second, const Pose& relative, double step_m,
                        BodyPair& pair, Allowance& allowance) noexcept;

 private:
  PairSearch& search_;
  bool mayExceed_, isOneOfTwo_ = false;

  /// The bodies may overlap, as an edit has put one of them there.
  [[nodiscard]] bool isDeep() const noexcept { return search_.depth_m > 2 * search_.range_m; }
  /// How far from a face a point may meet it, unless it is deep inside.
  [[nodiscard]] double farthest() const noexcept {
    return isDeep() ? search_.range_m : std::max(search_.range_m, search_.depth_m);
  }
  void add(const CollisionPoints& points, std::uint32_t point, const CollisionMesh& surface, const Frame& frame,
           const Pose& pose, bool ofSecond, std::uint32_t& hint, Allowance& allowance) noexcept;
};

[[nodiscard]] inline Pose inverse(const Pose& pose) noexcept {
  const Quat back = glm::conjugate(pose.rotation);
  return {back, back * -pose.position};
}

}  // namespace haptics
