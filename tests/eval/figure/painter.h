#pragma once

#include <vtkContextItem.h>

#include <optional>

#include "tests/eval/figure/canvas.h"
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
  struct Area {
    double left, below, right, above;
    [[nodiscard]] bool overlaps(const Area& other) const {
      return left < other.right && other.left < right && below < other.above && other.below < above;
    }
  };
  void marker(double x, double y, const Style& style, Marker marker);
  void paintPanel(const Panel& panel, Box box);
  void paintGrid(const Panel& panel, Box box);
  void paintThreshold(const Panel& panel, Box box);
  void paintMark(const Panel& panel, Box box);
  void paintCurve(const Panel& panel, const Curve& curve, Box box);
  void paintLabels(const Panel& panel, const Curve& curve, Box box);
  /// What words in kSmallFont would cover, centred about y.
  [[nodiscard]] Area areaOf(const std::string& words, double x, double y, Align align, bool bold);
  [[nodiscard]] bool isCrossed(const Panel& panel, Box box, const Area& area) const;
  void paintLegend(double left, double top);

  const Figure* figure_ = nullptr;
  std::optional<Canvas> canvas_;  // while it paints
};

}  // namespace haptics::eval
