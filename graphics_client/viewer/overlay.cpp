#include "graphics_client/viewer/overlay.h"

#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "graphics_client/viewer/floor.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

constexpr double kRefresh_s = 0.12;
constexpr double kMargin_px = 14;
/// Font size: this share of the window's width or height, within limits (pixels).
constexpr double kFontPerWidth = 1.0 / 85, kFontPerHeight = 1.0 / 68, kSmallestFont_px = 10, kLargestFont_px = 20;
/// Kept free of objects at the left and right, as a share of the width.
constexpr double kSideMargin = 0.04;
constexpr double kScaleBar_m = 0.005;
constexpr double kScaleBarHeight_px = 3;

double fontFor(const RenderWindow& renderWindow) {
  return std::round(
      std::clamp(std::min(renderWindow.width_px() * kFontPerWidth, renderWindow.height_px() * kFontPerHeight),
                 kSmallestFont_px, kLargestFont_px));
}

palette::Shade backgroundShade(Tone tone) { return tone == Tone::kBad ? palette::kBad : palette::kWarning; }

}  // namespace

Overlay::Overlay(RenderWindow& renderWindow, bool showKeys)
    : renderWindow_(renderWindow),
      status_(renderWindow.overlay(), {7.9, 13.0}),
      contact_(renderWindow.overlay(), {6.8, 11.2}),
      legend_(renderWindow.overlay(), {5.2, 15.8}),
      keys_(renderWindow.overlay(), {5.2, 16.0}),
      frictionLegend_(renderWindow.overlay()),
      labels_(renderWindow.overlay(), renderWindow.world().solid),
      bannerBackground_(renderWindow.overlay(), palette::kBad, 0.92),
      scaleBar_(renderWindow.overlay(), palette::kText, 1),
      helpVisible_(showKeys),
      detailsVisible_(!showKeys) {
  keys_.setLines(controlLines());
  setUpText(bannerText_, renderWindow.overlay(), palette::kCard);
  bannerText_->GetTextProperty()->SetJustificationToCentered();
  bannerText_->GetTextProperty()->SetVerticalJustificationToCentered();
  bannerText_->GetTextProperty()->BoldOn();
  for (vtkTextActor* caption : {closeUpCaption_.Get(), scaleCaption_.Get()}) {
    setUpText(caption, renderWindow.overlay(), palette::kText);
    caption->GetTextProperty()->SetVerticalJustificationToTop();
  }
  closeUpCaption_->SetInput("Contact, close up");
  scaleCaption_->SetInput(lengthText(kScaleBar_m).c_str());
  scaleCaption_->GetTextProperty()->SetJustificationToRight();
  scaleCaption_->GetTextProperty()->SetVerticalJustificationToBottom();
  closeUpFrame_->GetProperty()->SetColor(palette::kLabel.red, palette::kLabel.green, palette::kLabel.blue);
  closeUpFrame_->GetProperty()->SetLineWidth(1.5);
  renderWindow.overlay()->AddActor2D(closeUpFrame_);
}

void Overlay::update(const MirrorView& view, const State& state, double time_s) {
  const double font_px = fontFor(renderWindow_);
  if (refreshed_s_ < 0 || time_s - refreshed_s_ >= kRefresh_s) {
    refreshed_s_ = time_s;
    auto status = statusLines(view, state.age_s, state.framesPerSecond, state.coarse, state.pitsFeltAsBumps);
    status_.setLines(detailsVisible_ ? status : withoutDetails(std::move(status)));
    contact_.setLines(contactLines(view));
    setLegend(view, state.gridSpacing_m);
    frictionLegend_.setRange(state.friction);
    placeCards(font_px);
    showBanner(bannerFor(view, state.age_s, state.wasLive, state.stateWasReset), font_px);
    placeCloseUpFrame(state.closeUpMetresPerPixel, font_px);
  }
}

void Overlay::setLegend(const MirrorView& view, double gridSpacing_m) {
  std::vector<LegendRow> rows{{palette::kHip, {"HIP", "where the device is"}},
                              {palette::kIhip, {"IHIP", "where the surface is touched"}},
                              {palette::kForceMiddle, {"Force", "1 cm per newton; red: the limit"}},
                              {palette::kSticking, {"Pin", "friction sticks; orange: slides"}},
                              {palette::kPrimitive, {"Primitive", "polygon, line or vertex touched"}},
                              {palette::kTrail, {"Trail", "contact in the last second"}},
                              {palette::kPointer, {"Pointer", "the mouse, which pulls the hand"}},
                              {palette::kFloorBoldLine, {"Grid", gridSpacing_m > 0 ? lengthText(gridSpacing_m) : "-"}}};
  std::ranges::copy(effectLegend(view), std::back_inserter(rows));
  std::vector<OverlayLine> lines;
  std::vector<palette::Shade> dots;
  for (const LegendRow& row : rows) {
    lines.push_back(row.line);
    dots.push_back(row.dot);
  }
  legend_.setDots(dots);
  legend_.setLines(lines);
}

void Overlay::placeCards(double font_px) {
  const double top = renderWindow_.height_px() - kMargin_px;
  status_.place(kMargin_px, top - status_.height_px(font_px), font_px);
  contact_.place(renderWindow_.width_px() - kMargin_px - contact_.width_px(font_px), top - contact_.height_px(font_px),
                 font_px);
  legend_.place(kMargin_px, kMargin_px, font_px);
  keys_.place(2 * kMargin_px + legend_.width_px(font_px), kMargin_px, font_px);
  frictionLegend_.place(kMargin_px, kMargin_px + legend_.height_px(font_px) + kMargin_px / 2, legend_.width_px(font_px),
                        font_px);
  for (TextPanel* panel : {&status_, &contact_, &legend_}) panel->setVisible(visible_);
  frictionLegend_.setVisible(visible_);
  keys_.setVisible(visible_ && helpVisible_);
}

