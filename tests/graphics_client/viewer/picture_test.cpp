#include <gtest/gtest.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <cmath>
#include <filesystem>

#include "common/clock/monotonic.h"
#include "common/mesh/generators.h"
#include "graphics_client/viewer/palette.h"
#include "graphics_client/viewer/scene_view.h"
#include "graphics_client/viewer/viewer.h"
#include "tests/common/temporary_folder.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics::picture_test {
namespace {

constexpr int kWidth_px = 800, kHeight_px = 640;

/// Runs the whole viewer offscreen for a moment and reads the picture that it wrote.
struct Picture : testing::Test {
  FakeMirror mirror;
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "picture.png";
  vtkNew<vtkPNGReader> reader;
  std::uint64_t frames = 0;

  void draw() {
    ViewerOptions options;
    options.width_px = kWidth_px;
    options.height_px = kHeight_px;
    options.offscreen = true;
    options.screenshot = file;
    constexpr std::uint64_t kFrames = 5;
    std::atomic<bool> stop{false};
    const Result<RunSummary> summary = runOffscreen(
        options,
        [&] {
          mirror.view().takenAt_ns = monotonicNow_ns();
          stop = ++frames == kFrames;
          return mirror.now();
        },
        stop);
    ASSERT_TRUE(summary) << summary.error().text();
    EXPECT_EQ(summary->frames(), kFrames);
    reader->SetFileName(file.c_str());
    reader->Modified();  // the file is another one, under the same name
    reader->Update();
    std::filesystem::remove(file);
  }

  /// Pixels in the middle of the picture, where no card is, whose colour is near the one given (0 to 255).
  [[nodiscard]] int count(double red, double green, double blue, double tolerance) {
    vtkImageData* image = reader->GetOutput();
    int found = 0;
    for (int y = kHeight_px / 3; y < kHeight_px * 9 / 10; ++y) {
      for (int x = kWidth_px / 4; x < kWidth_px * 2 / 3; ++x) {
        const double d[] = {image->GetScalarComponentAsDouble(x, y, 0, 0) - red,
                            image->GetScalarComponentAsDouble(x, y, 0, 1) - green,
                            image->GetScalarComponentAsDouble(x, y, 0, 2) - blue};
        found += std::hypot(d[0], d[1], d[2]) < tolerance;
      }
    }
    return found;
  }

  /// How many neighbours in the middle of the picture differ a little in their red: nothing on facets and flat walls.
  [[nodiscard]] int slopes() {
    vtkImageData* image = reader->GetOutput();
    int found = 0;
    for (int y = kHeight_px / 3; y < kHeight_px * 9 / 10; ++y) {
      for (int x = kWidth_px / 4; x < kWidth_px * 2 / 3; ++x) {
        const double step =
            image->GetScalarComponentAsDouble(x + 1, y, 0, 0) - image->GetScalarComponentAsDouble(x, y, 0, 0);
        found += step != 0;
      }
    }
    return found;
  }

  /// A stylus off the picture, so that what is shown is current.
  void hover() {
    TelemetrySample sample;
    sample.hip = sample.ihip = {0.5, 0, 0};
    mirror.view().sample = sample;
  }
};

TEST(SceneView, DrawsACoarseCopyWhileTheCameraMovesAndTheWholeMeshSoonAfter) {
  FakeMirror mirror;
  mirror.add("ball", makeSphere(0.05, 100).value(), {}, {.red = 0.5F, .green = 0.5F, .blue = 0.5F});
  ViewerOptions options;
  options.offscreen = true;
  options.width_px = options.height_px = 300;
  SceneView scene(options);
  double now_s = 0;
  const auto drawAfter = [&](double wait_s) { scene.drawFrame(mirror.now(), now_s += wait_s); };
  do {
    drawAfter(0.02);
  } while (scene.objects().isSettling() || scene.isMoving());
  EXPECT_FALSE(scene.objects().isCoarse());
  for (int frame = 0; frame < 5; ++frame) {
    scene.cameras().orbit(3, 0);
    drawAfter(0.02);
    EXPECT_TRUE(scene.objects().isCoarse());
  }
  static_cast<void>(scene.picture(scene.snapshot(), 0));
  EXPECT_FALSE(scene.objects().isCoarse()) << "a picture that is saved has all";
  scene.cameras().orbit(3, 0);
  drawAfter(0.02);
  drawAfter(0.2);
  EXPECT_FALSE(scene.objects().isCoarse());
  EXPECT_FALSE(scene.isMoving());
}

TEST(Display, AnswersHere) { EXPECT_TRUE(checkDisplay()) << checkDisplay().error().text(); }

TEST_F(Picture, HasTheSizeAskedForAndShowsTheObjectInItsColor) {
  mirror.add("ball", makeSphere(0.05, 12).value(), {}, {.red = 0.0F, .green = 0.0F, .blue = 1.0F});
  draw();
  EXPECT_EQ(reader->GetOutput()->GetDimensions()[0], kWidth_px);
  EXPECT_EQ(reader->GetOutput()->GetDimensions()[1], kHeight_px);
  EXPECT_GT(count(30, 30, 180, 100), 500);
}

TEST_F(Picture, ShowsTheHipThroughTheObject) {
  const ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 4).value(), {}, {});
  draw();
  const int withoutContact = count(200, 90, 100, 60);
  frames = 0;
  for (std::uint32_t polygon = 0;; ++polygon) {  // one on the upper side, in its middle
    mirror.touch(box, polygon, 0.004);
    const TelemetrySample& sample = *mirror.view().sample;
    if (sample.surfaceNormal.z > 0.9 && std::hypot(sample.ihip.x, sample.ihip.y) < 0.02) break;
  }
  mirror.view().sample->primitive = {};  // it would tint the HIP
  draw();
  EXPECT_EQ(withoutContact, 0);
  EXPECT_GT(count(200, 90, 100, 60), 10);
}

