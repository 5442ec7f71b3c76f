#pragma once

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkProp.h>
#include <vtkRenderer.h>

#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace haptics {

/// Draws what a renderer lists without drawing anew what stays as it is: props that have not changed for some frames are drawn
/// once and their picture kept, colours and depths; each frame starts from it and draws the others over it. The picture is
/// the same. In software most of a frame's cost is background, floor and objects that nobody touches.
class StaticLayerCache {
 public:
  /// @param listed  Its props are drawn, by its camera; it draws nothing itself. Takes the window's layer `layer` and the next.
  StaticLayerCache(vtkRenderWindow* window, vtkRenderer* listed, int layer);

  /// What is drawn first, background included, and what is drawn over it.
  [[nodiscard]] vtkRenderer* still() { return still_; }
  [[nodiscard]] vtkRenderer* moving() { return moving_; }

  /// The camera has come to rest, and everything is as it will stay: what does not change from the next frame on is taken as
  /// still at once. Later it takes longer.
  void settle() { framesToSettle_ = 2; }
  /// Before each frame, when everything is in its place.
  void sort();
  /// Frames that drew the still part anew.
  [[nodiscard]] std::uint64_t drawnAnew() const { return drawnAnew_; }

 private:
  /// A prop at the last frame.
  struct Known {
    vtkMTimeType changed = 0;
    int unchangedFrames = 0;
    bool isStill = false;
  };
  /// What decides where a place is in the picture.
  struct Projection {
    std::array<double, 16> matrix{};
    std::array<int, 2> size_px{};
    bool operator==(const Projection&) const = default;
  };

  vtkOpenGLRenderWindow* window_;
  vtkRenderer* listed_;
  vtkNew<vtkRenderer> still_, moving_;
  vtkNew<vtkOpenGLFramebufferObject> kept_;
  std::map<vtkProp*, Known> known_;
  std::vector<vtkProp*> stillProps_;
  Projection projection_;
  bool isKept_ = false;    // kept_ holds the picture of stillProps_ by projection_
  bool isToKeep_ = false;  // the picture that comes
  int framesToSettle_ = 0;
  std::uint64_t drawnAnew_ = 0;

  [[nodiscard]] Projection projection() const;
  bool followProps();
  void keep();
  void restore();
  void copy(vtkOpenGLFramebufferObject* from, vtkOpenGLFramebufferObject* to);
};

}  // namespace haptics
