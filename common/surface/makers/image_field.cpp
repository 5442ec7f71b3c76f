#include "common/surface/makers/image_field.h"

#include <algorithm>

#include "common/surface/makers/gray_image.h"

namespace haptics {

Result<SampledField> fieldFromImage(std::string_view bytes) {
  const bool png = bytes.starts_with("\x89PNG"), jpeg = bytes.starts_with("\xff\xd8\xff");
  if (!png && !jpeg) return refused("", "is not an image (PNG or JPEG)");
  auto image = png ? readPng(bytes) : readJpeg(bytes);
  if (!image) return tl::unexpected(std::move(image).error());
  std::vector<float> upwards;
  upwards.reserve(image->pixels.size());
  for (auto row = image->pixels.end(); row != image->pixels.begin(); row -= image->width) {
    upwards.insert(upwards.end(), row - image->width, row);
  }
  return SampledField::make(image->width, image->height, std::move(upwards));
}

}  // namespace haptics
