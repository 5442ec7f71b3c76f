#include <gtest/gtest.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <cmath>
#include <filesystem>

#include "common/clock/monotonic.h"
#include "common/mesh/generators.h"
#include "graphics_client/viewer/viewer.h"
#include "tests/graphics_client/viewer/fake_mirror.h"

namespace haptics {
namespace {

constexpr int kWidth_px = 800, kHeight_px = 640;

/// Runs the whole viewer offscreen for a moment and reads the picture that it wrote.
struct Picture : testing::Test {
  FakeMirror mirror;
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "viewer_picture_test.png";
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
    const Result<RunSummary> summary = runViewer(
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
};

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

TEST_F(Picture, FollowsAnEmptySceneAndALostLink) {
  draw();
  frames = 0;
  mirror.add("ball", makeSphere(0.05, 12).value(), {}, {});
  mirror.view().link = LinkState::kConnecting;
  draw();
  EXPECT_GT(count(0, 0, 0, 1000), 0);
}

}  // namespace
}  // namespace haptics
