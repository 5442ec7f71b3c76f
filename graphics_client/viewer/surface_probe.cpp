#include "graphics_client/viewer/surface_probe.h"

#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLState.h>
#include <vtkProp.h>
#include <vtk_glew.h>

#include <cmath>

namespace haptics {
namespace {

/// Half the side of the square of pixels that a normal is the mean of.
constexpr int kReach_px = 4;
constexpr int kSide_px = 2 * kReach_px + 1;
/// Neighbouring pixels that are farther apart than so many widths of a pixel lie on different surfaces, or on one that is
/// seen edge-on.
constexpr double kLargestStep_px = 12;

using Block = std::array<std::optional<Vec3>, static_cast<std::size_t>(kSide_px* kSide_px)>;

const std::optional<Vec3>& at(const Block& block, int x, int y) {
  return block[static_cast<std::size_t>(y) * kSide_px + static_cast<std::size_t>(x)];
}

std::optional<SurfacePoint> surfaceIn(const Block& block, Vec3 eye, double pixel_m) {
  const std::optional<Vec3>& centre = at(block, kReach_px, kReach_px);
  if (!centre) return std::nullopt;
  Vec3 sum(0);
  for (int y = 0; y + 1 < kSide_px; ++y) {
    for (int x = 0; x + 1 < kSide_px; ++x) {
      const auto &here = at(block, x, y), &right = at(block, x + 1, y), &above = at(block, x, y + 1);
      if (!here || !right || !above) continue;
      const Vec3 u = *right - *here, v = *above - *here;
      if (glm::length(u) > kLargestStep_px * pixel_m || glm::length(v) > kLargestStep_px * pixel_m) continue;
      if (glm::distance(*here, *centre) > kSide_px * kLargestStep_px / 2 * pixel_m) continue;
      sum += glm::cross(u, v);
    }
  }
  if (!(glm::length(sum) > 0)) return std::nullopt;
  const Vec3 normal = glm::normalize(sum);
  return SurfacePoint{*centre, glm::dot(normal, eye - *centre) < 0 ? -normal : normal};
}

}  // namespace

/// Drawn as nothing; reads what was drawn before it.
class SurfaceProbe::Reader : public vtkProp {
 public:
  static Reader* New();
  vtkTypeMacro(Reader, vtkProp)

      int RenderOpaqueGeometry(vtkViewport* viewport) override {
    found.reset();
    auto* renderer = vtkRenderer::SafeDownCast(viewport);
    if (!aimed || renderer == nullptr) return 0;
    auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer->GetRenderWindow());
    const int* size = window->GetSize();
    const auto [x, y] = *aimed;
    if (x < kReach_px || y < kReach_px || x + kReach_px >= size[0] || y + kReach_px >= size[1]) return 0;
    std::array<float, static_cast<std::size_t>(kSide_px * kSide_px)> depths{};
    vtkOpenGLState* state = window->GetState();
    state->PushReadFramebufferBinding();
    window->GetRenderFramebuffer()->Bind(vtkOpenGLFramebufferObject::GetReadMode());
    glReadPixels(x - kReach_px, y - kReach_px, kSide_px, kSide_px, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
    state->PopReadFramebufferBinding();

    vtkCamera* camera = renderer->GetActiveCamera();
    vtkNew<vtkMatrix4x4> toWorld;
    vtkMatrix4x4::Invert(camera->GetCompositeProjectionTransformMatrix(renderer->GetTiledAspectRatio(), -1, 1),
                         toWorld);
    Block places;
    for (int row = 0; row < kSide_px; ++row) {
      for (int column = 0; column < kSide_px; ++column) {
        const std::size_t i = static_cast<std::size_t>(row) * kSide_px + static_cast<std::size_t>(column);
        if (!(depths[i] < 1)) continue;
        const double seen[4] = {2 * (x - kReach_px + column + 0.5) / size[0] - 1,
                                2 * (y - kReach_px + row + 0.5) / size[1] - 1, 2.0 * depths[i] - 1, 1};
        double world[4];
        toWorld->MultiplyPoint(seen, world);
        places[i] = Vec3(world[0], world[1], world[2]) / world[3];
      }
    }
    const Vec3 eye(camera->GetPosition()[0], camera->GetPosition()[1], camera->GetPosition()[2]);
    const auto& centre = at(places, kReach_px, kReach_px);
    if (!centre) return 0;
    const double pixel_m =
        2 * glm::distance(eye, *centre) * std::tan(glm::radians(camera->GetViewAngle()) / 2) / size[1];
    found = surfaceIn(places, eye, pixel_m);
    return 0;
  }

  std::optional<Pixel> aimed;
  std::optional<SurfacePoint> found;
};
vtkStandardNewMacro(SurfaceProbe::Reader)

    SurfaceProbe::SurfaceProbe(ScenePane& world)
    : pane_(world), reader_(vtkSmartPointer<Reader>::New()) {
  reader_->PickableOff();
  lookLast();
}

SurfaceProbe::~SurfaceProbe() { pane_.solid->RemoveViewProp(reader_); }

void SurfaceProbe::lookLast() {
  pane_.solid->RemoveViewProp(reader_);
  pane_.solid->AddViewProp(reader_);
}

/// A prop that changes is never among what is kept from frame to frame (static_layer_cache.h).
void SurfaceProbe::aim(std::optional<Pixel> pixel) {
  reader_->aimed = pixel;
  reader_->Modified();
}

std::optional<SurfacePoint> SurfaceProbe::found() const { return reader_->found; }

}  // namespace haptics
