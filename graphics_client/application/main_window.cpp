#include "graphics_client/application/main_window.h"

#include <spdlog/spdlog.h>

#include <QAction>
#include <QApplication>
#include <QCloseEvent>
#include <QDockWidget>
#include <QLabel>
#include <QMenuBar>
#include <QMessageBox>
#include <QStatusBar>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/text/printable.h"
#include "graphics_client/application/plotted_sample.h"

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
constexpr int kMessage_ms = 5000, kLongMessage_ms = 20'000;

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

}  // namespace

MainWindow::MainWindow(const ViewerOptions& options, ServerLink& link,
                       std::function<std::shared_ptr<const MirrorView>()> newest)
    : options_(options),
      link_(link),
      newest_(std::move(newest)),
      scene_(options),
      view_(new ViewWidget(scene_)),
      objects_(new QTreeWidget),
      properties_(new PropertyPanel),
      plots_(new PlotPanel),
      linkText_(new QLabel),
      sceneText_(new QLabel),
      servoText_(new QLabel),
      handText_(new QLabel),
      editor_(this, link, [this](auto... words) { say(words...); }),
      files_(this, editor_),
      connection_(this, link, files_),
      replay_(new ReplayPanel) {
  setWindowTitle("Haptic viewer");
  resize(options.width_px, options.height_px);
  auto* centre = new QWidget;
  auto* rows = new QVBoxLayout(centre);
  rows->setContentsMargins(0, 0, 0, 0);
  rows->setSpacing(0);
  rows->addWidget(connection_.notice());
  rows->addWidget(view_, 1);
  rows->addWidget(replay_);
  setCentralWidget(centre);
  makeDocks();
  makeMenus();
  for (QLabel* label : {linkText_, sceneText_, servoText_, handText_}) {
    label->setTextFormat(Qt::PlainText);
    statusBar()->addWidget(label);
  }
  connect(view_, &ViewWidget::pressed, [this] {
    if (lead_ != Lead::kLed) lead_ = Lead::kNone;
  });
  connect(view_, &ViewWidget::released, [this](bool moved) { clicked_ = !moved; });
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
  connect(&files_, &SceneFiles::said, [this](auto... words) { say(words...); });
  connect(&connection_, &ConnectionControl::said, [this](const QString& what, const QString& words, bool isError) {
    say(what, words, isError);
    statusBar()->showMessage(what + ": " + words, kLongMessage_ms);
  });
  connect(&connection_, &ConnectionControl::replaced, [this] { showOtherServer(); });
  connect(replay_, &ReplayPanel::said, [this](auto... words) { say(words...); });
  connect(replay_, &ReplayPanel::changed, [this] { showOtherSource(); });
  connect(&timer_, &QTimer::timeout, [this] { frame(); });
  timer_.setTimerType(Qt::PreciseTimer);
  timer_.start(static_cast<int>(1000 / options.frameLimit_Hz));
  view_->setFocus();
}

void MainWindow::makeDocks() {
  objects_->setObjectName("objects");
  objects_->setHeaderLabels({"object", "triangles", "kind"});
  objects_->setRootIsDecorated(false);
  objects_->setToolTip("The objects of the scene: click to see one's properties");
  connect(objects_, &QTreeWidget::currentItemChanged, [this](QTreeWidgetItem* item) {
    if (item != nullptr) select(item->text(0));
  });
  addDockWidget(Qt::LeftDockWidgetArea, dock("Objects", objects_));
  addDockWidget(Qt::LeftDockWidgetArea, dock("Properties", properties_));
  addDockWidget(Qt::BottomDockWidgetArea, dock("Plots", plots_));
  setCorner(Qt::BottomLeftCorner, Qt::LeftDockWidgetArea);
  const auto docks = findChildren<QDockWidget*>();
  resizeDocks({docks[0], docks[1]}, {1, 3}, Qt::Vertical);
  resizeDocks({docks[0], docks[2]}, {300, 150}, Qt::Horizontal);
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
                    [this] { editor_.undo(); });
  redo_ = addAction(edit, "&Redo", QKeySequence::Redo, "Makes the edit again that was taken back",
                    [this] { editor_.redo(); });
  edit->addSeparator();
  QMenu* objects = edit->addMenu("&Add");
  for (const char* kind : {"Sphere", "Box", "Cylinder", "Torus"}) {
    addAction(objects, kind, {}, "Adds one above the scene", [this, kind] {
      select(QString::fromStdString(editor_.add(QString(kind).toLower().toStdString(), top_m())));
    });
  }
  addAction(edit, "&Duplicate", QKeySequence("Ctrl+D"), "Another object like the selected one, beside it",
            [this] { withSelected([this](const std::string& object) { editor_.duplicate(object); }); });
  addAction(edit, "&Delete", QKeySequence::Delete, "Removes the selected object",
            [this] { withSelected([this](const std::string& object) { editor_.remove(object); }); });
}

