#pragma once

#include <cmath>
#include <vector>

#include "tests/eval/random.h"
#include "tests/eval/renderer.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval {

/// Farther inside than this (m) counts as inside: the contact core's skin at the scenes' sizes and the vertices'
/// rounding together stay below 0.6 um.
inline constexpr double kInside_m = 1e-6;

/// Bodies under a method and a HIP that a scene leads. The scene is written in a frame of its own, which stands
/// anywhere and in any orientation in the world.
class Stage {
 public:
  Stage(Renderer& method, const Pose& frame) : method_(method), frame_(frame) {}
  Stage(Renderer& method, Random& random);  ///< In a random frame, no farther than 0.1 m from the origin.

  int add(std::shared_ptr<const CollisionMesh> surface, const Pose& pose = {});
  int add(const shapes::Shape& shape, Vec3 position = Vec3(0)) { return add(shape.build(), {{1, 0, 0, 0}, position}); }

  void begin(Vec3 hip);
  /// Hands over what add(), replace(), remove() and move() have made of the scene, under a HIP that is at `hip`.
  void edit(Vec3 hip, double spring_N_per_m = kSpring_N_per_m);
  void replace(int body, std::shared_ptr<const CollisionMesh> surface) {
    surfaces_[static_cast<std::size_t>(body)] = std::move(surface);
  }
  void remove(int body);  ///< Those after it move up.

  void place(Vec3 hip) { method_.place(toWorld(frame_, hip)); }
  void move(int body, const Pose& pose) { poses_[static_cast<std::size_t>(body)] = inWorld(pose); }
  Felt tick(Vec3 hip);
  Felt drive(Vec3 hip, bool samplesHaveCome);  ///< move() is of samples.

  /// Ticks of at most `step` metres along a straight line; calls check(felt, hip) after each.
  template <class Check>
  void lead(Vec3 from, Vec3 to, double step, Check check) {
    const int ticks = static_cast<int>(std::ceil(glm::distance(from, to) / step));
    for (int i = 1; i <= ticks; ++i) {
      const Vec3 hip = glm::mix(from, to, static_cast<double>(i) / ticks);
      check(tick(hip), hip);
    }
  }

  /// How deep a point is inside a closed body (m), judged by all of its triangles; 0 when outside.
  [[nodiscard]] double depthIn(int body, Vec3 point) const;
  /// In the deepest body.
  [[nodiscard]] double depthInside(Vec3 point) const;
  [[nodiscard]] Vec3 inWorld(Vec3 point) const { return toWorld(frame_, point); }
  [[nodiscard]] const std::vector<Pose>& poses() const noexcept { return poses_; }  ///< In the world.
  [[nodiscard]] int ticks() const noexcept { return ticks_; }

 private:
  [[nodiscard]] Felt inFrame(Felt felt) const;
  [[nodiscard]] Pose inWorld(const Pose& pose) const {
    return {frame_.rotation * pose.rotation, toWorld(frame_, pose.position)};
  }

  Renderer& method_;
  Pose frame_;
  std::vector<std::uint64_t> ids_;
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<Pose> poses_;
  std::uint64_t lastId_ = 0;
  int ticks_ = 0;
};

}  // namespace haptics::eval
