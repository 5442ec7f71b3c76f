#pragma once

#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "graphics_client/viewer/label_layout.h"
#include "graphics_client/viewer/scene_actors.h"
#include "graphics_client/viewer/text_panel.h"

namespace haptics {

/// The objects' names below them in the picture, where several have to be told apart.
class ObjectLabels {
 public:
  /// Drawn by `overlay`, for what `world` shows.
  ObjectLabels(vtkRenderer* overlay, vtkRenderer* world) : overlay_(overlay), world_(world) {}

  /// Follows the objects and the world's camera. `taken`: places of the window that are not free.
  void update(const std::vector<NamedBox>& objects, std::span<const PixelBox> taken, double font_px);
  void setVisible(bool visible) { visible_ = visible; }

 private:
  struct Label {
    PanelBackground background;
    vtkNew<vtkTextActor> text;
    std::string name;
    double font_px = 0, width_px = 0, height_px = 0;

    explicit Label(vtkRenderer* renderer);
    void setName(vtkRenderer* renderer, const std::string& newName, double newFont_px);
  };

  vtkRenderer* overlay_;
  vtkRenderer* world_;
  std::vector<std::unique_ptr<Label>> labels_;
  bool visible_ = true;

  [[nodiscard]] std::vector<LabelWish> wishes(const std::vector<NamedBox>& objects) const;
};

}  // namespace haptics
