#include "graphics_client/viewer/text_panel.h"

#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// In font sizes.
constexpr double kPadding = 0.7, kCornerRadius = 0.5, kLineSpacing = 1.34, kDotRadius = 0.36, kDotColumn = 1.3;
/// Rows are a little higher than their letters; this much of it belongs above the first row.
constexpr double kDescent = 0.14;
constexpr int kArcPoints = 6;  // of a rounded corner

/// Of the values, by their tone.
constexpr std::array kShades{palette::kText, palette::kGood, palette::kWarning, palette::kBad};

std::vector<Vec3> roundedBox(const PixelBox& box, double radius) {
  std::vector<Vec3> outline;
  const double r = std::min({radius, box.width / 2, box.height / 2});
  const Vec3 centres[] = {{box.left + box.width - r, box.bottom + box.height - r, 0},
                          {box.left + r, box.bottom + box.height - r, 0},
                          {box.left + r, box.bottom + r, 0},
                          {box.left + box.width - r, box.bottom + r, 0}};
  for (int corner = 0; corner < 4; ++corner) {
    for (int i = 0; i <= kArcPoints; ++i) {
      const double angle = std::numbers::pi / 2 * (corner + static_cast<double>(i) / kArcPoints);
      outline.push_back(centres[corner] + Vec3(r * std::cos(angle), r * std::sin(angle), 0));
    }
  }
  return outline;
}

}  // namespace

void setUpText(vtkTextActor* actor, vtkRenderer* renderer, palette::Shade shade) {
  actor->GetTextProperty()->SetFontFamilyToArial();
  actor->GetTextProperty()->SetColor(shade.red, shade.green, shade.blue);
  actor->SetTextScaleModeToNone();
  renderer->AddActor2D(actor);
}

PanelBackground::PanelBackground(vtkRenderer* renderer, palette::Shade shade, double opacity) {
  actor_->SetMapper(vtkNew<vtkPolyDataMapper2D>());
  actor_->GetProperty()->SetOpacity(opacity);
  setShade(shade);
  renderer->AddActor2D(actor_);
}

void PanelBackground::place(const PixelBox& box, double cornerRadius_px) {
  if (box == box_) return;
  box_ = box;
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(polygon(roundedBox(box, cornerRadius_px)));
  actor_->SetMapper(mapper);
}

void PanelBackground::setShade(palette::Shade shade) {
  actor_->GetProperty()->SetColor(shade.red, shade.green, shade.blue);
}

void PanelBackground::setVisible(bool visible) { actor_->SetVisibility(visible); }

TextPanel::TextPanel(vtkRenderer* renderer, Columns columns)
    : renderer_(renderer), columns_(columns), background_(renderer, palette::kCard, palette::kCardOpacity) {
  const auto setUp = [&](vtkTextActor* actor, palette::Shade shade) {
    setUpText(actor, renderer, shade);
    actor->GetTextProperty()->SetVerticalJustificationToTop();
    actor->GetTextProperty()->SetLineSpacing(kLineSpacing);
  };
  setUp(labels_, palette::kLabel);
  for (std::size_t tone = 0; tone < kTones; ++tone) setUp(values_[tone], kShades[tone]);
}

void TextPanel::setDots(const std::vector<palette::Shade>& dots) {
  while (dots_.size() < dots.size())
    dots_.push_back(std::make_unique<PanelBackground>(renderer_, dots[dots_.size()], 1));
  for (std::size_t i = 0; i < dots.size(); ++i) dots_[i]->setShade(dots[i]);
}

void TextPanel::setLines(const std::vector<OverlayLine>& lines) {
  if (lines == lines_) return;
  lines_ = lines;
  std::string labels;
  std::array<std::string, kTones> values;
  for (const OverlayLine& line : lines) {
    const std::string separator = labels.empty() ? "" : "\n";
    labels += separator + line.label;
    for (std::size_t tone = 0; tone < kTones; ++tone) {
      // A space keeps the height of an empty line.
      values[tone] += separator + (static_cast<std::size_t>(line.tone) == tone ? line.value : " ");
    }
  }
  labels_->SetInput(labels.c_str());
  for (std::size_t tone = 0; tone < kTones; ++tone) values_[tone]->SetInput(values[tone].c_str());
}

double TextPanel::width_px(double font_px) const {
  return std::round(font_px * (2 * kPadding + (dots_.empty() ? 0 : kDotColumn) + columns_.label + columns_.value));
}

double TextPanel::height_px(double font_px) {
  return std::round(2 * kPadding * font_px + lineHeight_px(font_px) * static_cast<double>(lines_.size()));
}

double TextPanel::lineHeight_px(double font_px) {
  if (lines_.empty()) return 0;
  labels_->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  double size[2];
  labels_->GetSize(renderer_, size);
  return size[1] / static_cast<double>(lines_.size());
}

void TextPanel::place(double left_px, double bottom_px, double font_px) {
  background_.place({left_px, bottom_px, width_px(font_px), height_px(font_px)}, kCornerRadius * font_px);
  const double top = bottom_px + height_px(font_px) - (kPadding + kDescent) * font_px;
  const double labels = left_px + font_px * (kPadding + (dots_.empty() ? 0 : kDotColumn));
  labels_->SetPosition(std::round(labels), std::round(top));
  labels_->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  for (auto& value : values_) {
    value->SetPosition(std::round(labels + columns_.label * font_px), std::round(top));
    value->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  }
  for (std::size_t i = 0; i < dots_.size(); ++i) {
    const double radius = kDotRadius * font_px;
    const double middle = top - lineHeight_px(font_px) * (static_cast<double>(i) + 0.42);
    dots_[i]->place({left_px + kPadding * font_px, middle - radius, 2 * radius, 2 * radius}, radius);
  }
}

std::string TextPanel::labelAt(double x_px, double y_px) const {
  const PixelBox& at = box();
  const double across = x_px - at.left, down = at.bottom + at.height - y_px;
  if (!visible_ || lines_.empty() || across < 0 || across > at.width || down < 0 || down > at.height) return {};
  const auto line = static_cast<std::size_t>(down / at.height * static_cast<double>(lines_.size()));
  return lines_[std::min(line, lines_.size() - 1)].label;
}

void TextPanel::setVisible(bool visible) {
  visible_ = visible;
  background_.setVisible(visible);
  labels_->SetVisibility(visible);
  for (std::size_t tone = 0; tone < kTones; ++tone) {
    values_[tone]->SetVisibility(visible && std::ranges::any_of(lines_, [&](const OverlayLine& line) {
                                   return static_cast<std::size_t>(line.tone) == tone;
                                 }));
  }
  for (std::size_t i = 0; i < dots_.size(); ++i) dots_[i]->setVisible(visible && i < lines_.size());
}

}  // namespace haptics
