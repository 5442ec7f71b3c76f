#include "graphics_client/viewer/friction_legend.h"

#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// In font sizes.
constexpr double kLegendPadding = 0.7, kLegendLine = 1.34, kLegendBar = 0.75, kLegendGap = 0.3;
constexpr double kLegendHeight = 2 * kLegendPadding + 2 * kLegendLine + kLegendBar + kLegendGap;
constexpr double kLegendRadius = 0.5;
constexpr int kSteps = 32;  // of the bar's colours

void setNumber(vtkTextActor* actor, double value) {
  char text[16];
  std::snprintf(text, sizeof text, "%.2f", value);
  actor->SetInput(text);
}

}  // namespace

FrictionLegend::FrictionLegend(vtkRenderer* renderer) : background_(renderer, palette::kCard, palette::kCardOpacity) {
  setUpText(title_, renderer, palette::kText);
  setUpText(least_, renderer, palette::kLabel);
  setUpText(most_, renderer, palette::kLabel);
  for (vtkTextActor* text : {title_.Get(), least_.Get(), most_.Get()}) {
    text->GetTextProperty()->SetVerticalJustificationToTop();
  }
  title_->SetInput("Static friction coefficient");
  most_->GetTextProperty()->SetJustificationToRight();
  bar_->SetMapper(vtkNew<vtkPolyDataMapper2D>());
  renderer->AddActor2D(bar_);
  setVisible(false);
}

void FrictionLegend::setRange(const std::optional<FrictionRange>& range) {
  if (range == range_) return;
  range_ = range;
  if (!range) return;
  setNumber(least_, range->least);
  setNumber(most_, range->most);
}

void FrictionLegend::place(double left_px, double bottom_px, double width_px, double font_px) {
  background_.place({left_px, bottom_px, width_px, std::round(kLegendHeight * font_px)}, kLegendRadius * font_px);
  const double inset = kLegendPadding * font_px,
               bar = std::round(bottom_px + (kLegendPadding + kLegendLine + kLegendGap) * font_px);
  const double left = std::round(left_px + inset), right = std::round(left_px + width_px - inset);
  placeBar({left, bar, right - left, std::round(kLegendBar * font_px)});
  title_->SetPosition(left, std::round(bottom_px + kLegendHeight * font_px - inset));
  least_->SetPosition(left, bar - std::round(kLegendGap * font_px));
  most_->SetPosition(right, bar - std::round(kLegendGap * font_px));
  for (vtkTextActor* text : {title_.Get(), least_.Get(), most_.Get()}) {
    text->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  }
}

void FrictionLegend::placeBar(const PixelBox& box) {
  if (box == barBox_) return;
  barBox_ = box;
  std::vector<Vec3f> points;
  std::vector<TriangleIndices> triangles;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const palette::Shade shade = palette::frictionShade(share);
    for (const double y : {box.bottom, box.bottom + box.height}) {
      points.emplace_back(box.left + share * box.width, y, 0);
      colors->InsertNextTuple3(255 * shade.red, 255 * shade.green, 255 * shade.blue);
    }
    if (i == kSteps) break;
    const auto a = static_cast<std::uint32_t>(2 * i);
    triangles.insert(triangles.end(), {{a, a + 2, a + 1}, {a + 1, a + 2, a + 3}});
  }
  const vtkSmartPointer<vtkPolyData> data = trianglesOf(points, triangles);
  data->GetPointData()->SetScalars(colors);
  static_cast<vtkPolyDataMapper2D*>(bar_->GetMapper())->SetInputData(data);
}

void FrictionLegend::setVisible(bool visible) {
  const bool shown = visible && range_;
  background_.setVisible(shown);
  for (vtkActor2D* actor : std::array<vtkActor2D*, 4>{bar_, title_, least_, most_}) actor->SetVisibility(shown);
}

}  // namespace haptics
