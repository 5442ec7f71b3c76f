#include <QAction>
#include <QDockWidget>
#include <QMenuBar>
#include <QScrollArea>
#include <utility>

#include "graphics_client/application/help.h"
#include "graphics_client/application/main_window.h"
#include "graphics_client/application/printable_text.h"
#include "graphics_client/application/theme.h"

namespace haptics {
namespace {

QDockWidget* dock(const QString& title, QWidget* content) {
  auto* dock = new QDockWidget(title);
  dock->setObjectName(title);
  dock->setWidget(content);
  return dock;
}

/// So that a small screen has room for the window.
QWidget* scrolled(QWidget* content) {
  content->setMinimumSize(600, 120);
  auto* scroll = new QScrollArea;
  scroll->setWidget(content);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  return scroll;
}

}  // namespace

void MainWindow::makeDocks() {
  addDockWidget(Qt::LeftDockWidgetArea, dock("Objects", objects_));
  addDockWidget(Qt::LeftDockWidgetArea, dock("Properties", properties_));
  addDockWidget(Qt::BottomDockWidgetArea, dock("Plots", scrolled(plots_)));
  setCorner(Qt::BottomLeftCorner, Qt::LeftDockWidgetArea);
  const auto docks = findChildren<QDockWidget*>();
  resizeDocks({docks[0], docks[1]}, {1, 3}, Qt::Vertical);
  resizeDocks({docks[0], docks[2]}, {350, 150}, Qt::Horizontal);
  resizeDocks({docks[2]}, {170}, Qt::Vertical);
}

QAction* MainWindow::addAction(QMenu* menu, const QString& title, const QKeySequence& key, const QString& tip,
                               std::function<void()> does) {
  QAction* action = menu->addAction(title);
  action->setShortcut(key);
  action->setToolTip(tip);
  action->setStatusTip(tip);
  connect(action, &QAction::triggered, [does = std::move(does)] { does(); });
  return action;
}

QAction* MainWindow::addSwitch(QMenu* menu, const QString& title, const QKeySequence& key, const QString& tip,
                               bool isOn, std::function<void()> toggle) {
  QAction* action = addAction(menu, title, key, tip, std::move(toggle));
  action->setCheckable(true);
  action->setChecked(isOn);
  return action;
}

void MainWindow::makeEditMenu() {
  QMenu* edit = menuBar()->addMenu("&Edit");
  undo_ = addAction(edit, "&Undo", QKeySequence::Undo, "Takes back your last edit, if nobody else has touched it since",
                    [this] {
                      gizmo_.finishSteps();
                      editor_.undo();
                    });
  redo_ = addAction(edit, "&Redo", QKeySequence("Ctrl+Y"), "Makes the edit again that was taken back", [this] {
    gizmo_.finishSteps();
    editor_.redo();
  });
  edit->addSeparator();
  QMenu* objects = edit->addMenu("&Add");
  int number = 0;
  for (const char* kind : {"Sphere", "Box", "Cylinder", "Torus"}) {
    addAction(objects, kind, QString("Ctrl+%1").arg(++number), "Adds one beside the others, on the floor",
              [this, kind] {
                const std::string name = QString(kind).toLower().toStdString();
                const std::string added = editor_.add(name, placeOnFloor(name, Vec3(SceneEditor::kSize_m)));
                if (auto placed = placed_.extract(name)) {
                  placed.key() = added;
                  placed_.insert(std::move(placed));
                }
                select(QString::fromStdString(added));
              });
  }
  ofSelected_ = {
      addAction(edit, "&Duplicate", QKeySequence("Ctrl+D"), "Others like those that are selected, beside them",
                [this] { withSelected([this](const auto& names) { editor_.duplicate(names); }); }),
      addAction(edit, "&Delete", QKeySequence::Delete, "Removes what is selected",
                [this] { withSelected([this](const auto& names) { editor_.remove(names); }); })};
  objects_->addActions(ofSelected_);
  for (QAction* action : ofSelected_) action->setEnabled(false);
  edit->addSeparator();
  gizmo_.addActions(edit, view_);
  edit->addSeparator();
  addAction(
      edit, "Ask for ad&vice", QKeySequence("Ctrl+Shift+A"),
      "Tries fewer triangles and other features, some minutes long, and says beside each object what feels the same",
      [this] { askForAdvice(); });
  cancelAdvice_ = addAction(edit, "&Cancel advice", QKeySequence("Ctrl+Alt+A"), "Ends the trials that are under way",
                            [this] { advisor_->cancel(); });
}

void MainWindow::addHiding(QMenu* menu) {
  objects_->addAction(addAction(menu, "&Hide or show the object", QKeySequence("Ctrl+H"),
                                "The selected object, in this picture only", [this] {
                                  withSelected([this](const auto& objects) {
                                    for (const std::string& object : objects)
                                      objects_->toggleVisible(QString::fromStdString(object));
                                  });
                                }));
  objects_->addAction(addAction(menu, "Show hidden &objects", QKeySequence("Ctrl+Shift+H"),
                                "All objects that are hidden in this picture", [this] { objects_->showAll(); }));
}

void MainWindow::makeFileMenu() {
  const auto add = [this](auto... arguments) { return addAction(arguments...); };
  QMenu* file = menuBar()->addMenu("&File");
  add(file, "&Open scene...", QKeySequence::Open, "Takes the objects of a scene file in place of the present ones",
      [this] { files_.open(); });
  add(file, "Open &recording...", QKeySequence("Ctrl+Shift+O"),
      "Shows what a server recorded, on a time line, in place of the server", [this] { replay_->open(); });
  add(file, "&Import mesh...", QKeySequence("Ctrl+I"), "Adds the mesh of a file to the scene; or drop files here",
      [this] { importMesh(); });
  cancelImport_ = add(file, "&Cancel import", QKeySequence("Ctrl+Shift+I"),
                      "Ends the imports that are under way; the scene stays as it is", [this] { importer_->cancel(); });
  add(file, "Sa&ve scene", QKeySequence("Ctrl+S"), "Writes the scene to the file that was opened or saved last",
      [this] { files_.save(); });
  add(file, "Save scene &as...", QKeySequence("Ctrl+Shift+S"), "Writes a scene file, with its meshes beside it",
      [this] { files_.saveAs(); });
  pictures_->addActions(file, add);
  add(file, "Save p&lots", QKeySequence("Ctrl+L"), "Writes haptic_plots.pdf in this folder", [this] {
    const QString pdf = "haptic_plots.pdf";
    const Result<void> saved = plots_->save(pdf);
    say("plots", saved ? pdf + " is written" : text(saved.error().text()), !saved);
  });
  add(file, "&Quit", Qt::Key_Q, "Ends the viewer; the server goes on", [this] { close(); });
}

void MainWindow::makeSessionMenu() {
  QMenu* session = menuBar()->addMenu("&Session");
  QAction* connecting = addAction(session, "&Connect...", QKeySequence("Ctrl+K"), "Shows another server",
                                  [this] { connection_.askForServer(); });
  QAction* leaving = addAction(session, "&Disconnect", QKeySequence("Ctrl+Shift+K"), "Leaves the server, which goes on",
                               [this] { connection_.disconnectFromServer(); });
  for (QAction* action : {connecting, leaving}) action->setEnabled(!link_.isInProcess());
  session->addSeparator();
  addAction(session, "Save the &last 10 seconds", QKeySequence("Ctrl+R"),
            "The server writes what it felt into a recording, on its own machine",
            [this] { connection_.saveLastSeconds(); });
  QMenu* replay = session->addMenu("&Replay");
  replay_->addActions(replay, [this](auto... arguments) { return addAction(arguments...); });
}

void MainWindow::makeMenus() {
  const auto add = [this](auto... arguments) { return addAction(arguments...); };
  makeFileMenu();
  makeEditMenu();
  makeViewMenu();
  QMenu* hand = menuBar()->addMenu("&Hand");
  add(hand, "On surfaces, or in &space", Qt::Key_T,
      "The pointer strokes surfaces, or moves the hand in the picture's plane", [this] {
        const bool onSurface = hand_.steering().mapping() == HandSteering::Mapping::kSurface;
        hand_.steering().setMapping(onSurface ? HandSteering::Mapping::kSpace : HandSteering::Mapping::kSurface);
      });
  add(hand, "Press &harder", Qt::Key_Plus, "As the wheel while the button is down",
      [this] { hand_.steering().changePress(1); });
  add(hand, "Press &less", Qt::Key_Minus, "As the wheel while the button is down",
      [this] { hand_.steering().changePress(-1); });
  add(hand, "Let &go", Qt::Key_Escape, "Gives the hand back; it explores by itself", [this] { hand_.letGo(); });

  makeSessionMenu();
  QMenu* plots = menuBar()->addMenu("&Plots");
  pausePlots_ = add(plots, "&Pause", Qt::Key_Space, "The curves stand still", [] {});
  pausePlots_->setCheckable(true);
  connect(pausePlots_, &QAction::toggled, [this](bool on) { plots_->setPaused(on); });

  makeHelpMenu();
}

void MainWindow::makeViewMenu() {
  const auto add = [this](auto... arguments) { return addSwitch(arguments...); };
  QMenu* view = menuBar()->addMenu("&View");
  tools_.addLooks(view, [this](auto... arguments) { return addAction(arguments...); });
  const SceneView::Style style = scene_.style();
  add(view, "&Follow the contact", Qt::Key_F, "The camera moves with the contact", style.follow,
      [this] { toggle(&SceneView::Style::follow); });
  add(view, "&Close-up", Qt::Key_C, "The contact, large, in the corner", scene_.renderWindow().closeUpShown(),
      [this] { scene_.renderWindow().showCloseUp(!scene_.renderWindow().closeUpShown()); });
  add(view, "&Wireframe", Qt::Key_W, "Lines only", style.wireframe, [this] { toggle(&SceneView::Style::wireframe); });
  add(view, "Polygon &edges", Qt::Key_E, "Lines of the mesh", style.edges,
      [this] { toggle(&SceneView::Style::edges); });
  add(view, "&Displacement", Qt::Key_D, "Colours soft objects by how far they are displaced", style.displacement,
      [this] { toggle(&SceneView::Style::displacement); });
  add(view, "&Names", Qt::Key_N, "Of the objects", scene_.overlay().areLabelsVisible(),
      [this] { scene_.overlay().toggleLabels(); });
  add(view, "&Overlay", Qt::Key_O, "All words over the picture", scene_.overlay().isVisible(),
      [this] { scene_.overlay().toggle(); });
  add(view, "De&tails", QKeySequence("Shift+O"), "The state of server and link in all its lines",
      scene_.overlay().areDetailsVisible(), [this] { scene_.overlay().toggleDetails(); });
  tools_.addTools(view, [this](auto... arguments) { return addAction(arguments...); });
  addHiding(view);
  view->addSeparator();
  add(view, "Dar&k panels", QKeySequence("Ctrl+Shift+D"), "Light words on dark ground, in this and later runs",
      isDarkChosen(), [] { chooseDark(!isDarkChosen()); });
  int number = 0;
  for (QDockWidget* panel : findChildren<QDockWidget*>()) {
    QAction* shown = panel->toggleViewAction();
    shown->setShortcut(QString("Alt+%1").arg(++number));
    shown->setToolTip("Shows or hides this panel");
    shown->setStatusTip(shown->toolTip());
    view->addAction(shown);
  }
}

void MainWindow::makeHelpMenu() {
  const auto add = [this](auto... arguments) { return addAction(arguments...); };
  QMenu* help = menuBar()->addMenu("&Help");
  add(help, "&All keys", QKeySequence::HelpContents, "What the mouse and all keys do", [this] { showKeys(this); });
  add(help, "&Guide", QKeySequence("Shift+F1"), "How the viewer is used", [this] { showGuide(this); });
  addSwitch(help, "&Keys", Qt::Key_H, "The most important keys, over the picture", scene_.overlay().isHelpVisible(),
            [this] { scene_.overlay().toggleHelp(); });
  add(help, "A&bout", QKeySequence("Ctrl+F1"), "Version and source", [this] { showAbout(this); });
}

}  // namespace haptics
