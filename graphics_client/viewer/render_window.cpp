#include "graphics_client/viewer/render_window.h"

#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkLight.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <string>

#include "common/mesh/file_bytes.h"
#include "graphics_client/viewer/palette.h"

namespace haptics {
namespace {

/// Vertical opening of the cameras (degrees): narrow enough that shapes are not distorted, wide enough for depth.
constexpr double kViewAngle_deg = 28;
/// The close-up's side as a share of the window's shorter side, and its distance from the window's edges (pixels).
constexpr double kCloseUpShare = 0.3;
constexpr int kCloseUpMargin_px = 14;

enum Layer { kWorldStill, kWorld, kWorldGhost, kCloseUp, kCloseUpGhost, kOverlay, kLayers };

void addLight(vtkRenderer* renderer, Vec3 from, palette::Shade shade, double intensity, bool withCamera) {
  vtkNew<vtkLight> light;
  light->SetLightType(withCamera ? VTK_LIGHT_TYPE_CAMERA_LIGHT : VTK_LIGHT_TYPE_SCENE_LIGHT);
  light->SetPosition(from.x, from.y, from.z);
  light->SetFocalPoint(0, 0, 0);
  light->SetColor(shade.red, shade.green, shade.blue);
  light->SetIntensity(intensity);
  renderer->AddLight(light);
}

/// Key, fill and rim light: a warm one from above that stays with the world, a cool one at the viewer's shoulder, and
/// one from behind that draws the outlines.
void light(vtkRenderer* renderer) {
  renderer->AutomaticLightCreationOff();
  const Vec3 key = keyLightDirection();
  addLight(renderer, key, {1.0, 0.98, 0.94}, 0.66, false);
  addLight(renderer, {0.5, 0.1, 1.0}, {0.92, 0.96, 1.0}, 0.42, true);
  addLight(renderer, {-key.x, -key.y, 0.35 * key.z}, {0.95, 0.97, 1.0}, 0.22, false);
}

/// VTK 9.1 hands the lights to a shader only when they or the camera are newer than the last hand-over, though that
/// may have been for another pane with another camera: so each camera is made new when its pane is about to be drawn.
void refreshLights(vtkRenderer* renderer) {
  renderer->AddObserver(vtkCommand::StartEvent, renderer->GetActiveCamera(), &vtkCamera::Modified);
}

void setSky(vtkRenderer* renderer) {
  renderer->SetPreserveColorBuffer(false);
  renderer->SetGradientBackground(true);
  renderer->SetBackground(palette::kSkyBottom.red, palette::kSkyBottom.green, palette::kSkyBottom.blue);
  renderer->SetBackground2(palette::kSkyTop.red, palette::kSkyTop.green, palette::kSkyTop.blue);
}

void setUp(ScenePane& pane, vtkRenderWindow* window, int layer) {
  pane.solid->SetLayer(layer);
  setSky(pane.solid);
  pane.solid->GetActiveCamera()->SetViewAngle(kViewAngle_deg);
  pane.ghost->SetLayer(layer + 1);
  pane.ghost->SetActiveCamera(pane.solid->GetActiveCamera());
  for (vtkRenderer* renderer : {pane.solid.Get(), pane.ghost.Get()}) {
    light(renderer);
    refreshLights(renderer);
    renderer->SetInteractive(layer == kWorld && renderer == pane.solid.Get());
    window->AddRenderer(renderer);
  }
}

}  // namespace

Vec3 keyLightDirection() { return glm::normalize(Vec3(-0.55, -0.60, 1.0)); }

RenderWindow::RenderWindow(const ViewerOptions& options) : still_(window_, world_.solid, kWorldStill) {
  window_->SetOffScreenRendering(options.offscreen);
  window_->SetSize(options.width_px, options.height_px);
  window_->SetWindowName("Haptic viewer");
  window_->SetDPI(72);  // font sizes are then pixels
  window_->SetMultiSamples(0);
  window_->SetNumberOfLayers(kLayers);
  setUp(world_, window_, kWorld);
  setSky(still_.still());
  for (vtkRenderer* renderer : {still_.still(), still_.moving()}) {
    light(renderer);
    refreshLights(renderer);
  }
  setUp(closeUp_, window_, kCloseUp);
  overlay_->SetLayer(kOverlay);
  overlay_->SetPreserveDepthBuffer(true);
  overlay_->SetInteractive(false);
  window_->AddRenderer(overlay_);
  placeCloseUp();
}

void RenderWindow::embedIn(unsigned long window) { window_->SetParentInfo(std::to_string(window).c_str()); }

vtkSmartPointer<vtkImageData> RenderWindow::atSize(int width_px, int height_px,
                                                   const std::function<vtkSmartPointer<vtkImageData>()>& draw) {
  const int before[2] = {this->width_px(), this->height_px()};
  const bool offscreen = window_->GetUseOffScreenBuffers();
  window_->SetUseOffScreenBuffers(true);
  resize(width_px, height_px);
  vtkSmartPointer<vtkImageData> picture = draw();
  resize(before[0], before[1]);
  window_->SetUseOffScreenBuffers(offscreen);
  return picture;
}

int RenderWindow::width_px() const { return window_.Get()->GetSize()[0]; }
int RenderWindow::height_px() const { return window_.Get()->GetSize()[1]; }

void RenderWindow::showCloseUp(bool show) {
  closeUpShown_ = show;
  closeUp_.solid->SetDraw(show);
  closeUp_.ghost->SetDraw(show);
}

int RenderWindow::closeUpSide_px() const { return static_cast<int>(kCloseUpShare * std::min(width_px(), height_px())); }
int RenderWindow::closeUpLeft_px() const { return width_px() - kCloseUpMargin_px - closeUpSide_px(); }
int RenderWindow::closeUpBottom_px() const { return kCloseUpMargin_px; }

void RenderWindow::placeCloseUp() {
  const double width = std::max(width_px(), 1), height = std::max(height_px(), 1);
  for (vtkRenderer* renderer : {closeUp_.solid.Get(), closeUp_.ghost.Get()}) {
    renderer->SetViewport(closeUpLeft_px() / width, closeUpBottom_px() / height,
                          (closeUpLeft_px() + closeUpSide_px()) / width,
                          (closeUpBottom_px() + closeUpSide_px()) / height);
  }
}

void RenderWindow::render() {
  placeCloseUp();
  still_.sort();
  window_->Render();
}

void RenderWindow::smoothOutlines(bool on) {
  still_.moving()->SetUseFXAA(on);
  closeUp_.solid->SetUseFXAA(on);
}

bool RenderWindow::drawsInSoftware() {
  const std::string capabilities = window_->ReportCapabilities();
  return capabilities.find("llvmpipe") != std::string::npos || capabilities.find("softpipe") != std::string::npos ||
         capabilities.find("swrast") != std::string::npos;
}

vtkSmartPointer<vtkImageData> RenderWindow::grab() {
  vtkNew<vtkWindowToImageFilter> reader;
  reader->SetInput(window_);
  reader->SetInputBufferTypeToRGB();
  reader->ReadFrontBufferOff();
  reader->ShouldRerenderOff();
  reader->Update();
  vtkNew<vtkImageData> picture;
  picture->DeepCopy(reader->GetOutput());
  return picture;
}

Result<void> writePng(vtkImageData* picture, const std::filesystem::path& file) {
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(picture);
  writer->WriteToMemoryOn();
  writer->SetCompressionLevel(9);
  writer->Write();
  const vtkUnsignedCharArray* bytes = writer->GetResult();
  if (!bytes || bytes->GetNumberOfValues() == 0) return refused(file.string(), "the picture could not be encoded");
  const auto* begin = reinterpret_cast<const char*>(writer->GetResult()->GetPointer(0));
  return writeFile(file, std::string(begin, static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

}  // namespace haptics
