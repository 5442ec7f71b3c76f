#include "graphics_client/application/effect_rows.h"

#include <QFormLayout>
#include <QHBoxLayout>
#include <QIcon>
#include <QKeyEvent>
#include <QLabel>
#include <QListWidget>
#include <QMenu>
#include <QPixmap>
#include <QPushButton>
#include <QSignalBlocker>
#include <QSpinBox>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "graphics_client/viewer/effect_lines.h"

namespace haptics {
namespace {

constexpr int kLines = 4, kIcon_px = 12;

/// In the colour in which the picture has it.
QIcon iconOf(Effect::Kind kind) {
  const auto shade = palette::bytes(effectShade(kind));
  QPixmap picture(kIcon_px, kIcon_px);
  picture.fill(QColor(shade[0], shade[1], shade[2]));
  return picture;
}

QString nameOf(Effect::Kind kind) { return QString::fromStdString(effectName(kind)); }

void describe(QWidget* widget, const char* name, const char* tip) {
  widget->setObjectName(name);
  widget->setAccessibleName(name);
  widget->setToolTip(tip);
}

}  // namespace

EffectRows::EffectRows(QFormLayout* form, std::function<void(const std::string&, SetProperty)> change,
                       std::function<void()> finished, std::function<void(QWidget*)> made)
    : change_(std::move(change)),
      finished_(std::move(finished)),
      made_(std::move(made)),
      list_(new QListWidget),
      path_(new QWidget),
      pathPoint_(new QSpinBox) {
  describe(list_, "effects",
           "Forces beyond the surface. The one that is chosen has its properties below, and its handles in the picture "
           "while "
           "they are on (g). Click it again to let go of it");
  list_->setFixedHeight(kLines * list_->fontMetrics().lineSpacing());
  for (QWidget* of : {static_cast<QWidget*>(list_), list_->viewport()}) of->installEventFilter(this);
  form->addRow(list_);
  makeButtons(form);
  auto* ofChosen = new QWidget;
  below_ = new QVBoxLayout(ofChosen);
  below_->setContentsMargins(0, 0, 0, 0);
  makePath();
  form->addRow(ofChosen);
  QObject::connect(list_, &QListWidget::itemPressed, this, [this](QListWidgetItem* item) {
    if (list_->row(item) == rowBeforePress_) list_->setCurrentItem(nullptr);
  });
}

void EffectRows::makeButtons(QFormLayout* form) {
  auto* add = new QPushButton("Add");
  describe(add, "add effect", "Another effect, at the upper side of the object");
  auto* kinds = new QMenu(add);
  for (const Effect::Kind kind : effectKinds()) {
    QAction* action = kinds->addAction(iconOf(kind), nameOf(kind));
    QObject::connect(action, &QAction::triggered, this, [this, kind] { this->add(kind); });
  }
  add->setMenu(kinds);
  auto* remove = new QPushButton("Remove");
  remove_ = remove;
  describe(remove, "remove effect", "Takes the chosen effect away");
  QObject::connect(remove, &QPushButton::clicked, this, [this] { this->remove(); });
  auto* buttons = new QWidget;
  auto* layout = new QHBoxLayout(buttons);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(add);
  layout->addWidget(remove);
  form->addRow(buttons);
}

void EffectRows::makePath() {
  describe(pathPoint_, "path point", "The point of the path that the rows below and the handles move");
  pathPoint_->setPrefix("point ");
  auto* more = new QToolButton;
  more->setText("+");
  describe(more, "add path point", "Another point, half-way to the next");
  auto* less = new QToolButton;
  less->setText("\u2212");
  describe(less, "remove path point", "Takes this point away");
  QObject::connect(more, &QToolButton::clicked, this, [this] {
    const auto place = chosen();
    if (!place) return;
    edit("path", [place = *place, point = rows_->pathPoint](const ObjectRecord& object, const Surroundings& /*around*/,
                                                            v1::Operation& operation) {
      return addPathPoint(object, place, point, operation);
    });
  });
  QObject::connect(less, &QToolButton::clicked, this, [this] {
    const auto place = chosen();
    if (!place) return;
    edit("path", [place = *place, point = rows_->pathPoint](const ObjectRecord& object, const Surroundings& /*around*/,
                                                            v1::Operation& operation) {
      return removePathPoint(object, place, point, operation);
    });
  });
  auto* layout = new QHBoxLayout(path_);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(pathPoint_, 1);
  layout->addWidget(more);
  layout->addWidget(less);
  below_->addWidget(path_);
  path_->hide();
}

std::optional<EffectPlace> EffectRows::chosen() const {
  const auto row = static_cast<std::size_t>(list_->currentRow());
  return row < listed_.size() ? std::optional(EffectPlace{row, listed_[row]}) : std::nullopt;
}

std::optional<HandleSpot> EffectRows::spot() const {
  return rows_ ? std::optional(HandleSpot{rows_->place, rows_->pathPoint}) : std::nullopt;
}

void EffectRows::edit(const std::string& what, const SetProperty& set) {
  change_(what, set);
  finished_();
}

void EffectRows::add(Effect::Kind kind) {
  isAdding_ = true;
  edit(effectName(kind),
       [kind](const ObjectRecord& object, const Surroundings& around, v1::Operation& operation) -> Result<void> {
         addEffect(object, usualEffect(kind, around.box), operation);
         return {};
       });
}

void EffectRows::remove() {
  const auto place = chosen();
  if (!place) return;
  edit(effectName(place->kind),
       [place = *place](const ObjectRecord& object, const Surroundings& /*around*/, v1::Operation& operation) {
         return removeEffect(object, place, operation);
       });
  list_->setCurrentItem(nullptr);
}

void EffectRows::show(const ObjectRecord& object, const MirrorView& view) {
  const std::pair of{view.epoch, object.id};
  if (of_ != of) {
    listed_.clear();
    list_->clear();
    isAdding_ = false;
  }
  of_ = of;
  list(object);
  const auto place = chosen();
  remove_->setEnabled(place.has_value());
  const Effect* effect = place ? effectAt(object, *place) : nullptr;
  const std::size_t points = effect == nullptr ? 0 : effect->path_m.size();
  path_->setVisible(points > 0);
  if (points > 0) {
    const QSignalBlocker quiet(pathPoint_);
    pathPoint_->setRange(1, static_cast<int>(points));
    pathPoint_->setSuffix(QString(" of %1").arg(points));
  }
  const std::size_t point = points == 0 ? 0 : static_cast<std::size_t>(pathPoint_->value()) - 1;
  if (effect == nullptr) {
    rows_.reset();
    return;
  }
  if (!rows_ || rows_->place != *place || rows_->pathPoint != point) makeRows(*place, point);
  for (const auto& row : rows_->rows) {
    if (!row->isHeld()) row->show(object, view);
  }
}

/// Another effect may stand at the place of one that is gone: then none is chosen.
void EffectRows::list(const ObjectRecord& object) {
  std::vector<Effect::Kind> kinds;
  for (const Effect& effect : object.effects) kinds.push_back(effect.kind);
  if (kinds == listed_) return;
  const auto before = chosen();
  const bool isMore = kinds.size() > listed_.size();
  const bool isSame =
      before && before->number < kinds.size() &&
      std::equal(listed_.begin(), listed_.begin() + static_cast<std::ptrdiff_t>(before->number) + 1, kinds.begin());
  listed_ = kinds;
  const QSignalBlocker quiet(list_);
  list_->clear();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    list_->addItem(new QListWidgetItem(iconOf(kinds[i]), QString("%1  %2").arg(i + 1).arg(nameOf(kinds[i]))));
  }
  const int row = isMore && std::exchange(isAdding_, false) ? static_cast<int>(kinds.size()) - 1
                  : isSame                                  ? static_cast<int>(before->number)
                                                            : -1;
  list_->setCurrentRow(row);
}

