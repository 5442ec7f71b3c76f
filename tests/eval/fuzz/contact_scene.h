#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/eval/floors.h"
#include "tests/eval/fuzz/contact_motion.h"

namespace haptics::eval {

enum class ContactWorld : std::uint8_t {
  kWild,      ///< One to five bodies of any kind, overlapping.
  kFlush,     ///< A floor of boxes side by side (flushBoxes()).
  kCracked,   ///< A floor of one mesh (crackedMesh()).
  kMirrored,  ///< One to three bodies that a lattice mirrors, overlapping, among them plain ones.
  kThin,      ///< A plate or two, and a body.
};
inline constexpr std::array kContactWorlds{"wild", "flush", "cracked", "mirrored", "thin"};  ///< Their names.

struct ContactSceneKind {
  bool moving;           ///< Some bodies move and turn, a floor as one.
  double speed_m_per_s;  ///< The HIP's top speed.
  ContactWorld world = ContactWorld::kWild;
  double haste = 1;  ///< Times as fast as else do bodies swing (some 0.2 m/s) and turn.
};

/// Bodies drawn from a seed, and a HIP that wanders among them, presses, and stands still.
class ContactScene {
 public:
  ContactScene(std::uint64_t seed, ContactSceneKind kind);

  [[nodiscard]] const std::vector<FuzzMesh>& meshes() const noexcept { return meshes_; }
  [[nodiscard]] const std::optional<FlatTop>& flat() const noexcept { return flat_; }
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
  void addFloor(const Floor& floor);
  [[nodiscard]] Swing someSwing(bool moves);
  [[nodiscard]] Vec3 somewhereOutside();
  void chooseTarget();
  [[nodiscard]] Pose poseAt(const Swing& swing) const;

  ContactSceneKind kind_;
  Random random_;
  std::vector<FuzzMesh> meshes_;
  std::vector<Swing> swings_;  // of each body; of a floor, one
  std::vector<Pose> inFloor_;  // none: there is no floor
  std::optional<FlatTop> flat_;
  ContactFrame frame_;
  double time_s_ = 0;
  Vec3 velocity_m_per_s_{0};
  Vec3 target_{0};
  double speed_m_per_s_ = 0;
  double deepest_m_ = 0.004;  ///< The HIP is drawn back where it is farther from the IHIP.
  int ticksToTarget_ = 0;
};

}  // namespace haptics::eval
