#pragma once

#include <QComboBox>
#include <QImage>
#include <QThreadPool>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "common/error/error.h"
#include "graphics_client/application/property_rows.h"
#include "graphics_client/application/texture_families.h"

namespace haptics {

/// The texture of an object: each family that there is with its picture, or an image of the user's.
class TextureGallery : public PropertyRow {
 public:
  /// @param choose       Called with the family; null: no texture.
  /// @param chooseImage  The user asks for an image.
  TextureGallery(QFormLayout* form, const std::function<void(const TextureFamily*)>& choose,
                 const std::function<void()>& chooseImage);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  /// The field of this hash was read from this file, by this window.
  void name(const ContentHash& field, const QString& file) { names_[field] = file; }
  [[nodiscard]] bool isHeld() const override;

 private:
  QComboBox* gallery_;
  int shown_ = 0;
  bool isPainted_ = false;                // the families' pictures are, or are on their way
  std::optional<FieldFamily> own_;        // that the last entry is a picture of
  std::map<ContentHash, QString> names_;  // of images
  QThreadPool painters_;                  // waits for them when it goes

  void paintFamilies();
  /// Gives the entry a picture once that is computed.
  void paint(int entry, std::function<Result<std::vector<std::uint8_t>>()> preview);
  [[nodiscard]] QString nameOf(const FieldFamily& family) const;
  void showOwn(const FieldFamily& family, const MirrorView& view);
};

}  // namespace haptics
