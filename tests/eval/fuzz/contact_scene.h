#pragma once

#include "tests/eval/fuzz/contact_motion.h"

namespace haptics::eval {

struct ContactSceneKind {
  bool moving;           ///< Some bodies move and turn.
  double speed_m_per_s;  ///< The HIP's top speed.
};

/// Bodies drawn from a seed, one to five, overlapping, and a HIP that wanders among them, presses, and stands still.
class ContactScene {
 public:
  ContactScene(std::uint64_t seed, ContactSceneKind kind);

  [[nodiscard]] const std::vector<FuzzMesh>& meshes() const noexcept { return meshes_; }
  /// The next tick's; the HIP is led by where the IHIP was in the last one.
  [[nodiscard]] const ContactFrame& next(Vec3 ihip);
  [[nodiscard]] const ContactFrame& frame() const noexcept { return frame_; }  ///< Of the last; first of the beginning.

 private:
  struct Swing {
    Pose middle;
    Vec3 amplitude_m{0};
    Vec3 axis{0, 0, 1};
    double rate_rad_per_s = 0;
    double spin_rad_per_s = 0;  ///< 0: it stays where it is.
  };
  void addBody(MeshKind kind);
  [[nodiscard]] Vec3 somewhereOutside();
  void chooseTarget();
  [[nodiscard]] Pose poseAt(const Swing& swing) const;

  ContactSceneKind kind_;
  Random random_;
  std::vector<FuzzMesh> meshes_;
  std::vector<Swing> swings_;
  ContactFrame frame_;
  double time_s_ = 0;
  Vec3 velocity_m_per_s_{0};
  Vec3 target_{0};
  double speed_m_per_s_ = 0;
  double deepest_m_ = 0.004;  ///< The HIP is drawn back where it is farther from the IHIP.
  int ticksToTarget_ = 0;
};

}  // namespace haptics::eval
