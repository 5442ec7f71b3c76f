#pragma once

#include <QString>
#include <QTreeWidget>
#include <cstdint>
#include <set>
#include <string>

#include "graphics_client/editing/object_warnings.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// The objects of the scene: which one is selected, which are drawn here, and what the server warned of.
class ObjectList : public QTreeWidget {
  Q_OBJECT

 public:
  ObjectList();

  /// Follows the view.
  void show(const MirrorView& view);
  void select(const QString& name);
  /// Chosen beside the one that is selected.
  [[nodiscard]] std::set<std::string> others() const;
  /// Takes in what the server answered to an edit.
  void addWarnings(const v1::Accepted& accepted);
  /// Shows the object in this viewer's picture, or hides it. The server and other viewers do not know of it.
  void toggleVisible(const QString& name);
  void showAll();

 signals:
  void selected(const QString& name);
  /// All names that are hidden.
  void hiddenChanged(const std::set<std::string>& names);

 protected:
  /// Space checks and unchecks the box.
  bool event(QEvent* event) override;

 private:
  ObjectWarnings warnings_;
  std::set<std::string> hidden_;
  QString selected_;
  std::set<QString> chosen_;  // with it
  bool isChoosing_ = false;   // a person, here
  /// Of the view that is shown.
  struct Shown {
    std::uint64_t epoch = 0, revision = 0;
    std::size_t meshes = 0;
    bool operator==(const Shown&) const = default;
  } shown_;
  bool isStale_ = false;

  void choose();
  void selectHere(const QString& name);
  void addItem(const ObjectRecord& object, const MirrorView& view);
  void setVisible(const std::string& name, bool visible);
};

}  // namespace haptics
