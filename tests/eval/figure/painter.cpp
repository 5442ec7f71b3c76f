#include "tests/eval/figure/painter.h"

#include <vtkContext2D.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/eval/figure/layout.h"

namespace haptics::eval {
namespace {

using namespace layout;

constexpr Colour kInk{0.13, 0.15, 0.18};
constexpr Colour kSoft{0.38, 0.42, 0.47};
constexpr Colour kGrid{0.87, 0.885, 0.90};
constexpr Colour kFineGrid{0.945, 0.95, 0.957};
constexpr Colour kLimit{0.20, 0.22, 0.26};
constexpr double kMarkerRadius = 6.5, kStrongMarkerRadius = 9;
constexpr double kToBaseline = 11;  // of the small font, down from its middle

/// 0 to 1 within the decades; points beyond on the rim.
double shareOf(double value, Decades decades) {
  const double share = (std::log10(value) - decades.low) / (decades.high - decades.low);
  return std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0);
}

/// 0.01, 1, 100, 10 k, 1 M.
std::string numberText(int decade) {
  if (decade < 0) return "0." + std::string(static_cast<std::size_t>(-decade - 1), '0') + "1";
  constexpr std::array kDigits{"1", "10", "100"};
  constexpr std::array kPrefixes{"", " k", " M", " G"};
  return std::string(kDigits[static_cast<std::size_t>(decade % 3)]) + kPrefixes[static_cast<std::size_t>(decade / 3)];
}

double radiusOf(const Style& style) { return style.strong ? kStrongMarkerRadius : kMarkerRadius; }

struct Place {
  double x, y;
};

Place placeOf(const CurvePoint& point, const Panel& panel, double left, double below) {
  return {left + kPanelWidth * shareOf(point.x, panel.x), below + kPanelHeight * shareOf(point.y, panel.y)};
}

}  // namespace

vtkStandardNewMacro(FigurePainter)

    int FigurePainter::width_px(const Figure& figure) {
  return static_cast<int>(kGap + static_cast<double>(figure.columns) * cellWidth() + kLegend);
}

int FigurePainter::height_px(const Figure& figure) {
  const double rows = std::ceil(static_cast<double>(figure.panels.size()) / static_cast<double>(figure.columns));
  const double legend = kTitle + kLegendTitle + kEntry * static_cast<double>(figure.styles.size()) +
                        kLine * static_cast<double>(figure.legendNotes.size());
  return static_cast<int>(kHeader + kLine * static_cast<double>(figure.caption.size()) +
                          std::max(rows * cellHeight(), legend) + kGap);
}

bool FigurePainter::Paint(vtkContext2D* painter) {
  canvas_.emplace(*painter);
  const double height = height_px(*figure_);
  canvas_->text(2 * kGap, height - kHeader + 14, figure_->title, kTitleFont, kInk, Align::kLeft, true);
  double top = height - kHeader;
  for (const std::string& words : figure_->caption) {
    top -= kLine;
    canvas_->text(2 * kGap, top + 8, words, kTextFont, kSoft);
  }
  for (std::size_t i = 0; i < figure_->panels.size(); ++i) {
    const auto column = static_cast<double>(i % figure_->columns);
    const auto row = static_cast<double>(i / figure_->columns);
    paintPanel(figure_->panels[i],
               {kGap + column * cellWidth() + kLeft, top - row * cellHeight() - kTitle - kPanelHeight});
  }
  paintLegend(kGap + static_cast<double>(figure_->columns) * cellWidth() + kGap, top - kTitle);
  return true;
}

void FigurePainter::marker(double x, double y, const Style& style, Marker marker) {
  constexpr double kDiamond = 1.5;  // of a disc's radius: about as large
  const double r = radiusOf(style);
  switch (marker) {
    case Marker::kDisc:
      return canvas_->disc({x, y}, r, style.colour);
    case Marker::kDiamond:
      return canvas_->diamond({x, y}, kDiamond * r, style.colour);
    case Marker::kCross:
      for (const double s : {-1.0, 1.0}) canvas_->line({x - r, y - s * r}, {x + r, y + s * r}, style.colour, 3.5);
      return;
    case Marker::kNone:
      return;
  }
}

