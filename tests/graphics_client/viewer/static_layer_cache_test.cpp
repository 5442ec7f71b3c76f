#include "graphics_client/viewer/static_layer_cache.h"

#include <gtest/gtest.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCubeSource.h>
#include <vtkImageData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>

#include <cstring>

#include "graphics_client/viewer/render_window.h"

namespace haptics::static_layer_cache_test {
namespace {

constexpr int kWidth_px = 320, kHeight_px = 240;

/// A box, a ball that comes out of it, and a third behind both.
struct StillScene {
  RenderWindow renderWindow{[] {
    ViewerOptions options;
    options.width_px = kWidth_px;
    options.height_px = kHeight_px;
    options.offscreen = true;
    return options;
  }()};
  vtkNew<vtkActor> box, ball, behind;

  StillScene() {
    vtkNew<vtkCubeSource> cube;
    vtkNew<vtkSphereSource> sphere;
    add(box, cube->GetOutputPort(), {0.8, 0.3, 0.2});
    add(ball, sphere->GetOutputPort(), {0.2, 0.3, 0.8});
    add(behind, sphere->GetOutputPort(), {0.2, 0.8, 0.3});
    behind->SetPosition(0.8, 1.5, 0);
    vtkCamera* camera = renderWindow.world().solid->GetActiveCamera();
    camera->SetPosition(0, -6, 1);
    camera->SetFocalPoint(0, 0, 0);
    camera->SetViewUp(0, 0, 1);
    camera->SetClippingRange(1, 20);
    renderWindow.showCloseUp(false);
  }

  void add(vtkActor* actor, vtkAlgorithmOutput* port, std::array<double, 3> color) {
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(port);
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(color.data());
    renderWindow.world().solid->AddActor(actor);
  }
  /// Half of the ball comes out of the box, partly in front of it.
  void moveBall(int step) { ball->SetPosition(0.02 * step, -0.4, 0.01 * step); }

  [[nodiscard]] std::string picture() {
    const vtkSmartPointer<vtkImageData> image = renderWindow.grab();
    return {static_cast<const char*>(image->GetScalarPointer()), static_cast<std::size_t>(3 * kWidth_px * kHeight_px)};
  }
};

/// How many numbers of two pictures differ: strings of them would be printed.
int differing(const std::string& a, const std::string& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

constexpr int kLong = 100;  // frames: what does not move is still by then

/// What a stage draws that has never drawn anything.
template <class Arrange>
std::string drawnAnew(const Arrange& arrange) {
  StillScene fresh;
  arrange(fresh);
  fresh.renderWindow.render();
  return fresh.picture();
}

TEST(StaticLayerCache, IsThePictureThatIsDrawnAnewWhileSomethingMoves) {
  StillScene scene;
  for (int step = 0; step < kLong; ++step) {
    scene.moveBall(step);
    scene.renderWindow.render();
  }
  EXPECT_LT(scene.renderWindow.drawnAnew(), 6U) << "of " << kLong;
  EXPECT_EQ(differing(scene.picture(), drawnAnew([](StillScene& fresh) { fresh.moveBall(kLong - 1); })), 0);
}

TEST(StaticLayerCache, FollowsWhatWasStillAndTheCamera) {
  StillScene scene;
  const auto rest = [&] {
    for (int frame = 0; frame < kLong; ++frame) scene.renderWindow.render();
  };
  const auto change = [](StillScene& it) {
    it.box->GetProperty()->SetColor(0.9, 0.9, 0.1);
    it.behind->SetPosition(-0.8, 1.5, 0);
  };
  const auto turn = [](StillScene& it) { it.renderWindow.world().solid->GetActiveCamera()->Azimuth(20); };
  rest();
  change(scene);
  scene.renderWindow.render();
  EXPECT_EQ(differing(scene.picture(), drawnAnew(change)), 0);
  rest();
  turn(scene);
  scene.renderWindow.render();
  const std::string turned = drawnAnew([&](StillScene& fresh) {
    change(fresh);
    turn(fresh);
  });
  EXPECT_EQ(differing(scene.picture(), turned), 0);
  scene.renderWindow.render();  // is kept
  scene.renderWindow.render();  // is what was kept
  EXPECT_EQ(differing(scene.picture(), turned), 0);
  scene.renderWindow.world().solid->RemoveActor(scene.box);
  scene.renderWindow.render();
  EXPECT_GT(differing(scene.picture(), turned), 1000) << "what went is still seen";
}

TEST(StaticLayerCache, WhatChangedBeforeTheCameraCameToRestIsStillAtOnce) {
  StillScene scene;
  for (int frame = 0; frame < kLong; ++frame) {
    scene.renderWindow.world().solid->GetActiveCamera()->Azimuth(1);
    scene.box->SetVisibility(frame % 2 == 1);
    scene.renderWindow.render();
  }
  scene.renderWindow.settle();
  for (int frame = 0; frame < 3; ++frame) scene.renderWindow.render();
  const std::uint64_t drawn = scene.renderWindow.drawnAnew();
  const std::string atRest = scene.picture();
  for (int frame = 0; frame < kLong; ++frame) scene.renderWindow.render();
  EXPECT_EQ(scene.renderWindow.drawnAnew(), drawn);
  EXPECT_EQ(differing(scene.picture(), atRest), 0);
}

}  // namespace
}  // namespace haptics::static_layer_cache_test
