#pragma once

#include <QMainWindow>
#include <QTimer>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graphics_client/application/advisor.h"
#include "graphics_client/application/connection_control.h"
#include "graphics_client/application/free_place.h"
#include "graphics_client/application/gizmo_tool.h"
#include "graphics_client/application/hand_tool.h"
#include "graphics_client/application/mesh_importer.h"
#include "graphics_client/application/object_list.h"
#include "graphics_client/application/picture_files.h"
#include "graphics_client/application/plot_panel.h"
#include "graphics_client/application/property_panel.h"
#include "graphics_client/application/replay_panel.h"
#include "graphics_client/application/scene_editor.h"
#include "graphics_client/application/scene_files.h"
#include "graphics_client/application/view_tools.h"
#include "graphics_client/application/view_widget.h"
#include "graphics_client/application/watchdog_words.h"
#include "graphics_client/mirror/server_link.h"

class QLabel;

namespace haptics {

/// The viewer's window: the picture, which is touched with the mouse, the objects and their properties, curves, and how
/// the connection stands.
class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  /// @param newest  As runOffscreen(); called once a frame.
  MainWindow(const ViewerOptions& options, ServerLink& link, std::function<std::shared_ptr<const MirrorView>()> newest);

  [[nodiscard]] SceneView& scene() { return scene_; }
  /// Shows a recording in place of the server.
  void openRecording(const QString& file) { replay_->open(file); }
  /// Waits until nothing uses the link any more.
  void finish();
  /// Closes it without a question.
  void end();

 protected:
  /// Asks first where edits would be lost.
  void closeEvent(QCloseEvent* event) override;

 private:
  using Clock = std::chrono::steady_clock;

  ViewerOptions options_;
  ServerLink& link_;
  std::function<std::shared_ptr<const MirrorView>()> newest_;
  SceneView scene_;
  ViewWidget* view_;
  HandTool hand_;
  ObjectList* objects_;
  PropertyPanel* properties_;
  PlotPanel* plots_;
  QLabel *linkText_, *sceneText_, *servoText_, *handText_;
  QTimer timer_;
  Clock::time_point start_ = Clock::now();
  std::shared_ptr<const MirrorView> view_shown_;
  std::uint64_t plottedTick_ = 0;
  double refreshed_s_ = 0, drawn_s_ = 0, framed_s_ = 0;
  bool clicked_ = false;  // since the last frame
  QString selected_;
  SceneEditor editor_;
  SceneFiles files_;
  ConnectionControl connection_;
  ReplayPanel* replay_;
  GizmoTool gizmo_;
  MeshImporter* importer_;
  Advisor* advisor_;
  WatchdogWords watchdog_;
  ViewTools tools_;
  PictureFiles* pictures_;
  std::map<std::string, FloorBox> placed_;  // of objects that are not drawn yet, by name
  QStringList dropped_;                     // files, where the pointer is
  QString report_;                          // of the import that is selected, until its object is here
  bool ending_ = false;
  QAction *undo_ = nullptr, *redo_ = nullptr, *pausePlots_ = nullptr;
  QAction *cancelImport_ = nullptr, *cancelAdvice_ = nullptr;
  QList<QAction*> ofSelected_;  // actions on the selected object

  void makeDocks();
  void makeMenus();
  QAction* addAction(QMenu* menu, const QString& title, const QKeySequence& key, const QString& tip,
                     std::function<void()> does);
  /// An entry with a check mark.
  QAction* addSwitch(QMenu* menu, const QString& title, const QKeySequence& key, const QString& tip, bool isOn,
                     std::function<void()> toggle);
  void makeViewMenu();
  void makeHelpMenu();
  void makeFileMenu();
  void makeEditMenu();
  void addHiding(QMenu* menu);
  void makeSessionMenu();
  void frame();
  void enableActions();
  void lead(const MirrorView& view, double dt_s);
  void plot(const MirrorView& view, double now_s);
  [[nodiscard]] bool changed(const MirrorView& view) const;
  [[nodiscard]] std::optional<SurfacePoint> surfaceUnderPointer();
  void select(const QString& name);
  void refresh(const std::shared_ptr<const MirrorView>& now);
  /// On the floor, beside all objects: where the middle of the lower side of such a box goes, which `name` has then.
  [[nodiscard]] Vec3 placeOnFloor(const std::string& name, Vec3 size_m);
  void restoreLayout();
  void saveLayout() const;
  void withSelected(const std::function<void(const std::set<std::string>&)>& does);
  void say(const QString& edit, const QString& words, bool isError);
  void importMesh();
  void drop(const QStringList& files, const QPoint& place);
  void import(const QStringList& files, const std::optional<SurfacePoint>& onto);
  void askForAdvice();
  void sayHand(const MirrorView& view);
  void showOtherServer();
  void showOtherSource();
  void toggle(bool SceneView::Style::*how);
};

}  // namespace haptics
