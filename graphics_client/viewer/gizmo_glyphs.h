#pragma once

#include <array>
#include <optional>

#include "graphics_client/viewer/contact_glyphs.h"
#include "graphics_client/viewer/gizmo.h"

namespace haptics {

/// A gizmo as it is to be drawn.
struct GizmoPicture {
  Vec3 centre{0};
  std::optional<GizmoHandle> lit;  ///< Under the pointer, or dragged.
  GizmoHandles handles = {};
  std::optional<Vec3> direction = std::nullopt;  ///< That the rings turn, drawn through the centre; unit.

  bool operator==(const GizmoPicture&) const = default;
};

/// The handles of a gizmo, above all objects: x red, y green, z blue.
class GizmoGlyphs {
 public:
  explicit GizmoGlyphs(ScenePane& pane);

  /// Nothing: hidden.
  void update(const std::optional<GizmoPicture>& picture, const PictureCamera& camera);

 private:
  struct Axis {
    explicit Axis(ScenePane& pane);
    Glyph ring, shaft, tip;
  };
  std::array<Axis, 3> axes_;
  Glyph direction_;
};

}  // namespace haptics