void Overlay::showBanner(const Banner& banner, double font_px) {
  bannerBackground_.setVisible(!banner.text.empty());
  bannerText_->SetVisibility(!banner.text.empty());
  if (banner.text.empty()) return;
  if (banner != shownBanner_) {
    shownBanner_ = banner;
    bannerText_->SetInput(banner.text.c_str());
    bannerBackground_.setShade(backgroundShade(banner.tone));
  }
  double size[2];
  bannerText_->GetTextProperty()->SetFontSize(static_cast<int>(font_px + 2));
  bannerText_->GetSize(renderWindow_.overlay(), size);
  const double room = renderWindow_.width_px() - 2 * (kMargin_px + font_px);
  if (size[0] > room) {
    bannerText_->GetTextProperty()->SetFontSize(static_cast<int>((font_px + 2) * room / size[0]));
    bannerText_->GetSize(renderWindow_.overlay(), size);
  }
  const double below = std::max(status_.height_px(font_px), contact_.height_px(font_px)) + 2 * kMargin_px;
  const PixelBox box{std::round((renderWindow_.width_px() - size[0]) / 2 - font_px),
                     std::round(renderWindow_.height_px() - below - 2.2 * font_px), size[0] + 2 * font_px,
                     2.2 * font_px};
  bannerBackground_.place(box, 0.6 * font_px);
  bannerText_->SetPosition(box.left + box.width / 2, box.bottom + box.height / 2);
}

void Overlay::placeCloseUpFrame(double metresPerPixel, double font_px) {
  const bool shown = renderWindow_.closeUpShown();
  for (vtkActor2D* actor :
       {static_cast<vtkActor2D*>(closeUpCaption_), static_cast<vtkActor2D*>(scaleCaption_), closeUpFrame_.Get()}) {
    actor->SetVisibility(shown);
  }
  scaleBar_.setVisible(shown);
  if (!shown) return;
  const double left = renderWindow_.closeUpLeft_px(), bottom = renderWindow_.closeUpBottom_px(),
               side = renderWindow_.closeUpSide_px();
  const double right = left + side, top = bottom + side, bar = kScaleBar_m / metresPerPixel;
  const Vec3 frame[] = {{left, bottom, 0}, {right, bottom, 0}, {right, bottom, 0}, {right, top, 0},
                        {right, top, 0},   {left, top, 0},     {left, top, 0},     {left, bottom, 0}};
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(segments(frame));
  closeUpFrame_->SetMapper(mapper);
  const double inset = 0.7 * font_px;
  closeUpCaption_->SetPosition(left + inset, top - inset);
  closeUpCaption_->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  scaleBar_.place({right - inset - bar, bottom + inset, bar, kScaleBarHeight_px}, 0);
  scaleCaption_->SetPosition(right - inset, bottom + inset + 2 * kScaleBarHeight_px);
  scaleCaption_->GetTextProperty()->SetFontSize(static_cast<int>(font_px - 1));
}

std::array<PictureArea, 2> Overlay::freeAreas() {
  const double width = std::max(renderWindow_.width_px(), 1), height = std::max(renderWindow_.height_px(), 1);
  const double font_px = fontFor(renderWindow_);
  const double below = renderWindow_.closeUpSide_px() + kMargin_px;
  const double above = status_.height_px(font_px) + 2 * kMargin_px;
  const double left = std::max(status_.width_px(font_px), legend_.width_px(font_px)) + 2 * kMargin_px;
  const double right = std::max<double>(renderWindow_.closeUpSide_px(), contact_.width_px(font_px)) + 2 * kMargin_px;
  return {{{.left = kSideMargin, .right = 1 - kSideMargin, .bottom = below / height, .top = 1 - above / height},
           {.left = left / width, .right = 1 - right / width, .bottom = kSideMargin, .top = 1 - kSideMargin}}};
}

void Overlay::label(const std::vector<NamedBox>& objects) {
  std::vector<PixelBox> taken;
  if (visible_) {
    taken = {status_.box(), contact_.box(), legend_.box(), frictionLegend_.box()};
    if (helpVisible_) taken.push_back(keys_.box());
  }
  if (renderWindow_.closeUpShown()) {
    const double side = renderWindow_.closeUpSide_px();
    taken.push_back({double(renderWindow_.closeUpLeft_px()), double(renderWindow_.closeUpBottom_px()), side, side});
  }
  labels_.setVisible(visible_ && labelsVisible_);
  labels_.update(objects, taken, fontFor(renderWindow_));
}

void Overlay::toggle() {
  visible_ = !visible_;
  refresh();
}

void Overlay::toggleDetails() {
  detailsVisible_ = !detailsVisible_;
  refresh();
}

std::string Overlay::tipAt(double x_px, double y_px) const {
  const std::string status = status_.labelAt(x_px, y_px);
  return overlayTip(status.empty() ? contact_.labelAt(x_px, y_px) : status);
}

void Overlay::toggleHelp() {
  helpVisible_ = !helpVisible_;
  refresh();
}

}  // namespace haptics
