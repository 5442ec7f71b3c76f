#pragma once

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <filesystem>
#include <functional>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "graphics_client/viewer/static_layer_cache.h"
#include "graphics_client/viewer/viewer.h"

namespace haptics {

/// Where the key light comes from: unit, world frame. Shadows on the floor follow it.
[[nodiscard]] Vec3 keyLightDirection();

/// A view of the scene in two layers: the scene itself, and above it a pale second drawing of the markers, so that the
/// HIP is seen inside the object that it presses on. Both share a camera.
struct ScenePane {
  vtkNew<vtkRenderer> solid;
  vtkNew<vtkRenderer> ghost;
};

/// The window with its panes: the world, the close-up of the contact in the lower right corner, the overlay on top.
class RenderWindow {
 public:
  explicit RenderWindow(const ViewerOptions& options);

  [[nodiscard]] vtkRenderWindow* window() { return window_; }
  /// Its solid layer lists what is drawn (static_layer_cache.h).
  [[nodiscard]] ScenePane& world() { return world_; }
  [[nodiscard]] ScenePane& closeUp() { return closeUp_; }
  [[nodiscard]] vtkRenderer* overlay() { return overlay_; }
  [[nodiscard]] int width_px() const;
  [[nodiscard]] int height_px() const;

  /// Draws into that window of the X server instead of one of its own; before the first picture.
  void embedIn(unsigned long window);
  void resize(int width_px, int height_px) { window_->SetSize(width_px, height_px); }

  /// What `draw` gives while the picture, not the window on the screen, has this size.
  [[nodiscard]] vtkSmartPointer<vtkImageData> atSize(int width_px, int height_px,
                                                     const std::function<vtkSmartPointer<vtkImageData>()>& draw);

  void showCloseUp(bool show);
  [[nodiscard]] bool closeUpShown() const { return closeUpShown_; }
  /// The close-up's square, from the lower left corner of the window; follows the window's size.
  [[nodiscard]] int closeUpSide_px() const;
  [[nodiscard]] int closeUpLeft_px() const;
  [[nodiscard]] int closeUpBottom_px() const;

  void render();
  /// As StaticLayerCache has it.
  void settle() { still_.settle(); }
  /// Frames in which all of the world was drawn (static_layer_cache.h).
  [[nodiscard]] std::uint64_t drawnAnew() const { return still_.drawnAnew(); }
  /// Anti-aliasing of the next pictures: free on a graphics card, five times the cost of a frame in software.
  void smoothOutlines(bool on);
  /// After the first picture.
  [[nodiscard]] bool drawsInSoftware();
  /// The picture drawn last.
  [[nodiscard]] vtkSmartPointer<vtkImageData> grab();

 private:
  vtkNew<vtkRenderWindow> window_;
  ScenePane world_, closeUp_;
  StaticLayerCache still_;  // of the world's solid layer
  vtkNew<vtkRenderer> overlay_;
  bool closeUpShown_ = true;

  void placeCloseUp();
};

/// Writes the picture as PNG. Errors name the file.
[[nodiscard]] Result<void> writePng(vtkImageData* picture, const std::filesystem::path& file);

}  // namespace haptics
