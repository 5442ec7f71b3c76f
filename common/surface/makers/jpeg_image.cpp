#include <turbojpeg.h>

#include <memory>
#include <string>

#include "common/surface/makers/gray_image.h"
#include "common/surface/sampled_field.h"

namespace haptics {
namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using JpegReader = std::unique_ptr<void, Destroy>;

tl::unexpected<Error> damaged(const JpegReader& reader) {
  return refused("", std::string("cannot be read as a JPEG image: ") + tjGetErrorStr2(reader.get()));
}

}  // namespace

Result<GrayImage> readJpeg(std::string_view bytes) {
  const JpegReader reader(tjInitDecompress());
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, sampling = 0, colours = 0;
  if (tjDecompressHeader3(reader.get(), data, bytes.size(), &width, &height, &sampling, &colours) != 0) {
    return damaged(reader);
  }
  GrayImage gray{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
  if (auto ok = checkSides(gray.width, gray.height); !ok) return tl::unexpected(std::move(ok).error());
  std::vector<unsigned char> pixels(std::size_t{gray.width} * gray.height);
  // A few hundred bytes can ask for a million passes over the whole image.
  constexpr int kFlags = TJFLAG_LIMITSCANS | TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT;
  if (tjDecompress2(reader.get(), data, bytes.size(), pixels.data(), width, 0, height, TJPF_GRAY, kFlags) != 0) {
    return damaged(reader);
  }
  gray.pixels.reserve(pixels.size());
  for (const unsigned char pixel : pixels) gray.pixels.push_back(static_cast<float>(pixel) / 255);
  return gray;
}

}  // namespace haptics
