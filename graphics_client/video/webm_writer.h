#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "common/error/error.h"

namespace haptics {

/// A video file: WebM, with VP8, by GStreamer. Frames are encoded on threads of its own.
class WebmWriter {
 public:
  /// Of lines and words on plain ground: some 40 dB, and 1 to 4 Mbit/s at 1280 x 800.
  static constexpr int kQuality = 10;  ///< 0 (best) to 63.

  /// As FILE.part: the file, perhaps of another video, is replaced by finish(). Refused: it cannot be written, or GStreamer or its part for VP8 or WebM is not here.
  /// @param rate_Hz  Of the frames, as the file says it; they may come at other times.
  [[nodiscard]] static Result<WebmWriter> create(const std::filesystem::path& file, int width_px, int height_px,
                                                 double rate_Hz);
  WebmWriter(WebmWriter&&) noexcept;
  WebmWriter& operator=(WebmWriter&&) noexcept;
  /// Without finish() before, nothing of it stays.
  ~WebmWriter();

  /// Waits while several frames are not encoded yet. Refused: the file cannot be written on, or that takes a minute.
  /// @param rgb     Three bytes a pixel, rows from the top, each filled up to a multiple of four bytes.
  /// @param time_s  From the beginning of the video; after that of the frame before.
  [[nodiscard]] Result<void> add(std::span<const std::uint8_t> rgb, double time_s);
  /// Writes the rest, and what seeking needs, and gives the file its name. Refused: likewise.
  [[nodiscard]] Result<void> finish();

 private:
  struct Pipeline;
  std::unique_ptr<Pipeline> pipeline_;
  explicit WebmWriter(std::unique_ptr<Pipeline> pipeline);
};

}  // namespace haptics
