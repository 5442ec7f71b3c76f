#include <utility>

#include "graphics_client/video/webm_writer.h"

namespace haptics {

struct WebmWriter::Pipeline {};

Result<WebmWriter> WebmWriter::create(const std::filesystem::path& file, int /*width_px*/, int /*height_px*/,
                                      double /*rate_Hz*/) {
  return refused(file.string(), "this program was built without GStreamer, which writes videos");
}

WebmWriter::WebmWriter(std::unique_ptr<Pipeline> pipeline) : pipeline_(std::move(pipeline)) {}
WebmWriter::WebmWriter(WebmWriter&&) noexcept = default;
WebmWriter& WebmWriter::operator=(WebmWriter&&) noexcept = default;
WebmWriter::~WebmWriter() = default;
Result<void> WebmWriter::add(std::span<const std::uint8_t> /*rgb*/, double /*time_s*/) { return {}; }
Result<void> WebmWriter::finish() { return {}; }

}  // namespace haptics
