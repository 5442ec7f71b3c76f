#include "graphics_client/viewer/object_labels.h"

#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

#include "graphics_client/viewer/palette.h"

namespace haptics {
namespace {

constexpr double kOpacity = 0.72;
/// Of the plate beyond the text, in font sizes.
constexpr double kPadding = 0.35, kCornerRadius = 0.35;
/// More could not be read.
constexpr std::size_t kMostLabels = 64;

}  // namespace

ObjectLabels::Label::Label(vtkRenderer* renderer) : plate(renderer, palette::kCard, kOpacity) {
  text->GetTextProperty()->SetFontFamilyToArial();
  text->GetTextProperty()->SetColor(palette::kText.red, palette::kText.green, palette::kText.blue);
  text->GetTextProperty()->SetJustificationToCentered();
  text->GetTextProperty()->SetVerticalJustificationToCentered();
  text->SetTextScaleModeToNone();
  renderer->AddActor2D(text);
}

void ObjectLabels::Label::setName(vtkRenderer* renderer, const std::string& newName, double newFont_px) {
  if (newName == name && newFont_px == font_px) return;
  name = newName;
  font_px = newFont_px;
  text->SetInput(name.c_str());
  text->GetTextProperty()->SetFontSize(static_cast<int>(font_px));
  double size[2];
  text->GetSize(renderer, size);
  width_px = std::round(size[0] + 2 * kPadding * font_px);
  height_px = std::round(1.15 * font_px + kPadding * font_px);
}

std::vector<LabelWish> ObjectLabels::wishes(const std::vector<NamedBox>& objects) const {
  const int* size = world_->GetSize();
  vtkMatrix4x4* projection =
      world_->GetActiveCamera()->GetCompositeProjectionTransformMatrix(world_->GetTiledAspectRatio(), -1, 1);
  std::vector<LabelWish> wishes;
  for (std::size_t i = 0; i < std::min(objects.size(), kMostLabels); ++i) {
    std::vector<glm::dvec2> corners;
    for (const Vec3& corner : objects[i].corners) {
      const double point[4] = {corner.x, corner.y, corner.z, 1};
      double clip[4];
      projection->MultiplyPoint(point, clip);
      if (!(clip[3] > 0)) continue;  // behind the camera
      corners.emplace_back((clip[0] / clip[3] + 1) / 2 * size[0], (clip[1] / clip[3] + 1) / 2 * size[1]);
    }
    const Label& label = *labels_[i];
    LabelWish& wish = wishes.emplace_back(LabelWish{.width = label.width_px, .height = label.height_px});
    if (corners.size() < 2) continue;  // stays out of the window's corner: nothing is named there
    std::ranges::sort(corners, {}, &glm::dvec2::y);
    const glm::dvec2 foot = (corners[0] + corners[1]) / 2.0;  // of the edge that is nearest to the eye
    const auto [left, right] = std::ranges::minmax(corners, {}, &glm::dvec2::x);
    wish.x = foot.x;
    wish.y = foot.y;
    wish.named = {left.x, corners[0].y, right.x - left.x, corners.back().y - corners[0].y};
  }
  return wishes;
}

void ObjectLabels::update(const std::vector<NamedBox>& objects, std::span<const PixelBox> taken, double font_px) {
  const std::size_t count = visible_ && objects.size() > 1 ? std::min(objects.size(), kMostLabels) : 0;
  while (labels_.size() < count) labels_.push_back(std::make_unique<Label>(overlay_));
  for (std::size_t i = 0; i < count; ++i) labels_[i]->setName(overlay_, objects[i].name, font_px);
  std::vector<std::optional<PixelBox>> places;
  if (count > 0) places = placeLabels(wishes(objects), taken);
  places.resize(labels_.size());
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    Label& label = *labels_[i];
    label.plate.setVisible(places[i].has_value());
    label.text->SetVisibility(places[i].has_value());
    if (!places[i]) continue;
    label.plate.place(*places[i], kCornerRadius * font_px);
    label.text->SetPosition(places[i]->left + places[i]->width / 2, places[i]->bottom + places[i]->height / 2);
  }
}

}  // namespace haptics
