#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/deform/soft_tissue.h"
#include "tests/eval/fuzz/fuzz_mesh.h"

namespace haptics::eval {

/// An object as an edit leaves it. World, SI units; what is 0 is not there.
struct FuzzObject {
  std::uint64_t id = 0;
  std::size_t mesh = 0;     ///< Of the run's.
  std::uint64_t shape = 0;  ///< Counts the edits of its shape.
  Pose pose;
  std::uint64_t poseRevision = 0;  ///< That last set the pose.
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;
  bool pendingRemoval = false;
  double mass_kg = 0;  ///< Not 0: the step moves it; a spring pulls it to its pose.
  std::optional<SoftTissue> tissue;
  double crease_rad = 0;          ///< Not 0: force shading.
  double friction = 0;            ///< Static coefficient; sliding, 0.7 of it.
  double textureAmplitude_m = 0;  ///< Of gradient noise.
  double textureWavelength_m = 0;
  bool bumpMapped = false;  ///< The texture, instead of by Eq. (4).

  [[nodiscard]] bool sameSurface(const FuzzObject& other) const {
    return mesh == other.mesh && crease_rad == other.crease_rad && friction == other.friction &&
           textureAmplitude_m == other.textureAmplitude_m && textureWavelength_m == other.textureWavelength_m &&
           bumpMapped == other.bumpMapped;
  }
  [[nodiscard]] bool hasDetail() const { return crease_rad > 0 || friction > 0 || textureAmplitude_m > 0; }
};

/// What is published before a tick.
struct FuzzScene {
  std::uint64_t tick = 0;
  std::uint64_t revision = 0;
  std::vector<FuzzObject> objects;  ///< In order of id.
};

/// Ticks over which the HIP rests, and an edit, or two, come.
struct EditWindow {
  std::string edit;           ///< Kind.
  std::size_t objects = 0;    ///< There were when it came.
  std::uint64_t begin = 0;    ///< Tick before which it is published.
  std::uint64_t settled = 0;  ///< Tick after which it is to be felt in full.
  std::uint64_t end = 0;      ///< First tick that is not judged.
};

/// Scenes, edits and a HIP: all that the step is given. The HIP begins free, at its first place.
struct EditRun {
  struct Mesh {
    FuzzMesh mesh;
    std::optional<std::size_t> refitted;  ///< The same triangles as of that mesh, pulled by a lattice.
  };
  double rate_Hz = 1000;
  std::string device;  ///< Preset whose limits hold; empty: no limits.
  bool stabiliser = false;
  std::vector<Mesh> meshes;
  std::vector<FuzzScene> scenes;  ///< The first before tick 0.
  std::vector<EditWindow> windows;
  std::vector<Vec3> hips;  ///< Tick by tick.

  [[nodiscard]] double period_s() const { return 1 / rate_Hz; }
};

}  // namespace haptics::eval
