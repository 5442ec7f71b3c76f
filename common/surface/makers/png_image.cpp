#include <png.h>

#include <string>

#include "common/surface/makers/gray_image.h"
#include "common/surface/sampled_field.h"

namespace haptics {
namespace {

/// libpng's state, which it leaves to its user to free.
struct PngReader {
  png_image image{};

  PngReader() { image.version = PNG_IMAGE_VERSION; }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_image_free(&image); }

  [[nodiscard]] tl::unexpected<Error> damaged() const {
    return refused("", std::string("cannot be read as a PNG image: ") + image.message);
  }
};

template <class Pixel>
bool readInto(PngReader& reader, GrayImage& gray, float white) {
  const png_color black{0, 0, 0};
  std::vector<Pixel> pixels(std::size_t{gray.width} * gray.height);
  if (!png_image_finish_read(&reader.image, &black, pixels.data(), 0, nullptr)) return false;
  gray.pixels.reserve(pixels.size());
  for (const Pixel pixel : pixels) gray.pixels.push_back(static_cast<float>(pixel) / white);
  return true;
}

}  // namespace

Result<GrayImage> readPng(std::string_view bytes) {
  PngReader reader;
  if (!png_image_begin_read_from_memory(&reader.image, bytes.data(), bytes.size())) return reader.damaged();
  if (auto ok = checkSides(reader.image.width, reader.image.height); !ok) {
    return tl::unexpected(std::move(ok).error());
  }
  GrayImage gray{reader.image.width, reader.image.height, {}};
  // libpng holds 16-bit values for linear and 8-bit ones for coded for a display: each is read without a change.
  const bool deep = (reader.image.format & PNG_FORMAT_FLAG_LINEAR) != 0;
  reader.image.format = deep ? PNG_FORMAT_LINEAR_Y : PNG_FORMAT_GRAY;
  const bool read = deep ? readInto<std::uint16_t>(reader, gray, 65535) : readInto<std::uint8_t>(reader, gray, 255);
  if (!read) return reader.damaged();
  return gray;
}

}  // namespace haptics
