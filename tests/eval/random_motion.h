#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"
#include "tests/eval/random.h"
#include "tests/eval/renderer.h"
#include "tests/eval/winding.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval {

/// Closed bodies and a HIP in random motion: what S31, S32 and the walk lead methods through. Metres, the scene's frame.
class RandomMotion {
 public:
  /// The hand yields when the IHIP is farther from it.
  static constexpr double kDeepest_m = 0.01;

  explicit RandomMotion(Random random) : random_(random) {}
  virtual ~RandomMotion() = default;

  struct Moved {
    shapes::Shape shape;
    std::shared_ptr<const CollisionMesh> surface;
    WindingMesh mesh;
    Pose pose;
    /// What it was before its last edit.
    std::optional<WindingMesh> meshBefore = std::nullopt;
    int ticksSinceEdit = 0;
  };
  [[nodiscard]] const std::vector<Moved>& bodies() const { return bodies_; }
  [[nodiscard]] Vec3 hip() const { return hip_; }

  /// One tick later. @param ihip  Of the tick before.
  void next(Vec3 ihip);
  /// The body whose surface this tick has replaced.
  [[nodiscard]] std::optional<std::size_t> edited() const { return edited_; }
  /// How deep a point is inside a body (m). In the ticks after an edit, in which a method may still render the shape
  /// before, only what is inside of both is inside.
  [[nodiscard]] double depthInside(Vec3 point) const;

 protected:
  /// Moves the bodies.
  virtual void moveBodies(Vec3 ihip) = 0;

  [[nodiscard]] Random& random() { return random_; }
  void add(shapes::Shape shape, const Pose& pose);
  void setPose(std::size_t body, const Pose& pose) { bodies_[body].pose = pose; }
  /// The same triangles with other vertices.
  void refit(std::size_t body, const shapes::Shape& moved);
  void startHip(Vec3 hip) { hip_ = hip; }

 private:
  void chooseTarget();

  Random random_;
  std::vector<Moved> bodies_;
  std::optional<std::size_t> edited_;
  Vec3 hip_{0};
  std::size_t riddenBody_ = 0;
  Vec3 target_{0};  // in the frame of the body that is ridden
  double speed_m_per_s_ = 0;
  int ticksLeft_ = 0;
};

/// Boxes that close on the IHIP from all sides at 0.05 to 1 m/s, tilt, and draw back again.
[[nodiscard]] std::unique_ptr<RandomMotion> makeCrushed(Random random);

/// One closed mesh that passes through itself.
struct FoldedCase {
  enum class Shape { kTwoBalls, kBentTube, kFigureEight } shape;
  enum class State { kFixed, kMoving, kDented } state;
};
inline constexpr int kFoldedCases = 9;
[[nodiscard]] FoldedCase foldedCase(int number);
[[nodiscard]] std::unique_ptr<RandomMotion> makeFolded(Random random, FoldedCase which);

struct MotionCounts {
  int ticks = 0;
  int contact = 0;
  int notFinite = 0;
  InsideTicks inside;
};
/// Leads the method through the motion, in a random frame, and judges each tick by winding number.
void leadThrough(Renderer& method, RandomMotion& motion, int ticks, Random& random, MotionCounts& counts);

}  // namespace haptics::eval
