#pragma once

#include <QImage>
#include <QWidget>
#include <cstddef>
#include <memory>
#include <optional>

#include "graphics_client/application/plot_panel.h"
#include "graphics_client/application/video_options.h"
#include "graphics_client/session/recorded_session.h"
#include "graphics_client/video/webm_writer.h"
#include "graphics_client/viewer/scene_view.h"

class QLabel;
class vtkImageData;

namespace haptics {

class TimeSlider;

/// Of pictures as VTK has them.
[[nodiscard]] QImage imageOf(vtkImageData* picture);

/// Of an image in the format RGB888.
[[nodiscard]] inline std::span<const std::uint8_t> bytesOf(const QImage& image) {
  return {image.constBits(), static_cast<std::size_t>(image.sizeInBytes())};
}

/// Makes a video of a recording, picture after picture: the scene, under it the curves and the time line as the window
/// has them.
class RecordingVideo {
 public:
  static constexpr int kMinWidth_px = 640, kMinHeight_px = 400;  ///< So that words can be read.

  /// The file is replaced once it is finished. Refused: it cannot be written, or the picture is too small.
  /// @param look  Nothing: all objects are shown.
  [[nodiscard]] static Result<std::unique_ptr<RecordingVideo>> begin(std::shared_ptr<const RecordedSession> session,
                                                                     const VideoOptions& options,
                                                                     const std::optional<CameraRig::Look>& look);

  /// Draws the next picture and writes it. Refused: the file cannot be written on.
  [[nodiscard]] Result<void> drawNext();
  [[nodiscard]] Result<void> finish() { return writer_.finish(); }
  [[nodiscard]] std::size_t drawn() const { return drawn_; }
  /// Of the whole recording.
  [[nodiscard]] std::size_t pictures() const { return pictures_; }

 private:
  std::shared_ptr<const RecordedSession> session_;
  double rate_Hz_;
  QSize size_px_;
  WebmWriter writer_;
  QWidget foot_;  // never on a screen
  PlotPanel* plots_;
  TimeSlider* slider_;
  QLabel* time_;
  SceneView scene_;
  std::size_t drawn_ = 0, pictures_;

  RecordingVideo(std::shared_ptr<const RecordedSession> session, const VideoOptions& options, WebmWriter writer);
};

}  // namespace haptics
