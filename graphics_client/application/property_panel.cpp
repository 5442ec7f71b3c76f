#include "graphics_client/application/property_panel.h"

#include <QAbstractButton>
#include <QAbstractSpinBox>
#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QKeyEvent>
#include <QLabel>
#include <QRegularExpression>
#include <QScrollArea>
#include <QSlider>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "common/mesh/import.h"
#include "graphics_client/application/effect_rows.h"
#include "graphics_client/application/height_map.h"
#include "graphics_client/application/printable_text.h"
#include "graphics_client/application/texture_gallery.h"
#include "graphics_client/application/theme.h"
#include "graphics_client/surface/mesh_normals.h"

namespace haptics {
namespace {

constexpr int kAnswerLines = 5;

QString titleOf(const SceneVersion::Object& object, std::size_t others, const MirrorView* view) {
  if (!object) return "Nothing is selected: click an object.";
  const bool isReplay = view != nullptr && view->isReplay, mayEdit = view != nullptr && view->mayEdit;
  const QString and_others = others == 0 ? QString() : QString(" and %1 more, changed together").arg(others);
  return text(object->name) + and_others +
         (isReplay  ? " (a replay cannot be edited)"
          : mayEdit ? ""
                    : " (this connection may look, not edit)");
}

/// Those that stay where they are and are closed stop what moves.
void addOthersMeet(const MirrorView& view, const std::set<std::string>& moving, v1::Transaction& transaction) {
  for (const SceneVersion::Object& other : view.scene->objects()) {
    const auto mesh = view.meshes.find(other->mesh);
    if (moving.contains(other->name) || other->motion || mesh == view.meshes.end() || !isClosed(*mesh->second))
      continue;
    v1::Operation& operation = *transaction.add_operations();
    setMeetsOthers(*other, true, operation);
    setObject(operation, other->name);
  }
}

Surroundings surroundingsOf(const ObjectRecord& object, const MirrorView& view, double floor_m) {
  const auto mesh = view.meshes.find(object.mesh);
  return {floor_m, mesh == view.meshes.end() ? ObjectBox{} : boxOf(*mesh->second), view.poseOf(object)};
}

/// Of those of the objects that it can be set of. Refused: of none.
Composer composerOf(const std::set<std::string>& names, const SetProperty& set, bool othersMeet, double floor_m) {
  return [names, set, othersMeet, floor_m](const MirrorView& view) -> Result<v1::Transaction> {
    v1::Transaction transaction;
    Result<void> last;
    for (const std::string& name : names) {
      const auto object = view.scene->find(name);
      v1::Operation operation;
      last = object ? set(*object, surroundingsOf(*object, view, floor_m), operation)
                    : refused("object \"" + name + "\"", "is not there any more");
      if (!last) continue;
      setObject(operation, name);
      *transaction.add_operations() = std::move(operation);
    }
    if (transaction.operations().empty()) return tl::unexpected(std::move(last).error());
    if (othersMeet) addOthersMeet(view, names, transaction);
    return transaction;
  };
}

}  // namespace

PropertyPanel::PropertyPanel()
    : title_(new QLabel),
      advice_(new QLabel),
      answer_(new QLabel),
      rowsOf_(new QWidget),
      scroll_(new QScrollArea),
      handlesOfJoint_(new QCheckBox("handles at the joint")) {
  setObjectName("properties");
  form_ = new QFormLayout(rowsOf_);
  form_->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  addIdentity();
  for (const PropertyGroup& group : propertyGroups()) addRows(group);
  handlesOfJoint_->setObjectName("handles at the joint");
  handlesOfJoint_->setAccessibleName("handles at the joint");
  handlesOfJoint_->setToolTip(
      "While handles are on (g), they move the joint's anchor and turn its axis, not the object");
  form_->addRow(handlesOfJoint_);
  addEffects();
  followEventsOf(rowsOf_);
  auto fields = rowsOf_->findChildren<QDoubleSpinBox*>();
  const auto isSize = [](const QDoubleSpinBox* field) { return field->maximumWidth() == QWIDGETSIZE_MAX; };
  fields.erase(std::remove_if(fields.begin(), fields.end(), isSize), fields.end());
  const auto byWidth = [](const auto* a, const auto* b) { return a->maximumWidth() < b->maximumWidth(); };
  fieldWidth_px_ = (*std::ranges::max_element(fields, byWidth))->maximumWidth();
  for (QDoubleSpinBox* field : fields) field->setFixedWidth(fieldWidth_px_);
  scroll_->setWidget(rowsOf_);
  scroll_->setWidgetResizable(true);
  scroll_->setFrameShape(QFrame::NoFrame);
  QSizePolicy policy = scroll_->sizePolicy();
  policy.setRetainSizeWhenHidden(true);
  scroll_->setSizePolicy(policy);
  title_->setTextFormat(Qt::PlainText);
  title_->setWordWrap(true);
  advice_->setTextFormat(Qt::PlainText);
  advice_->setWordWrap(true);
  advice_->setObjectName("advice on the object");
  advice_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  advice_->hide();
  answer_->setTextFormat(Qt::PlainText);
  answer_->setWordWrap(true);
  answer_->setObjectName("answer");
  answer_->setAlignment(Qt::AlignTop);
  answer_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  auto* answers = new QScrollArea;
  answers->setWidget(answer_);
  answers->setWidgetResizable(true);
  answers->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  answers->setFrameShape(QFrame::NoFrame);
  answers->setFixedHeight(kAnswerLines * fontMetrics().lineSpacing());  // the rows stay where they are
  answers->setToolTip("What the server said of the last edit");
  answers->setAccessibleName("answer of the server");
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(title_);
  layout->addWidget(advice_);
  layout->addWidget(scroll_, 1);
  layout->addWidget(answers);
  show(nullptr, {}, nullptr, 0);
}

void PropertyPanel::followEventsOf(QWidget* rows) {
  for (QWidget* widget : rows->findChildren<QWidget*>()) {
    const bool turns =
        qobject_cast<QAbstractSpinBox*>(widget) || qobject_cast<QSlider*>(widget) || qobject_cast<QComboBox*>(widget);
    if (turns) widget->setFocusPolicy(Qt::StrongFocus);
    if (turns || qobject_cast<QAbstractButton*>(widget)) widget->installEventFilter(this);
  }
}

void PropertyPanel::addTitle(const char* words) {
  auto* title = new QLabel(words);
  QFont bold = title->font();
  bold.setBold(true);
  title->setFont(bold);
  form_->addRow(title);
}

void PropertyPanel::addEffects() {
  addTitle("Effects");
  auto effects = std::make_unique<EffectRows>(
      form_,
      [this](const std::string& what, const SetProperty& set) {
        if (shown_)
          submit(QString::fromStdString(what), {shown_->name}, set, false);  // others have effects of their own
      },
      [this] { emit finished(); },
      [this](QWidget* rows) {
        for (auto* field : rows->findChildren<QDoubleSpinBox*>()) field->setFixedWidth(fieldWidth_px_);
        followEventsOf(rows);
      });
  effects_ = effects.get();
  rows_.push_back(std::move(effects));
}

std::optional<HandleSpot> PropertyPanel::spot() const {
  if (const auto ofEffect = effects_->spot(); ofEffect || !handlesOfJoint_->isChecked()) return ofEffect;
  return HandleSpot{};
}

void PropertyPanel::addRows(const PropertyGroup& group) {
  addTitle(group.title);
  if (group.isTexture) addGallery();
  for (const SwitchProperty& property : group.switches) {
    rows_.push_back(std::make_unique<SwitchRow>(property, form_, [this, &property](bool on) {
      const auto set = [&property, on](const ObjectRecord& object, const Surroundings& around,
                                       v1::Operation& operation) -> Result<void> {
        if (property.isThere && !property.isThere(object)) return refused(property.label, "the object has none");
        property.set(object, on, around, operation);
        return {};
      };
      change(property.label, set, on && property.isOfAll);
      emit finished();
    }));
  }
  for (const ChoiceProperty& choice : group.choices) {
    rows_.push_back(std::make_unique<ChoiceRow>(choice, form_, [this, &choice](std::size_t entry) {
      change(choice.label,
             [&choice, entry](const ObjectRecord& object, const Surroundings& around, v1::Operation& operation) {
               return choice.set(object, entry, around, operation);
             });
      emit finished();
    }));
  }
  auto* ofSome = new QWidget;  // rows that some objects have
  auto* formOfSome = new QFormLayout(ofSome);
  formOfSome->setContentsMargins(0, 0, 0, 0);
  formOfSome->setVerticalSpacing(0);
  for (const NumberProperty& number : group.numbers) {
    const auto set = [this, &number](double value) { change(number.label, setterOf(number, value)); };
    rows_.push_back(
        std::make_unique<NumberRow>(number, number.isHidden ? formOfSome : form_, set, [this] { emit finished(); }));
  }
  if (formOfSome->rowCount() > 0) {
    form_->addRow(ofSome);
  } else {
    delete ofSome;
  }
}

void PropertyPanel::addIdentity() {
  rows_.push_back(std::make_unique<NameAndSizeRow>(
      form_,
      [this](const QString& wanted) {
        if (shown_) emit renamed(QString::fromStdString(shown_->name), wanted);
      },
      [this](double longest_m) { scale(longest_m); }));
  rows_.push_back(std::make_unique<ColorRow>(form_, [this](std::array<int, 3> color) {
    change("colour",
           [color](const ObjectRecord& /*object*/, const Surroundings& /*around*/,
                   v1::Operation& operation) -> Result<void> {
             setShownColor(color, operation);
             return {};
           });
    emit finished();
  }));
}

/// About the origin of the object's frame.
void PropertyPanel::scale(double longest_m) {
  if (!shown_) return;
  const auto known = view_->meshes.find(shown_->mesh);
  if (known == view_->meshes.end()) return;
  const TriMesh& mesh = *known->second;
  const double side_m = boxOf(mesh).longest_m();  // the row may show that of a mesh before
  if (!(side_m > 0)) return;
  auto scaled =
      canonicalise({mesh.vertices.begin(), mesh.vertices.end()}, mesh.triangles, {.unit_m = longest_m / side_m});
  if (!scaled) return say("size: " + text(scaled.error().text()), true);
  const AssetContent content = std::make_shared<const TriMesh>(std::move(scaled->mesh));
  Edit edit{.uploads = {content}};
  v1::RemeshObject& remesh = *edit.transaction.add_operations()->mutable_remesh();
  remesh.mutable_object()->set_name(shown_->name);
  remesh.mutable_mesh()->set_asset(canonicalBytes(content).hash().asBytes());
  emit uploaded("size of " + text(shown_->name), edit);
}

void PropertyPanel::addGallery() {
  const auto choose = [this](const TextureFamily* family) {
    change(
        "texture",
        [family](const ObjectRecord& object, const Surroundings& /*around*/, v1::Operation& operation) -> Result<void> {
          v1::Texture& texture = *operation.mutable_set_material()->mutable_material()->mutable_texture();
          if (family == nullptr) return {};
          texture = textureOf(object.material.surface);
          *texture.mutable_field() = family->make();
          return {};
        });
    emit finished();
  };
  auto gallery = std::make_unique<TextureGallery>(form_, choose, [this] { chooseImage(); });
  gallery_ = gallery.get();
  rows_.push_back(std::move(gallery));
}

void PropertyPanel::chooseImage() {
  const QString file = QFileDialog::getOpenFileName(
      this, "Image as texture", {}, "Pictures (*.png *.pgm *.ppm *.jpg *.jpeg *.bmp *.gif);;All files (*)");
  if (!file.isEmpty()) setImage(file);
}

void PropertyPanel::setImage(const QString& file) {
  if (!shown_) return;
  say("reading " + QFileInfo(file).fileName() + " ...", false);
  readers_.start([this, file, object = shown_->name] {
    Result<AssetContent> image = readHeightMap(file).map([](auto field) { return AssetContent(std::move(field)); });
    if (!image) image.error().field = QFileInfo(file).fileName().toStdString();
    QMetaObject::invokeMethod(this, [this, object, file, image = std::move(image)] { takeImage(object, file, image); });
  });
}

void PropertyPanel::takeImage(const std::string& object, const QString& file, const Result<AssetContent>& image) {
  if (!image) return say(text(image.error().text()), true);
  const ContentHash field = canonicalBytes(*image).hash();
  gallery_->name(field, QFileInfo(file).fileName());
  const auto set = [field](const ObjectRecord& record, const Surroundings& /*around*/,
                           v1::Operation& operation) -> Result<void> {
    v1::Texture& texture = *operation.mutable_set_material()->mutable_material()->mutable_texture();
    texture = textureOf(record.material.surface);
    *texture.mutable_field() = imageField(field);
    return {};
  };
  emit uploaded("texture of " + text(object),
                {.uploads = {*image}, .compose = composerOf({object}, set, false, floor_m_), .of = {object}});
}

void PropertyPanel::show(const SceneVersion::Object& object, const std::set<std::string>& others,
                         const std::shared_ptr<const MirrorView>& view, double floor_m) {
  const bool isAnother = (object ? object->id : 0) != (shown_ ? shown_->id : 0);
  const bool mayEdit = view && view->mayEdit;
  shown_ = object;
  others_ = others;
  view_ = view;
  floor_m_ = floor_m;
  if (isAnother) answer_->clear();
  scroll_->setVisible(object != nullptr);
  rowsOf_->setEnabled(mayEdit);
  title_->setText(titleOf(object, others.size(), view.get()));
  showRows(isAnother);
}

void PropertyPanel::setAdvice(const QString& advice) {
  advice_->setText(advice);
  advice_->setVisible(!advice.isEmpty());
}

void PropertyPanel::showRows(bool withHeld) {
  if (!shown_) return;
  handlesOfJoint_->setVisible(spotState(*shown_, {}).has_value());
  for (const auto& row : rows_) {
    if (withHeld || !row->isHeld()) row->show(*shown_, *view_);
  }
}

void PropertyPanel::say(const QString& text, bool isError) {
  // The path of a field is one long word: it may be broken at its points.
  answer_->setText(QString(text).replace(QRegularExpression("\\.(?=[a-z])"), ".\u200b"));
  answer_->setStyleSheet(isError ? "color: " + errorColor(palette()).name() : QString());
  if (isError) showRows(true);
}

bool PropertyPanel::eventFilter(QObject* watched, QEvent* event) {
  auto* row = qobject_cast<QWidget*>(watched);
  if (event->type() == QEvent::Wheel && !(qobject_cast<QAbstractSpinBox*>(row) && row->hasFocus())) {
    event->ignore();
    return true;
  }
  if (event->type() == QEvent::ShortcutOverride) {
    auto* key = static_cast<QKeyEvent*>(event);
    const bool isScenes = key->matches(QKeySequence::Undo) || key->matches(QKeySequence::Redo);
    event->setAccepted(key->key() == Qt::Key_Space);
    if (isScenes || event->isAccepted()) return true;
  }
  if (event->type() == QEvent::KeyRelease && !static_cast<QKeyEvent*>(event)->isAutoRepeat() &&
      qobject_cast<QSlider*>(watched)) {
    emit finished();
  }
  return QWidget::eventFilter(watched, event);
}

std::set<std::string> PropertyPanel::names() const {
  std::set<std::string> names = others_;
  names.insert(shown_->name);
  return names;
}

void PropertyPanel::change(const QString& property, const SetProperty& set, bool othersMeet) {
  if (shown_) submit(property, names(), set, othersMeet);
}

void PropertyPanel::submit(const QString& property, const std::set<std::string>& names, const SetProperty& set,
                           bool othersMeet) {
  Edit edit{.compose = composerOf(names, set, othersMeet, floor_m_), .of = names};
  if (othersMeet) {
    for (const SceneVersion::Object& other : view_->scene->objects()) edit.of.insert(other->name);
  }
  const QString more = names.size() > 1 ? QString(" and %1 more").arg(names.size() - 1) : QString();
  emit edited(property + " of " + text(shown_->name) + more, edit);
}

}  // namespace haptics

#include "moc_property_panel.cpp"
