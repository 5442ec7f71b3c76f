#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/scene/object_assets.h"
#include "haptic_server/scene/surface_warnings.h"

namespace haptics {

/// The newest samples of a client that moves an object's vertices (SetDeformation::kinematic), beside the scene.
struct DrivenShape {
  struct Sample {
    std::optional<Lattice> lattice;  ///< None: the object's own shape.
    ShapeSample vertices;
  };

  std::uint64_t number = 0;  ///< KinematicShape::number.
  /// The newest last; two to ShapeSamples::kMax where there are any. Before the first one comes the object's own shape.
  std::vector<std::shared_ptr<const Sample>> samples;

  bool operator==(const DrivenShape&) const = default;
  /// KinematicShape::first.
  [[nodiscard]] std::uint64_t first() const noexcept;
  /// @param isMore  Else the newest one is replaced.
  void take(std::shared_ptr<const Sample> sample, bool isMore);
};

/// Why the object's vertices cannot be driven, "yields"; nothing: they can.
[[nodiscard]] std::optional<std::string> whyNotReshaped(const ObjectRecord& object);

/// A sample of an object with these assets. Refused, naming the field below Deformation: a mesh that is not within the lattice,
/// or that it turns inside out.
[[nodiscard]] Result<DrivenShape::Sample> shapeSample(const ObjectRecord& object, const ObjectAssets& assets,
                                                      Lattice lattice, bool latticeOfMesh);
[[nodiscard]] DrivenShape::Sample ownShape(const ObjectRecord& object, const ObjectAssets& assets);

/// Triangles of all objects whose vertices are driven, which each tick of each hand goes through: a fifth of its period.
[[nodiscard]] std::size_t mostDrivenTriangles(const DeviceLimits& device) noexcept;

}  // namespace haptics
