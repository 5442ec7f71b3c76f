#include "graphics_client/application/object_list.h"

#include <QHeaderView>
#include <QKeyEvent>
#include <QSignalBlocker>
#include <QStyle>
#include <utility>

#include "graphics_client/application/printable_text.h"

namespace haptics {
namespace {

enum Column { kName, kTriangles, kKind, kWarnings };

QString kindOf(const ObjectRecord& object) {
  QStringList kind;
  if (object.motion && object.motion->tool) {
    kind << "tool";
  } else if (object.motion && object.motion->joint) {
    kind << (object.motion->joint->kind == JointProperties::Kind::kHinge ? "hinge" : "slider");
  } else if (object.motion && !object.motion->fixed) {
    kind << "moves";
  }
  if (object.deformation.softness || object.deformation.lattice) kind << "soft";
  if (!object.effects.empty()) kind << "effects";
  return kind.join(", ");
}

}  // namespace

ObjectList::ObjectList() {
  setObjectName("objects");
  setAccessibleName("objects");
  setHeaderLabels({"object", "triangles", "kind", "warnings"});
  setRootIsDecorated(false);
  setUniformRowHeights(true);
  setSelectionMode(QAbstractItemView::ExtendedSelection);
  setToolTip(
      "The objects of the scene: click to see one's properties, with Ctrl or Shift several, which a change is then "
      "made to; "
      "the box shows or hides it in this picture");
  setContextMenuPolicy(Qt::ActionsContextMenu);
  header()->setStretchLastSection(false);
  connect(this, &QTreeWidget::currentItemChanged, [this](QTreeWidgetItem* item) {
    if (item != nullptr) selectHere(item->text(kName));
  });
  connect(this, &QTreeWidget::itemSelectionChanged, [this] {
    chosen_.clear();
    for (const QTreeWidgetItem* item : selectedItems()) chosen_.insert(item->text(kName));
    if (!chosen_.empty() && !chosen_.contains(selected_)) selectHere(*chosen_.begin());
  });
  connect(this, &QTreeWidget::itemChanged, [this](QTreeWidgetItem* item, int column) {
    if (column == kName) setVisible(item->text(kName).toStdString(), item->checkState(kName) == Qt::Checked);
  });
}

bool ObjectList::event(QEvent* event) {
  if (event->type() == QEvent::ShortcutOverride && static_cast<QKeyEvent*>(event)->key() == Qt::Key_Space) {
    event->accept();
    return true;
  }
  return QTreeWidget::event(event);
}

void ObjectList::show(const MirrorView& view) {
  const Shown now{view.epoch, view.scene->revision(), view.meshes.size()};
  if (now == shown_ && !isStale_) return;
  shown_ = now;
  isStale_ = false;
  const QSignalBlocker quiet(this);
  clear();
  for (const SceneVersion::Object& object : view.scene->objects()) addItem(*object, view);
  for (int column = 0; column < columnCount(); ++column) resizeColumnToContents(column);
  choose();
}

void ObjectList::selectHere(const QString& name) {
  isChoosing_ = true;
  selected_ = name;
  emit selected(name);
  isChoosing_ = false;
}

/// What is chosen, in a list that is made anew.
void ObjectList::choose() {
  for (int row = 0; row < topLevelItemCount(); ++row) {
    QTreeWidgetItem* item = topLevelItem(row);
    if (item->text(kName) == selected_) setCurrentItem(item, kName, QItemSelectionModel::NoUpdate);
    item->setSelected(chosen_.contains(item->text(kName)));
  }
}

std::set<std::string> ObjectList::others() const {
  std::set<std::string> names;
  for (const QString& name : chosen_) {
    if (name != selected_) names.insert(name.toStdString());
  }
  return names;
}

void ObjectList::addItem(const ObjectRecord& object, const MirrorView& view) {
  const auto mesh = view.meshes.find(object.mesh);
  const auto& warnings = warnings_.of(object.name);
  auto* item = new QTreeWidgetItem(
      this, {text(object.name), mesh == view.meshes.end() ? "..." : QString::number(mesh->second->triangles.size()),
             kindOf(object), warnings.empty() ? QString() : QString::number(warnings.size())});
  item->setTextAlignment(kTriangles, Qt::AlignRight | Qt::AlignVCenter);
  item->setFlags(item->flags() | Qt::ItemIsUserCheckable);
  item->setCheckState(kName, hidden_.contains(object.name) ? Qt::Unchecked : Qt::Checked);
  if (!warnings.empty()) {
    QStringList lines;
    for (const std::string& warning : warnings) lines << text(warning);
    item->setIcon(kWarnings, style()->standardIcon(QStyle::SP_MessageBoxWarning));
    for (int column = 0; column < columnCount(); ++column) item->setToolTip(column, lines.join("\n\n"));
    item->setData(kWarnings, Qt::AccessibleDescriptionRole, lines.join(" "));
  }
}

void ObjectList::select(const QString& name) {
  selected_ = name;
  if (isChoosing_) return;
  chosen_ = {name};
  const QSignalBlocker quiet(this);
  if (name.isEmpty()) setCurrentItem(nullptr);
  choose();
}

void ObjectList::addWarnings(const v1::Accepted& accepted) {
  warnings_.add(accepted);
  isStale_ = true;
}

void ObjectList::setVisible(const std::string& name, bool visible) {
  const bool changed = visible ? hidden_.erase(name) > 0 : hidden_.insert(name).second;
  if (!changed) return;
  isStale_ = true;
  emit hiddenChanged(hidden_);
}

void ObjectList::toggleVisible(const QString& name) {
  setVisible(name.toStdString(), hidden_.contains(name.toStdString()));
}

void ObjectList::showAll() {
  if (hidden_.empty()) return;
  hidden_.clear();
  isStale_ = true;
  emit hiddenChanged(hidden_);
}

}  // namespace haptics

#include "moc_object_list.cpp"