TEST_F(Picture, ShowsEffectsThroughTheObjectUntilTheyAreTakenAway) {
  const ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 4).value(), {}, {});
  mirror.setEffects(box, {{.kind = Effect::Kind::kViscosity,
                           .damping_Ns_per_m = 1,
                           .region = Effect::Region::kSphere,
                           .size_m = Vec3(0.08, 0, 0)}});
  hover();
  draw();
  const auto [red, green, blue] = palette::bytes(palette::kDrags);
  EXPECT_GT(count(red, green, blue, 70), 100);
  mirror.setEffects(box, {});
  frames = 0;
  draw();
  EXPECT_EQ(count(red, green, blue, 70), 0);
}

TEST_F(Picture, HasRoomForTheForceAboveATallObject) {
  const ObjectId bar = mirror.add("bar", makeBox({0.04, 0.04, 0.16}, 2).value(), {}, {});
  const auto inTopRows = [&](double red, double green, double blue) {
    int found = 0;
    for (int y = kHeight_px - 3; y < kHeight_px; ++y) {
      for (int x = kWidth_px / 4; x < kWidth_px * 2 / 3; ++x) {
        const auto* pixel = static_cast<const unsigned char*>(reader->GetOutput()->GetScalarPointer(x, y, 0));
        found += std::hypot(pixel[0] - red, pixel[1] - green, pixel[2] - blue) < 60;
      }
    }
    return found;
  };
  for (std::uint32_t polygon = 0;; ++polygon) {  // one on the upper side
    mirror.touch(bar, polygon, 0.004);
    if (mirror.view().sample->surfaceNormal.z > 0.9) break;
  }
  mirror.view().sample->force.written = {0, 0, mirror.view().maxForce_N};
  draw();
  EXPECT_GT(count(160, 20, 20, 90), 20) << "the arrow is there";
  const vtkImageData* image = reader->GetOutput();
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(inTopRows(120, 15, 15), 0) << "and ends below the border";
}

TEST_F(Picture, ShowsASmoothBallWhereItIsFeltShadedAndFacetsWhereNot) {
  hover();
  const ObjectId ball = mirror.add("ball", makeSphere(0.05, 6).value(), {}, {});
  draw();
  const int faceted = slopes();
  frames = 0;
  SurfaceProperties surface;
  surface.shading = Shading{.crease_rad = 1, .creases = {}};
  mirror.setSurface(ball, surface);
  draw();
  EXPECT_GT(slopes(), 2 * faceted);
}

TEST_F(Picture, ShowsTheTextureOfAPlainBox) {
  hover();
  const ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 1).value(), {}, {});
  draw();
  const int plain = slopes();
  frames = 0;
  SurfaceProperties surface;
  surface.texture = Texture{.family = NoiseFamily{.wavelength_m = 0.01}, .amplitude_m = 0.0003};
  mirror.setSurface(box, surface);
  draw();
  EXPECT_GT(slopes(), 5 * plain);
}

TEST_F(Picture, ColorsASurfaceWhoseFrictionVariesByItsFriction) {
  hover();
  const ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 1).value(), {}, {.red = 0, .green = 0, .blue = 1});
  SurfaceProperties surface;
  surface.friction = Friction{
      .mu_static = 0.5, .mu_dynamic = 0.4, .variation = 1, .over = FieldFamily(NoiseFamily{.wavelength_m = 0.03})};
  mirror.setSurface(box, surface);
  draw();
  EXPECT_EQ(count(30, 30, 180, 100), 0);
  EXPECT_GT(count(200, 160, 100, 60), 500);
}

TEST_F(Picture, PinsTheStickingPoint) {
  const ObjectId box = mirror.add("box", makeBox({0.1, 0.1, 0.1}, 4).value(), {}, {});
  mirror.touch(box, 3, 0.001);
  TelemetrySample& sample = *mirror.view().sample;
  sample.ihip = sample.hip = {0, 0, 0.05};
  sample.surfaceNormal = {0, 0, 1};
  sample.primitive = {};
  draw();
  const auto violet = [&] {
    return count(255 * palette::kSticking.red, 255 * palette::kSticking.green, 255 * palette::kSticking.blue, 40);
  };
  EXPECT_EQ(violet(), 0);
  frames = 0;
  sample.frictionState = FrictionState::kSticking;
  sample.stickingPoint = {0.01, 0, 0.05};
  draw();
  EXPECT_GT(violet(), 10);
}

TEST_F(Picture, FollowsAnEmptySceneAndALostLink) {
  draw();
  frames = 0;
  mirror.add("ball", makeSphere(0.05, 12).value(), {}, {});
  mirror.view().link = LinkState::kConnecting;
  draw();
  EXPECT_GT(count(0, 0, 0, 1000), 0);
}

}  // namespace
}  // namespace haptics::picture_test