void FigurePainter::paintPanel(const Panel& panel, Box box) {
  canvas_->text(box.left, box.below + kPanelHeight + 10, panel.title, kTextFont, kInk, Align::kLeft, true);
  paintGrid(panel, box);
  for (const bool strong : {false, true}) {
    for (const Curve& curve : panel.curves) {
      if (figure_->styles[curve.style].strong == strong) paintCurve(panel, curve, box);
    }
  }
  if (panel.mark) paintMark(panel, box);
  if (panel.threshold) paintThreshold(panel, box);
  for (const Curve& curve : panel.curves) paintLabels(panel, curve, box);
}

void FigurePainter::paintThreshold(const Panel& panel, Box box) {
  const double right = box.left + kPanelWidth;
  const double y = box.below + kPanelHeight * shareOf(panel.threshold->y, panel.y);
  canvas_->line({box.left, y}, {right, y}, kLimit, 2.5, true);
  constexpr double kMargin = 6, kUnder = 17;
  const Area area = areaOf(panel.threshold->label, right - kMargin, y - kUnder, Align::kRight, false);
  if (area.below < box.below || isCrossed(panel, box, area)) return;
  canvas_->text(right - kMargin, y - kUnder - kToBaseline, panel.threshold->label, kSmallFont, kLimit, Align::kRight);
}

void FigurePainter::paintMark(const Panel& panel, Box box) {
  constexpr double kAside = 15;
  const double x = box.left + kPanelWidth * shareOf(panel.mark->x, panel.x);
  const Colour colour = figure_->styles[panel.mark->style].colour;
  canvas_->line({x, box.below}, {x, box.below + kPanelHeight}, colour, 2.5, true);
  const double half = canvas_->textWidth(panel.mark->label, kSmallFont, false) / 2;
  const double middle = box.below + kPanelHeight - kAside - half;
  for (const double at : {x + kAside, x - kAside}) {
    const Area area{at - kToBaseline, middle - half, at + kToBaseline, middle + half};
    if (area.right > box.left + kPanelWidth || isCrossed(panel, box, area)) continue;
    canvas_->upright(at, middle, panel.mark->label, kSmallFont, colour);
    return;
  }
}

FigurePainter::Area FigurePainter::areaOf(const std::string& words, double x, double y, Align align, bool bold) {
  const double width = canvas_->textWidth(words, kSmallFont, bold);
  const double left = align == Align::kLeft ? x : align == Align::kRight ? x - width : x - width / 2;
  return {left, y - kToBaseline, left + width, y + kToBaseline};
}

bool FigurePainter::isCrossed(const Panel& panel, Box box, const Area& area) const {
  constexpr double kStep = 3;
  constexpr double kClear = 3;  // to a line's middle
  const auto touches = [&](double x, double y, double r) { return area.overlaps({x - r, y - r, x + r, y + r}); };
  if (panel.mark) {
    const double x = box.left + kPanelWidth * shareOf(panel.mark->x, panel.x);
    if (area.left < x + kClear && x - kClear < area.right) return true;
  }
  for (const Curve& curve : panel.curves) {
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      const Place to = placeOf(curve.points[i], panel, box.left, box.below);
      if (touches(to.x, to.y, radiusOf(figure_->styles[curve.style]))) return true;
      if (i == 0) continue;
      const Place from = placeOf(curve.points[i - 1], panel, box.left, box.below);
      const int steps = static_cast<int>(std::hypot(to.x - from.x, to.y - from.y) / kStep) + 1;
      for (int k = 0; k <= steps; ++k) {
        const double part = static_cast<double>(k) / steps;
        if (touches(std::lerp(from.x, to.x, part), std::lerp(from.y, to.y, part), kClear)) return true;
      }
    }
  }
  return false;
}

