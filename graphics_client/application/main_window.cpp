#include "graphics_client/application/main_window.h"

#include <spdlog/spdlog.h>

#include <QAction>
#include <QDockWidget>
#include <QFileDialog>
#include <QLabel>
#include <QMenuBar>
#include <QMessageBox>
#include <QScrollArea>
#include <QStatusBar>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/text/printable.h"
#include "graphics_client/application/file_drop.h"

namespace haptics {
namespace {

/// How often words and curves change (seconds).
constexpr double kRefresh_s = 0.1;
/// A picture that nothing has changed is drawn anew after so long: its words may have aged (seconds).
constexpr double kIdleFrame_s = 1;
constexpr double kPressPerClick = 1.2;
/// In space: of the hand, for a click of the wheel (metres).
constexpr double kStepPerClick_m = 0.004;
/// Around an object's box a place on its drawn surface may be (metres): bumps, dents.
constexpr double kAround_m = 0.002;
constexpr int kMessage_ms = 5000;
/// Between the highest object and one that is imported (metres).
constexpr double kAboveScene_m = 0.02;
constexpr const char* kMeshFiles =
    "Meshes (*.obj *.ply *.stl *.off *.om *.iv *.OBJ *.PLY *.STL *.OFF *.OM *.IV);;All files (*)";

QString text(const std::string& untrusted) { return QString::fromStdString(printable(untrusted)); }

/// Whether a place is within the box that these are the corners of.
bool isWithin(const NamedBox& box, Vec3 place) {
  const Vec3 from = place - box.corners[0];
  for (const std::size_t axis : {1, 2, 4}) {
    const Vec3 side = box.corners[axis] - box.corners[0];
    const double length = glm::length(side);
    if (!(length > 0)) continue;
    const double along = glm::dot(from, side) / length;
    if (along < -kAround_m || along > length + kAround_m) return false;
  }
  return true;
}

double volume(const NamedBox& box) {
  double product = 1;
  for (const std::size_t axis : {1, 2, 4}) product *= glm::distance(box.corners[axis], box.corners[0]);
  return product;
}

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

MainWindow::MainWindow(const ViewerOptions& options, ServerLink& link,
                       std::function<std::shared_ptr<const MirrorView>()> newest)
    : options_(options),
      link_(link),
      newest_(std::move(newest)),
      scene_(options),
      view_(new ViewWidget(scene_)),
      objects_(new ObjectList),
      properties_(new PropertyPanel),
      plots_(new PlotPanel),
      linkText_(new QLabel),
      sceneText_(new QLabel),
      servoText_(new QLabel),
      handText_(new QLabel),
      editor_(
          this, link, [this](auto... words) { say(words...); },
          [this](const v1::Accepted& accepted) { objects_->addWarnings(accepted); }),
      gizmo_(scene_, editor_, newest_),
      importer_(new MeshImporter(link, editor_)) {
  setWindowTitle("Haptic viewer");
  resize(options.width_px, options.height_px);
  setCentralWidget(view_);
  makeDocks();
  makeMenus();
  for (QLabel* label : {linkText_, sceneText_, servoText_, handText_}) {
    label->setTextFormat(Qt::PlainText);
    label->setMinimumWidth(1);
    statusBar()->addWidget(label);
  }
  statusBar()->addPermanentWidget(importer_);
  connect(importer_, &MeshImporter::failed, [this](auto file, auto why) { say("import " + file, why, true); });
  connect(importer_, &MeshImporter::imported, [this](const QString& object, const QString& report) {
    for (const QString& line : report.split('\n')) {
      spdlog::info("import {}: {}", object.toStdString(), line.toStdString());
    }
    select(object);
    report_ = report;
  });
  connect(new FileDrop(this), &FileDrop::dropped, [this](auto files, auto place) { drop(files, place); });
  connect(view_, &ViewWidget::pressed, [this] {
    if (gizmo_.press(*view_->pointer())) return;
    if (lead_ != Lead::kLed) lead_ = Lead::kNone;
  });
  connect(view_, &ViewWidget::released, [this](bool moved) { clicked_ = !gizmo_.release() && !moved; });
  connect(view_, &ViewWidget::wheelTurned, [this](double clicks) {
    if (steering_.mapping() == HandSteering::Mapping::kSurface) {
      steering_.setPress_N(steering_.press_N() * std::pow(kPressPerClick, clicks));
    } else {
      steering_.moveBy(scene_.cameras().direction() * (kStepPerClick_m * clicks));
    }
  });
  connect(properties_, &PropertyPanel::finished, [this] { editor_.finishDrag(); });
  connect(properties_, &PropertyPanel::edited,
          [this](const QString& edit, const v1::Transaction& value) { editor_.drag(edit, value); });
  connect(properties_, &PropertyPanel::uploaded,
          [this](const QString& edit, const v1::Transaction& change, const AssetContent& asset) {
            editor_.submit(edit, change, asset);
          });
  connect(objects_, &ObjectList::selected, [this](const QString& name) { select(name); });
  connect(objects_, &ObjectList::hiddenChanged, [this](const std::set<std::string>& names) {
    scene_.hide(names);
    view_shown_ = nullptr;
  });
  connect(&timer_, &QTimer::timeout, [this] { frame(); });
  timer_.setTimerType(Qt::PreciseTimer);
  timer_.start(static_cast<int>(1000 / options.frameLimit_Hz));
  view_->setFocus();
}

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
  for (const char* kind : {"Sphere", "Box", "Cylinder", "Torus"}) {
    addAction(objects, kind, {}, "Adds one above the scene", [this, kind] {
      select(QString::fromStdString(editor_.add(QString(kind).toLower().toStdString(), top_m())));
    });
  }
  objects_->addAction(
      addAction(edit, "&Duplicate", QKeySequence("Ctrl+D"), "Another object like the selected one, beside it",
                [this] { withSelected([this](const std::string& object) { editor_.duplicate(object); }); }));
  objects_->addAction(addAction(edit, "&Delete", QKeySequence::Delete, "Removes the selected object", [this] {
    withSelected([this](const std::string& object) { editor_.remove(object); });
  }));
  edit->addSeparator();
  gizmo_.addActions(edit, view_);
}

void MainWindow::addHiding(QMenu* menu) {
  objects_->addAction(addAction(
      menu, "&Hide or show the object", QKeySequence("Ctrl+H"), "The selected object, in this picture only", [this] {
        withSelected([this](const std::string& object) { objects_->toggleVisible(QString::fromStdString(object)); });
      }));
  objects_->addAction(addAction(menu, "Show hidden &objects", QKeySequence("Ctrl+Shift+H"),
                                "All objects that are hidden in this picture", [this] { objects_->showAll(); }));
}

void MainWindow::makeMenus() {
  const auto add = [this](auto... arguments) { return addAction(arguments...); };
  QMenu* file = menuBar()->addMenu("&File");
  add(file, "&Open scene...", QKeySequence::Open, "Takes the objects of a scene file in place of the present ones",
      [this] { open(); });
  add(file, "&Import mesh...", QKeySequence("Ctrl+I"), "Adds the mesh of a file to the scene; or drop files here",
      [this] { importMesh(); });
  add(file, "&Cancel import", QKeySequence("Ctrl+Shift+I"),
      "Ends the imports that are under way; the scene stays as it is", [this] { importer_->cancel(); });
  add(file, "Save scene &as...", QKeySequence("Ctrl+Shift+S"), "Writes a scene file, with its meshes beside it",
      [this] { save(); });
  add(file, "&Save picture", Qt::Key_S, "Writes haptic_view_N.png in this folder", [this] { saveScreenshot(); });
  add(file, "Save p&lots", QKeySequence("Ctrl+L"), "Writes haptic_plots.pdf in this folder",
      [this] { plots_->save("haptic_plots.pdf"); });
  add(file, "&Quit", Qt::Key_Q, "Ends the viewer; the server goes on", [this] { close(); });

  makeEditMenu();
  QMenu* view = menuBar()->addMenu("&View");
  add(view, "Show &all", Qt::Key_R, "Moves the camera so that all objects are seen", [this] { scene_.frameAll(); });
  add(view, "&Follow the contact", Qt::Key_F, "The camera moves with the contact",
      [this] { toggle(&SceneView::Style::follow); });
  add(view, "&Close-up", Qt::Key_C, "The contact, large, in the corner",
      [this] { scene_.renderWindow().showCloseUp(!scene_.renderWindow().closeUpShown()); });
  add(view, "&Wireframe", Qt::Key_W, "Lines only", [this] { toggle(&SceneView::Style::wireframe); });
  add(view, "Polygon &edges", Qt::Key_E, "Lines of the mesh", [this] { toggle(&SceneView::Style::edges); });
  add(view, "&Displacement", Qt::Key_D, "Colours soft objects by how far they are displaced",
      [this] { toggle(&SceneView::Style::displacement); });
  add(view, "&Names", Qt::Key_N, "Of the objects", [this] { scene_.overlay().toggleLabels(); });
  add(view, "&Overlay", Qt::Key_O, "All words over the picture", [this] { scene_.overlay().toggle(); });
  addHiding(view);
  view->addSeparator();
  for (QDockWidget* panel : findChildren<QDockWidget*>()) view->addAction(panel->toggleViewAction());

  QMenu* hand = menuBar()->addMenu("&Hand");
  add(hand, "On surfaces, or in &space", Qt::Key_T,
      "The pointer strokes surfaces, or moves the hand in the picture's plane", [this] {
        const bool onSurface = steering_.mapping() == HandSteering::Mapping::kSurface;
        steering_.setMapping(onSurface ? HandSteering::Mapping::kSpace : HandSteering::Mapping::kSurface);
      });
  add(hand, "Press &harder", Qt::Key_Plus, "As the wheel while the button is down",
      [this] { steering_.setPress_N(steering_.press_N() * kPressPerClick); });
  add(hand, "Press &less", Qt::Key_Minus, "As the wheel while the button is down",
      [this] { steering_.setPress_N(steering_.press_N() / kPressPerClick); });
  add(hand, "Let &go", Qt::Key_Escape, "Gives the hand back; it explores by itself", [this] { letGo(); });

  QMenu* plots = menuBar()->addMenu("&Plots");
  QAction* pause = add(plots, "&Pause", Qt::Key_Space, "The curves stand still", [] {});
  pause->setCheckable(true);
  connect(pause, &QAction::toggled, [this](bool on) { plots_->setPaused(on); });

  QMenu* help = menuBar()->addMenu("&Help");
  add(help, "&Keys", Qt::Key_H, "What the mouse and the keys do", [this] { scene_.overlay().toggleHelp(); });
}

void MainWindow::toggle(bool SceneView::Style::*how) {
  SceneView::Style style = scene_.style();
  style.*how = !(style.*how);
  scene_.setStyle(style);
}

void MainWindow::frame() {
  const double now_s = std::chrono::duration<double>(Clock::now() - start_).count();
  if (options_.duration_s && now_s >= *options_.duration_s) {
    close();
    return;
  }
  const auto view = newest_();
  const bool gizmoChanged = gizmo_.update(*view, selected_.toStdString(), view_->pointer());
  lead(*view, now_s - drawn_s_);
  const bool dirty = view_->takeDirty() || gizmoChanged || changed(*view) || now_s - drawn_s_ >= kIdleFrame_s;
  if (dirty) {
    scene_.drawFrame(view, now_s);
    if (std::exchange(clicked_, false)) {
      if (const auto place = scene_.probe().found()) select(objectAt(place->position));
    }
    import(std::exchange(dropped_, {}), surfaceUnderPointer());
    view_shown_ = view;
    drawn_s_ = now_s;
  }
  plot(*view, now_s);
  if (now_s - refreshed_s_ < kRefresh_s) return;
  refreshed_s_ = now_s;
  objects_->show(*view);
  refresh(view);
  plots_->refresh();
}

void MainWindow::plot(const MirrorView& view, double now_s) {
  if (!view.sample || view.sample->tick == plottedTick_) return;
  const TelemetrySample& sample = *view.sample;
  plottedTick_ = sample.tick;
  const double energy_J = std::accumulate(sample.energyGiven_J.begin(), sample.energyGiven_J.end(), 0.0);
  plots_->add({.time_s = now_s,
               .written_N = glm::length(sample.force.written),
               .spring_N = glm::length(sample.force.spring),
               .friction_N = glm::length(sample.force.friction),
               .texture_N = glm::length(sample.force.texture),
               .depth_mm = 1e3 * sample.penetration_m,
               .energy_mJ = 1e3 * energy_J});
}

/// Whether the picture would be another one.
bool MainWindow::changed(const MirrorView& view) const {
  if (!view_shown_) return true;
  const MirrorView& before = *view_shown_;
  if (view.link != before.link || view.scene != before.scene || view.meshes.size() != before.meshes.size() ||
      view.sample.has_value() != before.sample.has_value() || scene_.objects().isSettling()) {
    return true;
  }
  if (!view.sample) return false;
  const TelemetrySample &now = *view.sample, &then = *before.sample;
  return now.hip != then.hip || now.ihip != then.ihip || now.force.written != then.force.written ||
         now.object != then.object || now.frictionState != then.frictionState || now.fault != then.fault ||
         view.bodies != before.bodies || view.dents != before.dents;
}

/// Leads the hand where the pointer is, once the server gives it.
void MainWindow::lead(const MirrorView& view, double dt_s) {
  const bool isLed = view.hand.isSelf && view.sample.has_value();
  const bool isPressed = view_->isPressed() && !gizmo_.isDragging();
  const bool looks = isPressed || isLed || clicked_ || !dropped_.isEmpty();
  scene_.probe().aim(looks ? view_->pointer() : std::nullopt);
  const auto surface = gizmo_.isDragging() ? std::nullopt : surfaceUnderPointer();
  if (lead_ == Lead::kNone && isPressed && surface && view.link == LinkState::kLive) {
    link_.leadHand(true);
    lead_ = Lead::kAsked;
  }
  if (lead_ == Lead::kAsked && isLed) {
    steering_.begin(view.sample->hip);
    lead_ = Lead::kLed;
  }
  if (lead_ == Lead::kLed && !isLed) lead_ = Lead::kRefused;  // lost, with the connection or to another
  scene_.showPointer(lead_ == Lead::kLed ? surface : std::nullopt);
  if (lead_ != Lead::kLed) return;
  if (const auto pressure = view_->penPressure()) {
    steering_.setPress_N(HandSteering::kMinPress_N +
                         *pressure * (HandSteering::kMaxPress_N - HandSteering::kMinPress_N));
  }
  HandSteering::Pointer pointer{.pressed = isPressed, .surface = surface};
  pointer.eye = scene_.cameras().worldPosition();
  if (const auto pixel = view_->pointer()) {
    pointer.onPicture = scene_.cameras().onPictureThrough(steering_.hand(), (*pixel)[0], (*pixel)[1]);
  }
  link_.commandHand(steering_.next(pointer, view.sample->hip, dt_s));
}

void MainWindow::letGo() {
  lead_ = Lead::kRefused;
  link_.leadHand(false);
}

/// Of an object: the floor is none.
std::optional<SurfacePoint> MainWindow::surfaceUnderPointer() {
  const auto place = scene_.probe().found();
  if (!place || objectAt(place->position).isEmpty()) return std::nullopt;
  return place;
}

/// The smallest whose box holds the place.
QString MainWindow::objectAt(Vec3 place) const {
  std::string name;
  double smallest = 0;
  for (const NamedBox& box : scene_.objects().boxes()) {
    if (!isWithin(box, place) || (!name.empty() && volume(box) >= smallest)) continue;
    smallest = volume(box);
    name = box.name;
  }
  return QString::fromStdString(name);
}

void MainWindow::select(const QString& name) {
  selected_ = name;
  objects_->select(name);
}

void MainWindow::refresh(const std::shared_ptr<const MirrorView>& now) {
  const MirrorView& view = *now;
  properties_->show(selected_.isEmpty() ? nullptr : view.scene->find(selected_.toStdString()), now,
                    scene_.objects().floor_m());
  if (!report_.isEmpty() && view.scene->find(selected_.toStdString())) {
    properties_->say(std::exchange(report_, {}), false);
  }
  for (const auto& [action, verb, offer] :
       {std::tuple{undo_, "&Undo ", editor_.undoOffer()}, std::tuple{redo_, "&Redo ", editor_.redoOffer()}}) {
    action->setEnabled(offer.has_value());
    action->setText(verb + (offer ? text(offer->text) : QString()));
  }
  linkText_->setText(text(view.linkText));
  sceneText_->setText(QString("revision %1, %2")
                          .arg(view.scene->revision())
                          .arg(view.hashesEqual ? "equal to the server's" : "not equal yet"));
  QString servo = QString("%1 frames/s").arg(scene_.framesPerSecond(), 0, 'f', 0);
  if (view.sample && view.sample->fault != Fault::kNone) servo += ", no force: a fault of the servo";
  servoText_->setText(servo);
  const QString press = QString("%1 N").arg(steering_.press_N(), 0, 'f', 1);
  if (!view.hand.refused.empty()) {
    handText_->setText("hand: " + text(view.hand.refused));
  } else if (lead_ == Lead::kLed) {
    handText_->setText("the hand is yours, " +
                       (steering_.mapping() == HandSteering::Mapping::kSurface ? "presses with " + press : "in space"));
  } else if (view.hand.led) {
    handText_->setText("hand: led by " + text(view.hand.clientName));
  } else {
    handText_->setText("press on an object to touch it");
  }
  for (QLabel* label : {linkText_, sceneText_, servoText_, handText_}) label->setToolTip(label->text());
}

double MainWindow::top_m() const {
  double top_m = 0;
  for (const NamedBox& box : scene_.objects().boxes()) {
    for (const Vec3& corner : box.corners) top_m = std::max(top_m, corner.z);
  }
  return top_m;
}

void MainWindow::withSelected(const std::function<void(const std::string&)>& does) {
  if (selected_.isEmpty()) return properties_->say("No object is selected", true);
  does(selected_.toStdString());
}

void MainWindow::say(const QString& edit, const QString& words, bool isError) {
  properties_->say(edit + ": " + words, isError);
  if (!isError) return;
  statusBar()->showMessage(edit + ": " + words, kMessage_ms);
  spdlog::warn("{}: {}", edit.toStdString(), words.toStdString());
}

void MainWindow::finish() {
  importer_->finish();
  editor_.finish();
}

void MainWindow::importMesh() {
  import(QFileDialog::getOpenFileNames(this, "Import mesh", {}, kMeshFiles), std::nullopt);
}

/// Meshes come where the pointer is once the next frame has found the surface there.
void MainWindow::drop(const QStringList& files, const QPoint& place) {
  QStringList meshes;
  for (const QString& file : files) {
    if (file.endsWith(".scene", Qt::CaseInsensitive)) {
      open(file);
    } else {
      meshes << file;
    }
  }
  const QPoint inView = view_->mapFrom(this, place);
  if (!view_->rect().contains(inView)) return import(meshes, std::nullopt);
  view_->pointTo(inView);
  dropped_ += meshes;
}

/// Onto a surface, else above the scene.
void MainWindow::import(const QStringList& files, const std::optional<SurfacePoint>& onto) {
  for (const QString& file : files) {
    importer_->import(file, onto ? onto->position : Vec3(0, 0, top_m() + kAboveScene_m));
  }
}

void MainWindow::open() {
  const QString file = QFileDialog::getOpenFileName(this, "Open scene", {}, "Scenes (*.scene)");
  if (!file.isEmpty()) open(file);
}

void MainWindow::open(const QString& file) {
  if (const Result<void> opened = editor_.open(file.toStdString()); !opened) {
    QMessageBox::warning(this, "Open scene", text(opened.error().text()));
  }
}

void MainWindow::save() {
  const QString file = QFileDialog::getSaveFileName(this, "Save scene as", "scene.scene", "Scenes (*.scene)");
  if (file.isEmpty()) return;
  if (const Result<void> saved = editor_.save(file.toStdString()); !saved) {
    QMessageBox::warning(this, "Save scene as", text(saved.error().text()));
  }
}

void MainWindow::saveScreenshot() {
  const std::string file = "haptic_view_" + std::to_string(++screenshots_) + ".png";
  const Result<void> written = writePng(scene_.picture(scene_.snapshot(), 0), file);
  if (written) {
    statusBar()->showMessage(QString::fromStdString(file) + " is written", 3000);
  } else {
    QMessageBox::warning(this, "Save picture", text(written.error().text()));
  }
}

}  // namespace haptics
