#pragma once

#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <string>
#include <vector>

class vtkRenderWindowInteractor;

namespace haptics {

struct KeyHelp {
  std::string key, does;
};

/// Keyboard and mouse of the window. The mouse orbits around the scene with z up, pans with the middle button and zooms
/// with the right one or the wheel.
class Controls {
 public:
  /// `onKey` gets the keys as they are typed; `onClose` is called when the window is closed.
  Controls(vtkRenderWindow* window, vtkRenderer* world, std::function<void(char)> onKey, std::function<void()> onClose);
  ~Controls();
  Controls(const Controls&) = delete;
  Controls& operator=(const Controls&) = delete;

  /// Handles what has happened since the last call; does not wait and does not draw.
  void process();

  [[nodiscard]] static const std::vector<KeyHelp>& help();

 private:
  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
};

}  // namespace haptics
