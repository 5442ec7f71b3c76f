#pragma once

#include <memory>

#include "haptic_server/simplification/force_difference.h"
#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// A mesh for one object, judged against the scene's own by the same strokes in the same scene.
struct Candidate {
  std::shared_ptr<const TriMesh> mesh;  ///< As import takes it from its file.
  std::shared_ptr<const CollisionMesh> surface;
  std::size_t triangles = 0;
  double deviation_mm = 0;  ///< Largest, of a vertex of the scene's own mesh from this one.
  ForceDifference
      difference;        ///< Of the production step's force, shaded where the object is, from that on the own mesh.
  bool exact = false;    ///< The shape is the same: only flat faces are of fewer triangles.
  bool strayed = false;  ///< Farther from the scene's own mesh than the tolerance.
  bool opened = false;   ///< The mesh has an inside no more.
  double hot_ns = 0;     ///< Contact tick on the strokes, median.
  double cold_ns = 0;    ///< The same with every cache swept.
  double memory_MB = 0;

  [[nodiscard]] bool good() const noexcept { return difference.good() && !opened && !strayed; }
};

/// The scene's own mesh first, the same shape of fewer triangles where there is one, then copies, each with 0.7 of the triangles of the one before, until two on end will not
/// do.
/// @param tolerance  How far a copy may stray from the scene's own mesh, as a part of the object's longest side.
[[nodiscard]] std::vector<Candidate> candidatesFor(const std::vector<LoadedObject>& scene, std::size_t object,
                                                   const std::vector<HandStroke>& strokes, double tolerance);

}  // namespace haptics::eval