void FigurePainter::paintGrid(const Panel& panel, Box box) {
  const double right = box.left + kPanelWidth;
  const double above = box.below + kPanelHeight;
  const auto grid = [&](Decades decades, auto draw) {
    for (int d = decades.low; d < decades.high; ++d) {
      for (int k = 2; k < 10; ++k) draw(shareOf(k * std::pow(10, d), decades), kFineGrid, 1.0);
    }
    for (int d = decades.low; d <= decades.high; ++d) draw(shareOf(std::pow(10, d), decades), kGrid, 1.5);
  };
  grid(panel.x, [&](double share, Colour colour, double width) {
    const double x = box.left + share * kPanelWidth;
    canvas_->line({x, box.below}, {x, above}, colour, width);
  });
  grid(panel.y, [&](double share, Colour colour, double width) {
    const double y = box.below + share * kPanelHeight;
    canvas_->line({box.left, y}, {right, y}, colour, width);
  });
  canvas_->line({box.left, box.below}, {right, box.below}, kInk, 2);
  canvas_->line({box.left, box.below}, {box.left, above}, kInk, 2);
  for (int d = panel.x.low; d <= panel.x.high; ++d) {
    const double x = box.left + kPanelWidth * (d - panel.x.low) / (panel.x.high - panel.x.low);
    canvas_->text(x, box.below - 32, numberText(d), kSmallFont, kInk, Align::kCentre);
  }
  for (int d = panel.y.low; d <= panel.y.high; ++d) {
    const double y = box.below + kPanelHeight * (d - panel.y.low) / (panel.y.high - panel.y.low);
    canvas_->text(box.left - 10, y - 11, numberText(d), kSmallFont, kInk, Align::kRight);
  }
  canvas_->text(box.left + kPanelWidth / 2, box.below - 70, panel.xLabel, kTextFont, kInk, Align::kCentre);
  canvas_->upright(box.left - 98, box.below + kPanelHeight / 2, panel.yLabel, kTextFont, kInk);
}

void FigurePainter::paintCurve(const Panel& panel, const Curve& curve, Box box) {
  const Style& style = figure_->styles[curve.style];
  const auto place = [&](const CurvePoint& p) { return placeOf(p, panel, box.left, box.below); };
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    const Place from = place(curve.points[i - 1]);
    const Place to = place(curve.points[i]);
    canvas_->line({from.x, from.y}, {to.x, to.y}, style.colour, style.strong ? 5 : 2.5, style.marker == Marker::kNone);
  }
  for (const CurvePoint& point : curve.points) {
    marker(place(point).x, place(point).y, style, point.marker.value_or(style.marker));
  }
}

/// Left of the marker or right of it; a label that would cover a curve or another label is left out.
void FigurePainter::paintLabels(const Panel& panel, const Curve& curve, Box box) {
  constexpr double kAside = 16;
  const Style& style = figure_->styles[curve.style];
  std::vector<Area> written;
  for (auto point = curve.points.rbegin(); point != curve.points.rend(); ++point) {
    if (point->label.empty()) continue;
    const Place at = placeOf(*point, panel, box.left, box.below);
    for (const Align align : {Align::kRight, Align::kLeft}) {
      const double x = align == Align::kRight ? at.x - kAside : at.x + kAside;
      const Area area = areaOf(point->label, x, at.y, align, style.strong);
      const auto covers = [&](const Area& other) { return area.overlaps(other); };
      if (area.left < box.left || isCrossed(panel, box, area) || std::ranges::any_of(written, covers)) continue;
      canvas_->text(x, at.y - kToBaseline, point->label, kSmallFont, style.colour, align, style.strong);
      written.push_back(area);
      break;
    }
  }
}

void FigurePainter::paintLegend(double left, double top) {
  canvas_->text(left, top - 26, figure_->legendTitle, kTextFont, kInk, Align::kLeft, true);
  double y = top - kLegendTitle;
  for (const Style& style : figure_->styles) {
    canvas_->line({left, y + 8}, {left + 52, y + 8}, style.colour, style.strong ? 5 : 2.5,
                  style.marker == Marker::kNone);
    marker(left + 26, y + 8, style, style.marker);
    canvas_->text(left + 66, y - 4, style.name, kTextFont, kInk, Align::kLeft, style.strong);
    canvas_->text(left + 66, y - 32, style.note, kSmallFont, kSoft);
    y -= kEntry;
  }
  for (const std::string& words : figure_->legendNotes) {
    canvas_->text(left, y, words, kSmallFont, kSoft);
    y -= kLine;
  }
}

}  // namespace haptics::eval