void MainWindow::makeFileMenu() {
  const auto add = [this](auto... arguments) { return addAction(arguments...); };
  QMenu* file = menuBar()->addMenu("&File");
  add(file, "&Open scene...", QKeySequence::Open, "Takes the objects of a scene file in place of the present ones",
      [this] { files_.open(); });
  add(file, "Open &recording...", QKeySequence("Ctrl+Shift+O"),
      "Shows what a server recorded, on a time line, in place of the server", [this] { replay_->open(); });
  add(file, "Sa&ve scene", QKeySequence("Ctrl+S"), "Writes the scene to the file that was opened or saved last",
      [this] { files_.save(); });
  add(file, "Save scene &as...", QKeySequence("Ctrl+Shift+S"), "Writes a scene file, with its meshes beside it",
      [this] { files_.saveAs(); });
  add(file, "&Save picture", Qt::Key_S, "Writes haptic_view_N.png in this folder", [this] { saveScreenshot(); });
  add(file, "Save p&lots", QKeySequence("Ctrl+L"), "Writes haptic_plots.pdf in this folder",
      [this] { plots_->save("haptic_plots.pdf"); });
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

  makeSessionMenu();
  QMenu* plots = menuBar()->addMenu("&Plots");
  pausePlots_ = add(plots, "&Pause", Qt::Key_Space, "The curves stand still", [] {});
  pausePlots_->setCheckable(true);
  connect(pausePlots_, &QAction::toggled, [this](bool on) { plots_->setPaused(on); });

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
  if (options_.duration_s && now_s >= *options_.duration_s) return end();
  const auto view = replay_->isShown() ? replay_->next(now_s - framed_s_) : newest_();
  framed_s_ = now_s;
  lead(*view, now_s - drawn_s_);
  const bool dirty = view_->takeDirty() || changed(*view) || now_s - drawn_s_ >= kIdleFrame_s;
  if (dirty) {
    scene_.drawFrame(view, now_s);
    if (std::exchange(clicked_, false)) {
      if (const auto place = scene_.probe().found()) select(objectAt(place->position));
    }
    view_shown_ = view;
    drawn_s_ = now_s;
  }
  if (!replay_->isShown()) plot(*view, now_s);
  if (now_s - refreshed_s_ < kRefresh_s) return;
  refreshed_s_ = now_s;
  list(*view);
  refresh(*view);
  if (replay_->isShown()) plots_->replace(replay_->curves());
  plots_->refresh();
}

