#include "graphics_client/application/texture_gallery.h"

#include <QAbstractItemView>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QIcon>
#include <QListView>
#include <QPixmap>
#include <QProxyStyle>
#include <QPushButton>
#include <algorithm>
#include <utility>

#include "graphics_client/application/texture_preview.h"

namespace haptics {
namespace {

/// Of a picture, and of an entry with its name.
constexpr int kPicture_px = 64, kEntryWidth_px = 96, kEntryHeight_px = 92;
constexpr int kColumns = 4;

/// Entries: none, each family, and what an object has that is none of these.
int ownEntry() { return static_cast<int>(textureFamilies().size()) + 1; }

/// Some styles lay the list of a combo box over it, as high as all entries in one column.
class ListBelow : public QProxyStyle {
 public:
  int styleHint(StyleHint hint, const QStyleOption* option, const QWidget* widget,
                QStyleHintReturn* more) const override {
    return hint == SH_ComboBox_Popup ? 0 : QProxyStyle::styleHint(hint, option, widget, more);
  }
};

/// What of the view's fields the family names is here.
bool isHere(const FieldFamily& family, const MirrorView& view) {
  SurfaceProperties surface;
  surface.texture.emplace().family = family;
  const auto names = assetsOf(surface);
  return std::ranges::all_of(names, [&](const AssetName& name) { return view.holds(name); });
}

}  // namespace

TextureGallery::TextureGallery(QFormLayout* form, const std::function<void(const TextureFamily*)>& choose,
                               const std::function<void()>& chooseImage)
    : gallery_(new QComboBox) {
  painters_.setMaxThreadCount(1);
  gallery_->setObjectName("texture");
  gallery_->setToolTip("Family of the texture");
  gallery_->setAccessibleName("texture");
  auto* entries = new QListView;
  entries->setViewMode(QListView::IconMode);
  entries->setMovement(QListView::Static);
  entries->setGridSize({kEntryWidth_px, kEntryHeight_px});
  entries->setResizeMode(QListView::Adjust);
  gallery_->setView(entries);
  const int rows = (ownEntry() + kColumns) / kColumns;
  entries->setMinimumSize((2 * kColumns + 1) * kEntryWidth_px / 2, rows * kEntryHeight_px);
  gallery_->setMaxVisibleItems(rows);
  auto* style = new ListBelow;  // by a style sheet it would keep the colours of a theme that is left
  style->setParent(gallery_);
  gallery_->setStyle(style);
  gallery_->setIconSize({kPicture_px, kPicture_px});
  gallery_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  gallery_->addItem("none");
  for (const TextureFamily& family : textureFamilies()) {
    gallery_->addItem(family.name);
    gallery_->setItemData(gallery_->count() - 1, family.tip, Qt::ToolTipRole);
  }
  auto* image = new QPushButton("Image...");
  image->setObjectName("texture image");
  image->setToolTip("A grey picture as a height map: white is highest. It is mapped from a box around the object");
  image->setAccessibleName("texture of an image");
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(gallery_, 1);
  layout->addWidget(image);
  form->addRow(row);
  QObject::connect(image, &QPushButton::clicked, chooseImage);
  QObject::connect(gallery_, QOverload<int>::of(&QComboBox::activated), [this, choose](int entry) {
    if (entry == shown_) return;
    if (entry == ownEntry()) return;
    choose(entry == 0 ? nullptr : &textureFamilies()[static_cast<std::size_t>(entry - 1)]);
  });
}

/// Not before an object is looked at: some take a second of a processor, which the first pictures need.
void TextureGallery::paintFamilies() {
  if (std::exchange(isPainted_, true)) return;
  paint(0, [] { return Result<std::vector<std::uint8_t>>(std::vector<std::uint8_t>(kPicture_px * kPicture_px, 200)); });
  int entry = 0;
  for (const TextureFamily& family : textureFamilies()) {
    paint(++entry, [&family] { return texturePreview(family.make(), kPicture_px); });
  }
}

void TextureGallery::paint(int entry, std::function<Result<std::vector<std::uint8_t>>()> preview) {
  painters_.start([gallery = gallery_, entry, preview = std::move(preview)] {
    const auto shades = preview();
    if (!shades) return;
    const QImage picture =
        QImage(shades->data(), kPicture_px, kPicture_px, kPicture_px, QImage::Format_Grayscale8).copy();
    QMetaObject::invokeMethod(gallery, [gallery, entry, picture] {
      if (entry < gallery->count()) gallery->setItemIcon(entry, QIcon(QPixmap::fromImage(picture)));
    });
  });
}

QString TextureGallery::nameOf(const FieldFamily& family) const {
  if (std::holds_alternative<GrownFamily>(family)) return "grown pattern";
  const auto* mapped = std::get_if<MappedFamily>(&family);
  if (mapped == nullptr) return "layers";
  const auto known = names_.find(mapped->field);
  return known == names_.end() ? "image or pattern" : known->second;
}

bool TextureGallery::isHeld() const { return gallery_->view()->isVisible(); }

void TextureGallery::show(const ObjectRecord& object, const MirrorView& view) {
  paintFamilies();
  const auto& texture = object.material.surface.texture;
  const auto family = texture ? textureFamilyOf(texture->family) : std::nullopt;
  const bool isOwn = texture && !family;
  if (isOwn) {
    showOwn(texture->family, view);
  } else if (gallery_->count() > ownEntry()) {
    gallery_->removeItem(ownEntry());
    own_.reset();
  }
  shown_ = isOwn ? ownEntry() : family ? static_cast<int>(*family) + 1 : 0;
  gallery_->setCurrentIndex(shown_);
}

void TextureGallery::showOwn(const FieldFamily& family, const MirrorView& view) {
  if (gallery_->count() == ownEntry()) gallery_->addItem({});
  gallery_->setItemText(ownEntry(), nameOf(family));
  if (own_ == family || !isHere(family, view)) return;
  own_ = family;
  gallery_->setItemIcon(ownEntry(), {});
  paint(ownEntry(), [family, fields = view.fields] {
    return texturePreview(
        family,
        [&](const ContentHash& hash) {
          const auto field = fields.find(hash);
          return field == fields.end() ? nullptr : field->second;
        },
        kPicture_px);
  });
}

}  // namespace haptics