void EffectRows::makeRows(const EffectPlace& place, std::size_t pathPoint) {
  rows_.reset();
  rows_ = std::make_unique<Rows>();
  Rows& rows = *rows_;
  rows.place = place;
  rows.pathPoint = pathPoint;
  rows.choices = effectChoices(place);
  rows.numbers = pathNumbers(place, pathPoint);
  for (NumberProperty& number : effectNumbers(place)) rows.numbers.push_back(std::move(number));
  rows.widget = std::make_unique<QWidget>();
  auto* forms = new QVBoxLayout(rows.widget.get());
  forms->setContentsMargins(0, 0, 0, 0);
  auto *choices = new QFormLayout, *numbers = new QFormLayout;
  choices->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  numbers->setVerticalSpacing(0);
  forms->addLayout(choices);
  forms->addLayout(numbers);
  const std::string effect = "effect " + std::to_string(place.number + 1) + " ";
  for (const ChoiceProperty& choice : rows.choices) {
    rows.rows.push_back(std::make_unique<ChoiceRow>(choice, choices, [this, effect, &choice](std::size_t entry) {
      edit(effect + choice.label,
           [set = choice.set, entry](const ObjectRecord& object, const Surroundings& around, v1::Operation& operation) {
             return set(object, entry, around, operation);
           });
    }));
  }
  for (const NumberProperty& number : rows.numbers) {
    const auto set = [this, effect, &number](double value) { change_(effect + number.label, setterOf(number, value)); };
    rows.rows.push_back(std::make_unique<NumberRow>(number, numbers, set, finished_));
  }
  for (QWidget* widget : rows.widget->findChildren<QWidget*>()) {
    if (!widget->accessibleName().isEmpty()) widget->setAccessibleName("effect " + widget->accessibleName());
  }
  below_->addWidget(rows.widget.get());
  made_(rows.widget.get());
  rows.widget->show();
}

bool EffectRows::eventFilter(QObject* watched, QEvent* event) {
  if (watched == list_->viewport()) {
    if (event->type() == QEvent::MouseButtonPress) rowBeforePress_ = list_->currentRow();
    return false;
  }
  const bool isKey = event->type() == QEvent::ShortcutOverride || event->type() == QEvent::KeyPress;
  if (!isKey || !static_cast<QKeyEvent*>(event)->matches(QKeySequence::Delete)) return false;
  event->accept();
  if (event->type() == QEvent::KeyPress) remove();
  return true;
}

}  // namespace haptics
