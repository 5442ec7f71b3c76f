#include "graphics_client/viewer/effect_glyphs.h"

#include <vtkNew.h>
#include <vtkPolyData.h>

#include "graphics_client/viewer/effect_lines.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

constexpr float kLine_px = 2;
constexpr double kOpacity = 0.75;

}  // namespace

EffectGlyphs::Slot::Slot(ScenePane& pane) : glyph(pane, vtkNew<vtkPolyData>(), Glyph::Kind::kAbove) {
  glyph.setLineWidth(kLine_px);
  glyph.setOpacity(kOpacity);
}

void EffectGlyphs::update(const MirrorView& view, bool current) {
  std::size_t used = 0;
  for (const SceneVersion::Object& object : view.scene->objects()) {
    if (object->effects.empty()) continue;
    const Pose pose = view.poseOf(*object);
    for (std::size_t i = 0; i < object->effects.size(); ++i) {
      const Effect& effect = object->effects[i];
      if (used == slots_.size()) slots_.push_back(std::make_unique<Slot>(pane_));
      Slot& slot = *slots_[used++];
      if (slot.record != object || slot.number != i) slot.glyph.setShape(segments(effectLines(effect)));
      slot.record = object;
      slot.number = i;
      slot.glyph.show(current ? effectShade(effect.kind) : palette::kFaded,
                      matrixOf(effect.frame == Effect::Frame::kWorld ? Pose{} : pose));
    }
  }
  for (std::size_t i = used; i < slots_.size(); ++i) slots_[i]->glyph.setVisible(false);
}

}  // namespace haptics
