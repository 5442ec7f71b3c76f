#include "tests/eval/figure/panel_pair.h"

#include <vtkNew.h>
#include <vtkObjectFactory.h>

#include "tests/eval/figure/draw_item.h"

namespace haptics::eval {
namespace {

constexpr double kWidth = DrawnPanel::kWidth_px, kHeight = DrawnPanel::kHeight_px;
constexpr double kMargin = 16, kGap = 16, kHeader = 46, kHeading = 44, kFoot = 38;
constexpr int kTitleFont = 19, kTextFont = 15, kSmallFont = 13;
constexpr Colour kInk{0.13, 0.15, 0.18}, kFrame{0.72, 0.74, 0.77};

class PanelPairPainter final : public vtkContextItem {
 public:
  static PanelPairPainter* New();
  vtkTypeMacro(PanelPairPainter, vtkContextItem) void set(const PanelPair& pair) { pair_ = &pair; }

  [[nodiscard]] static int width_px() { return static_cast<int>(2 * kMargin + 2 * kWidth + kGap); }
  [[nodiscard]] static int height_px() { return static_cast<int>(kHeader + kHeading + kHeight + kFoot); }

  bool Paint(vtkContext2D* context) override {
    Canvas canvas(*context);
    canvas.text(kMargin, height_px() - 34, pair_->title, kTitleFont, kInk, Align::kLeft, true);
    double left = kMargin;
    for (const DrawnPanel& panel : pair_->panels) {
      paint(canvas, panel, {left, kFoot});
      left += kWidth + kGap;
    }
    paintKey(canvas);
    return true;
  }

 private:
  static void paint(Canvas& canvas, const DrawnPanel& panel, Canvas::Point corner) {
    const auto moved = [&](Canvas::Point p) { return Canvas::Point{corner.x + p.x, corner.y + p.y}; };
    if (panel.background) canvas.raster(*panel.background, corner, kWidth, kHeight);
    for (const DrawnPanel::Stroke& stroke : panel.strokes) {
      std::vector<Canvas::Point> points;
      for (const Canvas::Point p : stroke.points) points.push_back(moved(p));
      canvas.polyline(points, stroke.colour, stroke.width);
    }
    for (const DrawnPanel::Dot& dot : panel.dots) canvas.disc(moved(dot.at), dot.radius, dot.colour);
    for (const DrawnPanel::Words& words : panel.words) {
      const Canvas::Point at = moved(words.at);
      canvas.text(at.x, at.y, words.text, kSmallFont, kInk, words.align);
    }
    const std::array<Canvas::Point, 5> frame{moved({0, 0}), moved({kWidth, 0}), moved({kWidth, kHeight}),
                                             moved({0, kHeight}), moved({0, 0})};
    canvas.polyline(frame, kFrame, 1);
    const Canvas::Point above = moved({0, kHeight});
    canvas.text(above.x, above.y + 22, panel.heading, kTextFont, kInk, Align::kLeft, true);
    canvas.text(above.x, above.y + 5, panel.verdict, kSmallFont, kInk);
  }

  void paintKey(Canvas& canvas) const {
    constexpr double kMiddle = 18;
    double left = kMargin;
    for (const PairKey& key : pair_->key) {
      if (key.stroke) {
        canvas.line({left, kMiddle}, {left + 14, kMiddle}, key.colour, 2);
      } else {
        canvas.disc({left + 7, kMiddle}, 4, key.colour);
      }
      canvas.text(left + 20, kMiddle - 7, key.meaning, kSmallFont, kInk);
      left += 20 + canvas.textWidth(key.meaning, kSmallFont, false) + 24;
    }
  }

  const PanelPair* pair_ = nullptr;
};

vtkStandardNewMacro(PanelPairPainter);

}  // namespace

Result<void> drawPanelPair(const PanelPair& pair, const std::filesystem::path& png) {
  vtkNew<PanelPairPainter> painter;
  painter->set(pair);
  return drawItem(*painter, PanelPairPainter::width_px(), PanelPairPainter::height_px(), pair.title, png, {});
}

}  // namespace haptics::eval
