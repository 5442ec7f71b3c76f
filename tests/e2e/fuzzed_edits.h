#pragma once

#include <string>
#include <vector>

#include "haptics/v1/scene.pb.h"
#include "tests/eval/fuzz/edit_run.h"

namespace haptics::e2e {

/// What `haptic_eval fuzz edits` draws from a seed, as a client would send it. Of what changes the force by itself under a
/// HIP at rest nothing is taken: no object moves, none goes back to its shape slowly or keeps a dent.
class FuzzedEdits {
 public:
  struct Edit {
    double after_s = 0;  ///< The first of its window was sent.
    v1::Transaction transaction;
  };
  struct Window {
    std::string kind;
    Vec3 hip{0};                            ///< Where the HIP rests, world, metres.
    std::vector<Edit> edits;                ///< One, or two, of which the second comes while the first is on its way.
    std::vector<eval::FuzzObject> objects;  ///< After them.
  };

  explicit FuzzedEdits(std::uint64_t seed);

  [[nodiscard]] Vec3 start() const { return run_.hips.front(); }  ///< Away from all objects.
  /// All objects that there are at first.
  [[nodiscard]] const v1::Transaction& scene() const noexcept { return scene_; }
  [[nodiscard]] const std::vector<Window>& windows() const noexcept { return windows_; }
  /// Removes all objects that are left after a window.
  [[nodiscard]] v1::Transaction removal(std::size_t window) const;
  [[nodiscard]] const eval::FuzzMesh& mesh(std::size_t mesh) const { return run_.meshes[mesh].mesh; }
  /// Canonical bytes of all meshes, in order.
  [[nodiscard]] const std::vector<std::string>& assets() const noexcept { return assets_; }

 private:
  [[nodiscard]] v1::Transaction change(const std::vector<eval::FuzzObject>& from,
                                       const std::vector<eval::FuzzObject>& to) const;
  void add(const eval::FuzzObject& object, v1::Transaction& transaction) const;
  void edit(const eval::FuzzObject& from, const eval::FuzzObject& to, v1::Transaction& transaction) const;
  [[nodiscard]] std::string nameOf(const eval::FuzzObject& object) const;
  void setMesh(const eval::FuzzObject& object, v1::MeshSource& mesh) const;

  std::uint64_t seed_;
  eval::EditRun run_;
  std::vector<std::string> assets_, hashes_;
  v1::Transaction scene_;
  std::vector<Window> windows_;
};

}  // namespace haptics::e2e
