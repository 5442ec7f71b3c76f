#include "graphics_client/application/height_map.h"

#include <QImage>
#include <QImageReader>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace haptics {

Result<std::shared_ptr<const SampledField>> readHeightMap(const QString& file) {
  QImageReader reader(file);
  reader.setDecideFormatFromContent(true);
  const QSize size = reader.size();
  if (!reader.canRead() || !size.isValid()) {
    return refused("", "is no picture, or cannot be read; give a PNG, PGM, JPEG or BMP file");
  }
  if (size.width() > kMaxImageSide_px || size.height() > kMaxImageSide_px) {
    return refused("", "has " + std::to_string(size.width()) + " x " + std::to_string(size.height()) +
                           " pixels; scale it to " + std::to_string(kMaxImageSide_px) + " or fewer along each side");
  }
  const QImage read = reader.read();
  if (read.isNull()) return refused("", "cannot be decoded: " + reader.errorString().toStdString());
  const QImage gray = read.convertToFormat(QImage::Format_Grayscale16);
  constexpr float kWhite = std::numeric_limits<quint16>::max();
  std::vector<float> samples;
  samples.reserve(static_cast<std::size_t>(gray.width()) * static_cast<std::size_t>(gray.height()));
  for (int row = gray.height() - 1; row >= 0; --row) {
    const auto* pixels = reinterpret_cast<const quint16*>(gray.constScanLine(row));
    for (int column = 0; column < gray.width(); ++column)
      samples.push_back(static_cast<float>(pixels[column]) / kWhite);
  }
  auto field = SampledField::make(static_cast<std::uint32_t>(gray.width()), static_cast<std::uint32_t>(gray.height()),
                                  std::move(samples));
  if (!field) return tl::unexpected(std::move(field).error());
  return std::make_shared<const SampledField>(*std::move(field));
}

}  // namespace haptics
