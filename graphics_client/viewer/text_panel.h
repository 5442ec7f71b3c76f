#pragma once

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "graphics_client/viewer/label_layout.h"
#include "graphics_client/viewer/overlay_text.h"
#include "graphics_client/viewer/palette.h"

namespace haptics {

/// Arial of this colour, as large in pixels as its font size says, drawn by the renderer.
void setUpText(vtkTextActor* actor, vtkRenderer* renderer, palette::Shade shade);

/// A rounded rectangle with a single colour, optionally transparent.
class PanelBackground {
 public:
  PanelBackground(vtkRenderer* renderer, palette::Shade shade, double opacity);

  void place(const PixelBox& box, double cornerRadius_px);
  [[nodiscard]] const PixelBox& box() const { return box_; }  ///< Last placed.
  void setShade(palette::Shade shade);
  void setVisible(bool visible);

 private:
  vtkNew<vtkActor2D> actor_;
  PixelBox box_;
};

/// A table of labels and values on a background; or of coloured dots and labels (a legend).
class TextPanel {
 public:
  /// Widths of the two columns in font sizes.
  struct Columns {
    double label, value;
  };

  TextPanel(vtkRenderer* renderer, Columns columns);

  /// Seen with the next setVisible().
  void setLines(const std::vector<OverlayLine>& lines);
  /// A dot in front of each line. Seen with the next setVisible().
  void setDots(const std::vector<palette::Shade>& dots);
  /// Size of the panel with this font.
  [[nodiscard]] double width_px(double font_px) const;
  [[nodiscard]] double height_px(double font_px);
  void place(double left_px, double bottom_px, double font_px);
  /// Where it was placed last.
  [[nodiscard]] const PixelBox& box() const { return background_.box(); }
  void setVisible(bool visible);
  /// The label of the line at a pixel, from the lower left corner; empty: there is none.
  [[nodiscard]] std::string labelAt(double x_px, double y_px) const;

 private:
  static constexpr std::size_t kTones = 4;

  vtkRenderer* renderer_;
  Columns columns_;
  PanelBackground background_;
  vtkNew<vtkTextActor> labels_;
  std::array<vtkNew<vtkTextActor>, kTones> values_;  // one for each tone, its lines among empty ones
  std::vector<std::unique_ptr<PanelBackground>> dots_;
  std::vector<OverlayLine> lines_;
  bool visible_ = false;

  [[nodiscard]] double lineHeight_px(double font_px);
};

}  // namespace haptics
