#include "graphics_client/viewer/controls.h"

#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkInteractorStyleTerrain.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkRenderWindowInteractor.h>

#include <utility>

namespace haptics {
namespace {

/// VTK's own keys (e to leave, w, s, p, 3 ...) are replaced by ours.
class Style : public vtkInteractorStyleTerrain {
 public:
  static Style* New();
  vtkTypeMacro(Style, vtkInteractorStyleTerrain)

      void OnChar() override {
    if (onKey) onKey(GetInteractor()->GetKeyCode());
  }
  void OnMouseWheelForward() override { zoom(kZoomPerClick); }
  void OnMouseWheelBackward() override { zoom(1 / kZoomPerClick); }
  void OnKeyPress() override {}
  void OnKeyRelease() override {}
  void close() { onClose(); }

  std::function<void(char)> onKey;
  std::function<void()> onClose;

 private:
  static constexpr double kZoomPerClick = 1.12;

  void zoom(double factor) { GetDefaultRenderer()->GetActiveCamera()->Dolly(factor); }
};
vtkStandardNewMacro(Style)

}  // namespace

Controls::Controls(vtkRenderWindow* window, vtkRenderer* world, std::function<void(char)> onKey,
                   std::function<void()> onClose)
    : interactor_(vtkSmartPointer<vtkRenderWindowInteractor>::New()) {
  vtkNew<Style> style;
  style->onKey = std::move(onKey);
  style->onClose = std::move(onClose);
  style->SetDefaultRenderer(world);
  style->AutoAdjustCameraClippingRangeOff();
  interactor_->SetRenderWindow(window);
  interactor_->SetInteractorStyle(style);
  interactor_->AddObserver(vtkCommand::ExitEvent, style.Get(), &Style::close);
  interactor_->EnableRenderOff();  // the frame loop draws
  interactor_->Initialize();
}

Controls::~Controls() { interactor_->SetRenderWindow(nullptr); }

void Controls::process() { interactor_->ProcessEvents(); }

const std::vector<KeyHelp>& Controls::help() {
  static const std::vector<KeyHelp> keys = {
      {"drag", "orbit; middle button: pan"},
      {"wheel", "zoom; or the right button"},
      {"r", "reset the camera"},
      {"f", "follow the contact"},
      {"c", "close-up on or off"},
      {"w", "wireframe"},
      {"e", "polygon edges"},
      {"d", "colour by displacement"},
      {"n", "names on or off"},
      {"o", "overlay on or off"},
      {"s", "save a screenshot"},
      {"h", "hide this help"},
      {"q", "quit"},
  };
  return keys;
}

}  // namespace haptics
