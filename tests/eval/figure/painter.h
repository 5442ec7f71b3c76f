#pragma once

#include <vtkContextItem.h>

#include "tests/eval/figure/figure.h"

namespace haptics::eval {

/// Paints a figure onto a VTK context of one unit to the pixel.
class FigurePainter final : public vtkContextItem {
 public:
  static FigurePainter* New();
  vtkTypeMacro(FigurePainter, vtkContextItem)

      /// `figure` outlives the painter.
      void setFigure(const Figure& figure) {
    figure_ = &figure;
  }
  bool Paint(vtkContext2D* painter) override;

  [[nodiscard]] static int width_px(const Figure& figure);
  [[nodiscard]] static int height_px(const Figure& figure);

 private:
  struct Box {
    double left, below;
  };
  enum class Align { kLeft, kCentre, kRight };

  void text(double x, double y, const std::string& words, int size, Align align, Colour colour, bool bold = false);
  void upright(double x, double y, const std::string& words, int size);
  void line(double x0, double y0, double x1, double y1, Colour colour, double width, bool dashed = false);
  void marker(double x, double y, const Style& style);
  void paintPanel(const Panel& panel, Box box);
  void paintGrid(const Panel& panel, Box box);
  void paintCurve(const Panel& panel, const Curve& curve, Box box);
  void paintLegend(double left, double top);

  const Figure* figure_ = nullptr;
  vtkContext2D* context_ = nullptr;
};

}  // namespace haptics::eval