void MainWindow::plot(const MirrorView& view, double now_s) {
  if (!view.sample || view.sample->tick == plottedTick_) return;
  plottedTick_ = view.sample->tick;
  plots_->add(plotted(*view.sample, now_s));
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
  scene_.probe().aim(view_->isPressed() || isLed || clicked_ ? view_->pointer() : std::nullopt);
  const auto surface = surfaceUnderPointer();
  if (lead_ == Lead::kNone && view_->isPressed() && surface && view.link == LinkState::kLive && !view.isReplay) {
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
  HandSteering::Pointer pointer{.pressed = view_->isPressed(), .surface = surface};
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

void MainWindow::list(const MirrorView& view) {
  if (view.scene->revision() == listedRevision_ && view.epoch == listedEpoch_) return;
  listedRevision_ = view.scene->revision();
  listedEpoch_ = view.epoch;
  const QSignalBlocker quiet(objects_);
  objects_->clear();
  for (const SceneVersion::Object& object : view.scene->objects()) {
    const auto mesh = view.meshes.find(object->mesh);
    QStringList kind;
    if (object->motion) kind << "moves";
    if (object->deformation.softness || object->deformation.lattice) kind << "soft";
    auto* item = new QTreeWidgetItem(
        objects_,
        {text(object->name), mesh == view.meshes.end() ? "..." : QString::number(mesh->second->triangles.size()),
         kind.join(", ")});
    if (text(object->name) == selected_) objects_->setCurrentItem(item);
  }
  for (int column = 0; column < objects_->columnCount(); ++column) objects_->resizeColumnToContents(column);
}

void MainWindow::select(const QString& name) {
  selected_ = name;
  const auto items = objects_->findItems(name, Qt::MatchExactly);
  const QSignalBlocker quiet(objects_);
  objects_->setCurrentItem(items.isEmpty() ? nullptr : items.first());
}

void MainWindow::refresh(const MirrorView& view) {
  properties_->show(selected_.isEmpty() ? nullptr : view.scene->find(selected_.toStdString()), view.mayEdit);
  for (const auto& [action, verb, offer] :
       {std::tuple{undo_, "&Undo ", editor_.undoOffer()}, std::tuple{redo_, "&Redo ", editor_.redoOffer()}}) {
    action->setEnabled(offer.has_value() && !replay_->isShown());
    action->setText(verb + (offer ? text(offer->text) : QString()));
  }
  const bool isReplay = replay_->isShown();
  connection_.refresh(*editor_.view(), isReplay);
  editor_.refuseAll(isReplay                          ? "a replay is shown; go back to the server first"
                    : view.link == LinkState::kClosed ? "not connected to a server"
                                                      : "");
  linkText_->setText(isReplay ? replay_->status() : text(view.linkText));
  sceneText_->setText(QString("revision %1").arg(view.scene->revision()) + (isReplay ? ""
                                                                            : view.hashesEqual
                                                                                ? ", equal to the server's"
                                                                                : ", not equal yet"));
  QString servo = QString("%1 frames/s").arg(scene_.framesPerSecond(), 0, 'f', 0);
  if (view.sample && view.sample->fault != Fault::kNone) servo += ", no force: a fault of the servo";
  servoText_->setText(servo);
  sayHand(view);
}

void MainWindow::sayHand(const MirrorView& view) {
  if (replay_->isShown()) return handText_->setText("the hand is the recorded one");
  const QString press = QString("%1 N").arg(steering_.press_N(), 0, 'f', 1);
  if (!view.hand.refused.empty()) {
    const QString words = "hand: " + text(view.hand.refused);
    if (handText_->text() != words) spdlog::warn("{}", words.toStdString());
    handText_->setText(words);
  } else if (lead_ == Lead::kLed) {
    handText_->setText("the hand is yours, " +
                       (steering_.mapping() == HandSteering::Mapping::kSurface ? "presses with " + press : "in space"));
  } else if (view.hand.led) {
    handText_->setText("hand: led by " + text(view.hand.clientName));
  } else {
    handText_->setText("press on an object to touch it");
  }
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

void MainWindow::showOtherServer() {
  editor_.startAnew();
  files_.forget();
  replay_->leave();
  showOtherSource();
}

/// A server, or a recording.
void MainWindow::showOtherSource() {
  if (replay_->isShown()) letGo();
  lead_ = Lead::kNone;
  select({});
  view_shown_ = nullptr;
  scene_.startAnew();
  plots_->replace({});
  pausePlots_->setChecked(false);
  pausePlots_->setEnabled(!replay_->isShown());
}

void MainWindow::end() {
  ending_ = true;
  close();
  QApplication::quit();  // also out of a dialog
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (ending_ || editor_.isSaved()) return event->accept();
  event->ignore();
  files_.askBeforeLoss("Quitting", [this] { end(); });
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
