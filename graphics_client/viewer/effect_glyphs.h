#pragma once

#include <memory>
#include <vector>

#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/viewer/contact_glyphs.h"

namespace haptics {

/// The effects that objects carry, as lines above the objects (effect_lines.h).
class EffectGlyphs {
 public:
  explicit EffectGlyphs(ScenePane& pane) : pane_(pane) {}

  /// @param current  false: everything grey.
  void update(const MirrorView& view, bool current);

 private:
  struct Slot {
    explicit Slot(ScenePane& pane);
    Glyph glyph;
    SceneVersion::Object record;  ///< Whose effect was drawn last,
    std::size_t number = 0;       ///< and which of its.
  };

  ScenePane& pane_;
  std::vector<std::unique_ptr<Slot>> slots_;  // as many as there were effects at once
};

}  // namespace haptics
