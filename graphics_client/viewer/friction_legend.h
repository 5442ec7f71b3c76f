#pragma once

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include <optional>

#include "graphics_client/viewer/object_actors.h"
#include "graphics_client/viewer/text_panel.h"

namespace haptics {

/// What the colours of surfaces with varying friction mean: a bar from the least to the most.
class FrictionLegend {
 public:
  explicit FrictionLegend(vtkRenderer* renderer);

  /// Nothing: hidden.
  void setRange(const std::optional<FrictionRange>& range);
  void place(double left_px, double bottom_px, double width_px, double font_px);
  [[nodiscard]] const PixelBox& box() const { return background_.box(); }
  void setVisible(bool visible);

 private:
  PanelBackground background_;
  vtkNew<vtkActor2D> bar_;
  vtkNew<vtkTextActor> title_, least_, most_;
  std::optional<FrictionRange> range_;
  PixelBox barBox_;

  void placeBar(const PixelBox& box);
};

}  // namespace haptics
