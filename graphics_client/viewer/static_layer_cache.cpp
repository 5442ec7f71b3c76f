#include "graphics_client/viewer/static_layer_cache.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkMatrix4x4.h>
#include <vtkOpenGLState.h>
#include <vtkPropCollection.h>
#include <vtkShaderProperty.h>
#include <vtk_glew.h>

#include <algorithm>
#include <utility>

namespace haptics {
namespace {

/// So many frames without a change make a prop a still one. Fewer has what is stroked go in and out, each time for a frame
/// that draws everything; more leaves what was touched last to be drawn for nothing.
constexpr int kStillFrames = 45;

/// When anything of its picture changed last. A shader's replacements do not count as a change of their actor.
vtkMTimeType changedAt(vtkProp* prop) {
  return std::max<vtkMTimeType>(prop->GetRedrawMTime(), prop->GetShaderProperty()->GetShaderMTime());
}

}  // namespace

StaticLayerCache::StaticLayerCache(vtkRenderWindow* window, vtkRenderer* listed, int layer)
    : window_(vtkOpenGLRenderWindow::SafeDownCast(window)), listed_(listed) {
  listed_->DrawOff();
  still_->SetLayer(layer);
  moving_->SetLayer(layer + 1);
  moving_->PreserveDepthBufferOn();
  for (vtkRenderer* renderer : {still_.Get(), moving_.Get()}) {
    renderer->SetActiveCamera(listed_->GetActiveCamera());
    renderer->InteractiveOff();
    window->AddRenderer(renderer);
  }
  still_->AddObserver(vtkCommand::EndEvent, this, &StaticLayerCache::keep);
  moving_->AddObserver(vtkCommand::StartEvent, this, &StaticLayerCache::restore);
}

void StaticLayerCache::sort() {
  const bool sameProps = followProps();
  const Projection now = projection();
  const bool sameView = now == std::exchange(projection_, now);
  isKept_ = isKept_ && sameProps && sameView;
  isToKeep_ = !isKept_ && sameView;  // while the camera moves nothing is worth keeping
  still_->SetDraw(!isKept_);
  drawnAnew_ += isKept_ ? 0 : 1;
}

StaticLayerCache::Projection StaticLayerCache::projection() const {
  Projection projection;
  listed_->GetTiledSize(&projection.size_px[0], &projection.size_px[1]);
  const double* matrix = listed_->GetActiveCamera()
                             ->GetCompositeProjectionTransformMatrix(listed_->GetTiledAspectRatio(), -1, 1)
                             ->GetData();
  std::copy_n(matrix, projection.matrix.size(), projection.matrix.begin());
  return projection;
}

/// Shares the listed props out, in their order. True when the still ones are those of before and none of them changed.
bool StaticLayerCache::followProps() {
  std::map<vtkProp*, Known> known;
  bool someChanged = false, someCame = false;
  const int stillFrames = framesToSettle_ > 0 && --framesToSettle_ == 0 ? 1 : kStillFrames;
  vtkPropCollection* props = listed_->GetViewProps();
  vtkCollectionSimpleIterator at;
  props->InitTraversal(at);
  while (vtkProp* prop = props->GetNextProp(at)) {
    Known& its = known[prop];
    if (const auto before = known_.find(prop); before != known_.end()) its = before->second;
    const vtkMTimeType changed = changedAt(prop);
    const bool stays = changed == std::exchange(its.changed, changed) && !prop->HasTranslucentPolygonalGeometry();
    its.unchangedFrames = stays ? its.unchangedFrames + 1 : 0;
    someChanged |= !stays && std::exchange(its.isStill, false);
    someCame |= !its.isStill && its.unchangedFrames >= stillFrames;
  }
  known_ = std::move(known);
  std::vector<vtkProp*> still;
  vtkPropCollection* moving = moving_->GetViewProps();
  // Collections are written to directly: a renderer that is asked to let a prop go frees what the prop has on the card.
  moving->RemoveAllItems();
  props->InitTraversal(at);
  while (vtkProp* prop = props->GetNextProp(at)) {
    Known& its = known_[prop];
    if (someChanged || someCame) its.isStill |= its.unchangedFrames >= stillFrames;
    if (its.isStill) {
      still.push_back(prop);
    } else {
      moving->AddItem(prop);
    }
  }
  if (!someChanged && still == stillProps_) return true;
  stillProps_ = std::move(still);
  still_->GetViewProps()->RemoveAllItems();
  for (vtkProp* prop : stillProps_) still_->GetViewProps()->AddItem(prop);
  return false;
}

void StaticLayerCache::keep() {
  if (!isToKeep_) return;
  isToKeep_ = false;
  const auto& [width, height] = projection_.size_px;
  int size[2];
  kept_->GetLastSize(size);
  if (size[0] != width || size[1] != height) {
    kept_->SetContext(window_);
    window_->GetState()->PushFramebufferBindings();
    constexpr int kDepthBits = 32;  // as the window's own has them: others cannot be copied
    const bool made = kept_->PopulateFramebuffer(width, height, true, 1, VTK_UNSIGNED_CHAR, true, kDepthBits, 0,
                                                 window_->GetStencilCapable() != 0);
    window_->GetState()->PopFramebufferBindings();
    if (!made) return;
  }
  copy(window_->GetRenderFramebuffer(), kept_);
  isKept_ = true;
}

void StaticLayerCache::restore() {
  if (!still_->GetDraw()) copy(kept_, window_->GetRenderFramebuffer());
}

void StaticLayerCache::copy(vtkOpenGLFramebufferObject* from, vtkOpenGLFramebufferObject* to) {
  const auto& [width, height] = projection_.size_px;
  vtkOpenGLState* state = window_->GetState();
  const vtkOpenGLState::ScopedglEnableDisable scissor(state, GL_SCISSOR_TEST);
  state->vtkglDisable(GL_SCISSOR_TEST);
  state->PushFramebufferBindings();
  from->Bind(vtkOpenGLFramebufferObject::GetReadMode());
  from->ActivateReadBuffer(0);
  to->Bind(vtkOpenGLFramebufferObject::GetDrawMode());
  to->ActivateDrawBuffer(0);
  state->vtkglBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT,
                              GL_NEAREST);
  state->PopFramebufferBindings();
}

}  // namespace haptics
