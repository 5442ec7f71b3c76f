#include "graphics_client/viewer/overlay.h"

#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

#include "graphics_client/viewer/controls.h"
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

double fontFor(const Stage& stage) {
  return std::round(std::clamp(std::min(stage.width_px() * kFontPerWidth, stage.height_px() * kFontPerHeight),
                               kSmallestFont_px, kLargestFont_px));
}

void setUpText(vtkTextActor* actor, vtkRenderer* renderer, palette::Shade shade) {
  actor->GetTextProperty()->SetFontFamilyToArial();
  actor->GetTextProperty()->SetColor(shade.red, shade.green, shade.blue);
  actor->SetTextScaleModeToNone();
  renderer->AddActor2D(actor);
}

palette::Shade plateShade(Tone tone) { return tone == Tone::kBad ? palette::kBad : palette::kWarning; }

}  // namespace

Overlay::Overlay(Stage& stage, bool showKeys)
    : stage_(stage),
      status_(stage.overlay(), {7.9, 13.0}),
      contact_(stage.overlay(), {6.8, 11.2}),
      legend_(stage.overlay(), {5.2, 15.2}),
      keys_(stage.overlay(), {4.0, 12.5}),
      frictionLegend_(stage.overlay()),
      labels_(stage.overlay(), stage.world().solid),
      bannerPlate_(stage.overlay(), palette::kBad, 0.92),
      scaleBar_(stage.overlay(), palette::kText, 1),
      helpVisible_(showKeys) {
  legend_.setDots({palette::kHip, palette::kIhip, palette::kForceMiddle, palette::kSticking, palette::kPrimitive,
                   palette::kTrail, palette::kFloorBoldLine});
  std::vector<OverlayLine> keys;
  for (const KeyHelp& key : Controls::help()) keys.push_back({key.key, key.does});
  keys_.setLines(keys);
  setUpText(bannerText_, stage.overlay(), palette::kCard);
  bannerText_->GetTextProperty()->SetJustificationToCentered();
  bannerText_->GetTextProperty()->SetVerticalJustificationToCentered();
  bannerText_->GetTextProperty()->BoldOn();
  for (vtkTextActor* caption : {closeUpCaption_.Get(), scaleCaption_.Get()}) {
    setUpText(caption, stage.overlay(), palette::kText);
    caption->GetTextProperty()->SetVerticalJustificationToTop();
  }
  closeUpCaption_->SetInput("Contact, close up");
  scaleCaption_->SetInput(lengthText(kScaleBar_m).c_str());
  scaleCaption_->GetTextProperty()->SetJustificationToRight();
  scaleCaption_->GetTextProperty()->SetVerticalJustificationToBottom();
  closeUpFrame_->GetProperty()->SetColor(palette::kLabel.red, palette::kLabel.green, palette::kLabel.blue);
  closeUpFrame_->GetProperty()->SetLineWidth(1.5);
  stage.overlay()->AddActor2D(closeUpFrame_);
}

void Overlay::update(const MirrorView& view, const State& state, double time_s) {
  const double font_px = fontFor(stage_);
  if (refreshed_s_ < 0 || time_s - refreshed_s_ >= kRefresh_s) {
    refreshed_s_ = time_s;
    status_.setLines(statusLines(view, state.age_s, state.framesPerSecond, state.coarse, state.pitsFeltAsBumps));
    contact_.setLines(contactLines(view));
    setLegend(state.gridSpacing_m);
    frictionLegend_.setRange(state.friction);
    placeCards(font_px);
    showBanner(bannerFor(view, state.age_s, state.wasLive, state.stateWasReset), font_px);
    placeCloseUpFrame(state.closeUpMetresPerPixel, font_px);
  }
}

void Overlay::setLegend(double gridSpacing_m) {
  legend_.setLines({{"HIP", "where the device is"},
                    {"IHIP", "where the surface is touched"},
                    {"Force", "on the hand, 1 cm per newton"},
                    {"Pin", "friction sticks; orange: slides"},
                    {"Primitive", "polygon, line or vertex touched"},
                    {"Trail", "contact in the last second"},
                    {"Grid", gridSpacing_m > 0 ? lengthText(gridSpacing_m) : "-"}});
}

