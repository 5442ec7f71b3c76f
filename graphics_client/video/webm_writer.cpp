#include "graphics_client/video/webm_writer.h"

#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "common/process/pending_file.h"
#include "common/text/printable.h"

namespace haptics {
namespace {

using Clock = std::chrono::steady_clock;

/// Frames that wait for the encoder, at most.
constexpr std::size_t kWaiting = 4;
/// Between two looks whether one of them is through.
constexpr GstClockTime kPause_ns = 5 * GST_MSECOND;
/// For one of them, or for what is written at the end.
constexpr std::chrono::seconds kLongest{60};
/// Between frames that can be sought (seconds).
constexpr double kSeekable_s = 1;
/// Bits for a pixel of a frame, beyond which quality is given up.
constexpr double kMaxBits = 0.5;

template <class Object>
struct Unref {
  void operator()(Object* object) const { gst_object_unref(object); }
};
template <class Object>
using Owned = std::unique_ptr<Object, Unref<Object>>;

std::string take(GError* error) {
  std::string words = printable(error->message);
  g_error_free(error);
  return words;
}

tl::unexpected<Error> stalled(const std::string& file) {
  return refused(file, "the encoder or the disk has stood still for " + std::to_string(kLongest.count()) + " s");
}

}  // namespace

struct WebmWriter::Pipeline {
  explicit Pipeline(const std::filesystem::path& video) : file(video.string()), pending(video) {}
  std::string file;  // the video
  PendingFile pending;
  Owned<GstElement> all, in;
  Owned<GstBus> bus;
  GstClockTime frame_ns = 0;  // how long each is shown, as far as is known
  std::size_t frame_bytes = 0;

  ~Pipeline() {
    if (all) gst_element_set_state(all.get(), GST_STATE_NULL);
  }

  /// Waits for a message of that kind or of an error, so long.
  /// @return Whether there was one. Refused: it was an error.
  [[nodiscard]] Result<bool> await(GstMessageType kind, GstClockTime longest_ns) const {
    GstMessage* message =
        gst_bus_timed_pop_filtered(bus.get(), longest_ns, static_cast<GstMessageType>(kind | GST_MESSAGE_ERROR));
    if (message == nullptr) return false;
    GError* error = nullptr;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) gst_message_parse_error(message, &error, nullptr);
    gst_message_unref(message);
    if (error == nullptr) return true;
    return refused(file, take(error));
  }
};

Result<WebmWriter> WebmWriter::create(const std::filesystem::path& file, int width_px, int height_px, double rate_Hz) {
  GError* error = nullptr;
  if (gst_init_check(nullptr, nullptr, &error) == 0) return refused(file.string(), take(error));
  auto pipeline = std::make_unique<Pipeline>(file);
  // BT.601, which players take VP8 to be in.
  pipeline->all.reset(gst_parse_launch_full(
      "appsrc name=in format=time ! videoconvert ! video/x-raw,format=I420,colorimetry=bt601 ! "
      "vp8enc name=encoder deadline=1 cpu-used=4 threads=2 end-usage=cq min-quantizer=2 max-quantizer=50 ! "
      "webmmux ! filesink name=out",
      nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error));
  if (error != nullptr) {
    return refused(file.string(),
                   take(error) + "; videos need the packages gstreamer1.0-plugins-base and gstreamer1.0-plugins-good");
  }
  GstElement* all = pipeline->all.get();
  const auto part = [all](const char* name) { return Owned<GstElement>(gst_bin_get_by_name(GST_BIN(all), name)); };
  pipeline->in = part("in");
  pipeline->bus.reset(gst_element_get_bus(all));
  gint rate = 0, rateBelow = 1;
  gst_util_double_to_fraction(rate_Hz, &rate, &rateBelow);
  GstCaps* caps =
      gst_caps_new_simple("video/x-raw", "format", G_TYPE_STRING, "RGB", "width", G_TYPE_INT, width_px, "height",
                          G_TYPE_INT, height_px, "framerate", GST_TYPE_FRACTION, rate, rateBelow, nullptr);
  g_object_set(pipeline->in.get(), "caps", caps, nullptr);
  gst_caps_unref(caps);
  g_object_set(part("encoder").get(), "cq-level", kQuality, "keyframe-max-dist",
               std::max(1, static_cast<int>(kSeekable_s * rate_Hz)), "target-bitrate",
               static_cast<int>(std::min(kMaxBits * width_px * height_px * rate_Hz, 2e9)), nullptr);
  g_object_set(part("out").get(), "location", pipeline->pending.place().c_str(), nullptr);
  pipeline->frame_ns = static_cast<GstClockTime>(GST_SECOND / rate_Hz);
  pipeline->frame_bytes = static_cast<std::size_t>(GST_ROUND_UP_4(3 * width_px)) * static_cast<std::size_t>(height_px);
  if (gst_element_set_state(all, GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE) {
    const auto why = pipeline->await(GST_MESSAGE_ERROR, 0);
    return why ? refused(file.string(), "the video cannot be begun") : tl::unexpected(why.error());
  }
  return WebmWriter(std::move(pipeline));
}

WebmWriter::WebmWriter(std::unique_ptr<Pipeline> pipeline) : pipeline_(std::move(pipeline)) {}
WebmWriter::WebmWriter(WebmWriter&&) noexcept = default;
WebmWriter& WebmWriter::operator=(WebmWriter&&) noexcept = default;
WebmWriter::~WebmWriter() = default;

Result<void> WebmWriter::add(std::span<const std::uint8_t> rgb, double time_s) {
  if (rgb.size() != pipeline_->frame_bytes) return refused(pipeline_->file, "a frame has another size");
  auto* in = GST_APP_SRC(pipeline_->in.get());
  GstBuffer* buffer = gst_buffer_new_memdup(rgb.data(), rgb.size());
  GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(std::llround(time_s * static_cast<double>(GST_SECOND)));
  GST_BUFFER_DURATION(buffer) = pipeline_->frame_ns;
  gst_app_src_push_buffer(in, buffer);
  GstClockTime pause_ns = 0;
  const auto began = Clock::now();
  do {
    if (Clock::now() - began > kLongest) return stalled(pipeline_->file);
    if (const auto failed = pipeline_->await(GST_MESSAGE_ERROR, pause_ns); !failed)
      return tl::unexpected(failed.error());
    pause_ns = kPause_ns;
  } while (gst_app_src_get_current_level_bytes(in) > kWaiting * rgb.size());
  return {};
}

Result<void> WebmWriter::finish() {
  gst_app_src_end_of_stream(GST_APP_SRC(pipeline_->in.get()));
  const auto ended = pipeline_->await(GST_MESSAGE_EOS, std::chrono::nanoseconds(kLongest).count());
  if (ended && !*ended) return stalled(pipeline_->file);
  gst_element_set_state(pipeline_->all.get(), GST_STATE_NULL);
  if (!ended) return tl::unexpected(ended.error());
  return pipeline_->pending.finish();
}

}  // namespace haptics
