#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tests/eval/renderer.h"

namespace haptics::eval {

/// A tick of a scene under two methods. World frame, metres.
struct TracedTick {
  std::vector<Pose> poses;
  Vec3 hip{0};
  Felt without;  ///< The method that the scene is played with.
  Felt with;     ///< Ours, led by the same inputs.
};

/// From one begin() or place() of a scene to the next.
struct Trace {
  std::vector<std::shared_ptr<const CollisionMesh>> bodies;
  std::vector<TracedTick> ticks;
};

/// Plays a scene with a method, and lets ours follow the same bodies and the same HIP.
class SideBySide final : public Renderer {
 public:
  /// `look` sees the trace after each tick, and the one before it.
  using Look = std::function<void(const Trace& now, const Trace& before)>;

  SideBySide(std::unique_ptr<Renderer> without, std::unique_ptr<Renderer> with, Look look);
  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override;
  void place(Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;

 private:
  void next(std::vector<std::shared_ptr<const CollisionMesh>> bodies);

  std::unique_ptr<Renderer> without_;
  std::unique_ptr<Renderer> with_;
  Look look_;
  Trace now_;
  Trace before_;
};

}  // namespace haptics::eval
