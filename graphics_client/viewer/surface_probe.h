#pragma once

#include <vtkSmartPointer.h>

#include <optional>

#include "graphics_client/viewer/render_window.h"
#include "graphics_client/viewer/surface_point.h"

namespace haptics {

/// Finds the surface under a pixel from the depths of the picture, while a frame is drawn: after the objects, before the
/// markers. Costs nothing in a frame that does not look.
class SurfaceProbe {
 public:
  explicit SurfaceProbe(ScenePane& world);
  ~SurfaceProbe();
  SurfaceProbe(const SurfaceProbe&) = delete;
  SurfaceProbe& operator=(const SurfaceProbe&) = delete;

  /// Looks after everything that was added to the pane so far.
  void lookLast();
  /// Where the next frame looks; nothing: nowhere.
  void aim(std::optional<Pixel> pixel);
  /// Of the frame drawn last; nothing where that was the background.
  [[nodiscard]] std::optional<SurfacePoint> found() const;

 private:
  class Reader;
  ScenePane& pane_;
  vtkSmartPointer<Reader> reader_;
};

}  // namespace haptics
