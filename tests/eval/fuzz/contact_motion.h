#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "tests/eval/fuzz/fuzz_mesh.h"

namespace haptics::eval {

/// Where everything is in one tick. World, metres.
struct ContactFrame {
  Vec3 hip{0};
  std::vector<Pose> poses;  ///< Of the bodies.
};

/// Where the surface of several bodies together is one plane: what is right above a HIP that is below it is known exactly.
struct FlatTop {
  Pose inFirst;  ///< Its frame in that of the first body, with which all others move; its plane is z = 0.
  Vec3 low{0}, high{0};
};

/// A HIP among bodies, tick by tick: all that the contact core is given. It begins free, at the first frame.
struct ContactMotion {
  std::vector<FuzzMesh> meshes;
  std::vector<ContactFrame> frames;
  std::optional<FlatTop> flat = std::nullopt;
};

/// The contact core under such a motion.
class ContactDrive {
 public:
  ContactDrive(const std::vector<FuzzMesh>& meshes, const ContactFrame& first);
  ContactDrive(const ContactDrive&) = delete;
  ContactDrive& operator=(const ContactDrive&) = delete;

  /// One tick: `result.ihip` is the HIP when free. `duration_ns` is what followContact() took.
  const ContactResult& tick(const ContactFrame& frame);
  [[nodiscard]] double duration_ns() const noexcept { return duration_ns_; }

 private:
  std::vector<std::shared_ptr<const CollisionMesh>> surfaces_;
  std::vector<Body> bodies_;
  ContactState state_;
  ContactCache cache_;
  ContactResult result_;
  double duration_ns_ = 0;
};

}  // namespace haptics::eval