void Overlay::placeCards(double font_px) {
  const double top = stage_.height_px() - kMargin_px;
  status_.place(kMargin_px, top - status_.height_px(font_px), font_px);
  contact_.place(stage_.width_px() - kMargin_px - contact_.width_px(font_px), top - contact_.height_px(font_px),
                 font_px);
  legend_.place(kMargin_px, kMargin_px, font_px);
  keys_.place(2 * kMargin_px + legend_.width_px(font_px), kMargin_px, font_px);
  frictionLegend_.place(kMargin_px, kMargin_px + legend_.height_px(font_px) + kMargin_px / 2, legend_.width_px(font_px),
                        font_px);
  for (Card* card : {&status_, &contact_, &legend_}) card->setVisible(visible_);
  frictionLegend_.setVisible(visible_);
  keys_.setVisible(visible_ && helpVisible_);
}

void Overlay::showBanner(const Banner& banner, double font_px) {
  bannerPlate_.setVisible(!banner.text.empty());
  bannerText_->SetVisibility(!banner.text.empty());
  if (banner.text.empty()) return;
  if (banner != shownBanner_) {
    shownBanner_ = banner;
    bannerText_->SetInput(banner.text.c_str());
    bannerPlate_.setShade(plateShade(banner.tone));
  }
  double size[2];
  bannerText_->GetTextProperty()->SetFontSize(static_cast<int>(font_px + 2));
  bannerText_->GetSize(stage_.overlay(), size);
  const double room = stage_.width_px() - 2 * (kMargin_px + font_px);
  if (size[0] > room) {
    bannerText_->GetTextProperty()->SetFontSize(static_cast<int>((font_px + 2) * room / size[0]));
    bannerText_->GetSize(stage_.overlay(), size);
  }
  const double below = std::max(status_.height_px(font_px), contact_.height_px(font_px)) + 2 * kMargin_px;
  const PixelBox box{std::round((stage_.width_px() - size[0]) / 2 - font_px),
                     std::round(stage_.height_px() - below - 2.2 * font_px), size[0] + 2 * font_px, 2.2 * font_px};
  bannerPlate_.place(box, 0.6 * font_px);
  bannerText_->SetPosition(box.left + box.width / 2, box.bottom + box.height / 2);
}

void Overlay::placeCloseUpFrame(double metresPerPixel, double font_px) {
  const bool shown = stage_.closeUpShown();
  for (vtkActor2D* actor :
       {static_cast<vtkActor2D*>(closeUpCaption_), static_cast<vtkActor2D*>(scaleCaption_), closeUpFrame_.Get()}) {
    actor->SetVisibility(shown);
  }
  scaleBar_.setVisible(shown);
  if (!shown) return;
  const double left = stage_.closeUpLeft_px(), bottom = stage_.closeUpBottom_px(), side = stage_.closeUpSide_px();
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
  const double width = std::max(stage_.width_px(), 1), height = std::max(stage_.height_px(), 1);
  const double font_px = fontFor(stage_);
  const double below = stage_.closeUpSide_px() + kMargin_px;
  const double above = status_.height_px(font_px) + 2 * kMargin_px;
  const double left = std::max(status_.width_px(font_px), legend_.width_px(font_px)) + 2 * kMargin_px;
  const double right = std::max<double>(stage_.closeUpSide_px(), contact_.width_px(font_px)) + 2 * kMargin_px;
  return {{{.left = kSideMargin, .right = 1 - kSideMargin, .bottom = below / height, .top = 1 - above / height},
           {.left = left / width, .right = 1 - right / width, .bottom = kSideMargin, .top = 1 - kSideMargin}}};
}

void Overlay::label(const std::vector<NamedBox>& objects) {
  std::vector<PixelBox> taken;
  if (visible_) {
    taken = {status_.box(), contact_.box(), legend_.box(), frictionLegend_.box()};
    if (helpVisible_) taken.push_back(keys_.box());
  }
  if (stage_.closeUpShown()) {
    const double side = stage_.closeUpSide_px();
    taken.push_back({double(stage_.closeUpLeft_px()), double(stage_.closeUpBottom_px()), side, side});
  }
  labels_.setVisible(visible_ && labelsVisible_);
  labels_.update(objects, taken, fontFor(stage_));
}

void Overlay::toggle() {
  visible_ = !visible_;
  refresh();
}

void Overlay::toggleLabels() { labelsVisible_ = !labelsVisible_; }

void Overlay::toggleHelp() {
  helpVisible_ = !helpVisible_;
  refresh();
}

}  // namespace haptics
