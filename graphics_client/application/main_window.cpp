#include "graphics_client/application/main_window.h"

#include <QAction>
#include <QApplication>
#include <QCloseEvent>
#include <QDockWidget>
#include <QFileDialog>
#include <QLabel>
#include <QMenuBar>
#include <QScreen>
#include <QScrollArea>
#include <QSettings>
#include <QStatusBar>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/log/log.h"
#include "graphics_client/application/file_drop.h"
#include "graphics_client/application/plotted_sample.h"
#include "graphics_client/application/printable_text.h"

namespace haptics {
namespace {

/// How often words and curves change (seconds).
constexpr double kRefresh_s = 0.1;
/// A picture that nothing has changed is drawn anew after so long: its words may have aged (seconds).
constexpr double kIdleFrame_s = 2;
/// In space: of the hand, for a click of the wheel (metres).
constexpr double kStepPerClick_m = 0.004;
constexpr int kMessage_ms = 5000, kLongMessage_ms = 20'000;
/// Between the objects and one that is added (metres).
constexpr double kBeside_m = 0.01;
/// No object's name: of the import that is under way.
constexpr const char* kImport = "(import)";
/// Of a window's frame and title, which a window manager adds.
constexpr int kFrame_px = 8, kTitle_px = 40;
constexpr int kLowScreen_px = 800;  // where the list of keys would cover the objects
constexpr const char* kMeshFiles =
    "Meshes (*.obj *.ply *.stl *.off *.om *.iv *.wrl *.vrml *.wrz *.gltf *.glb *.dae *.zae *.3mf *.3ds *.fbx *.x3d "
    "*.x3dz *.x3dv *.x3dvz *.mesh *.gz "
    "*.OBJ *.PLY *.STL *.OFF *.OM *.IV *.WRL *.GLTF *.GLB *.DAE *.ZAE *.3MF *.3DS *.FBX *.X3D *.GZ);;All files (*)";

/// Whether the picture of a hand would be another one.
[[nodiscard]] bool looksOther(const TelemetrySample& now, const TelemetrySample& then) {
  return now.hip != then.hip || now.ihip != then.ihip || now.force.written != then.force.written ||
         now.object != then.object || now.frictionState != then.frictionState || now.fault != then.fault;
}

}  // namespace

MainWindow::MainWindow(const ViewerOptions& options, ServerLink& link,
                       std::function<std::shared_ptr<const MirrorView>()> newest)
    : options_(options),
      link_(link),
      newest_(std::move(newest)),
      scene_(options),
      view_(new ViewWidget(scene_)),
      hand_(link, scene_, view_, options.hand),
      objects_(new ObjectList),
      properties_(new PropertyPanel),
      plots_(new PlotPanel),
      linkText_(new QLabel),
      sceneText_(new QLabel),
      servoText_(new QLabel),
      handText_(new QLabel),
      editor_(
          this, link, [this](auto... words) { say(words...); },
          [this](const v1::Accepted& accepted) { objects_->addWarnings(accepted); }, [this] { enableActions(); }),
      files_(this, editor_),
      connection_(this, link, files_),
      replay_(new ReplayPanel),
      gizmo_(scene_, editor_, newest_),
      importer_(new MeshImporter(link, editor_)),
      advisor_(new Advisor),
      watchdog_(link),
      tools_(scene_),
      pictures_(new PictureFiles(view_, scene_, [this] { return replay_->session(); })) {
  setWindowTitle("Haptic viewer");
  auto* centre = new QWidget;
  auto* rows = new QVBoxLayout(centre);
  rows->setContentsMargins(0, 0, 0, 0);
  rows->setSpacing(0);
  rows->addWidget(connection_.notice());
  rows->addWidget(view_, 1);
  rows->addWidget(replay_);
  setCentralWidget(centre);
  const bool isLow = screen()->availableSize().height() < kLowScreen_px;
  if (isLow && scene_.overlay().isHelpVisible()) scene_.overlay().toggleHelp();
  makeDocks();
  makeMenus();
  restoreLayout();
  for (QLabel* label : {linkText_, sceneText_, servoText_, handText_}) {
    label->setTextFormat(Qt::PlainText);
    label->setMinimumWidth(1);
    statusBar()->addWidget(label);
  }
  statusBar()->addPermanentWidget(importer_);
  statusBar()->addPermanentWidget(advisor_);
  statusBar()->addPermanentWidget(pictures_);
  connect(advisor_, &Advisor::said, [this](auto... words) { say(words...); });
  connect(importer_, &MeshImporter::failed, [this](auto file, auto why) { say("import " + file, why, true); });
  connect(importer_, &MeshImporter::imported, [this](const QString& object, const QString& report) {
    for (const QString& line : report.split('\n')) {
      logInfo(("import " + object + ": " + line).toStdString());
    }
    select(object);
    report_ = report;
    if (auto placed = placed_.extract(kImport)) {
      placed.key() = object.toStdString();
      placed_.insert(std::move(placed));
    }
  });
  connect(new FileDrop(this), &FileDrop::dropped, [this](auto files, auto place) { drop(files, place); });
  connect(view_, &ViewWidget::pressed, [this] {
    if (gizmo_.press(*view_->pointer())) return;
    hand_.press();
  });
  connect(view_, &ViewWidget::released, [this](bool moved) { clicked_ = !gizmo_.release() && !moved; });
  connect(view_, &ViewWidget::wheelTurned, [this](double clicks) {
    if (hand_.steering().mapping() == HandSteering::Mapping::kSurface) {
      hand_.steering().changePress(clicks);
    } else {
      hand_.steering().moveBy(scene_.cameras().direction() * (kStepPerClick_m * clicks));
    }
  });
  connect(view_, &ViewWidget::gripperTurned, [this](double clicks) { hand_.openGripper(*newest_(), clicks); });
  connect(view_, &ViewWidget::turned, [this](double right_px, double up_px) { hand_.turn(right_px, up_px); });
  connect(properties_, &PropertyPanel::finished, [this] { editor_.finishDrag(); });
  connect(properties_, &PropertyPanel::edited,
          [this](const QString& edit, const Edit& value) { editor_.drag(edit, value); });
  connect(properties_, &PropertyPanel::renamed, [this](const QString& object, const QString& wanted) {
    editor_.rename(object.toStdString(), wanted.toStdString(), [this, object, wanted] {
      if (selected_ == object || selected_.isEmpty()) select(wanted);
    });
  });
  connect(properties_, &PropertyPanel::uploaded,
          [this](const QString& edit, const Edit& change) { editor_.submit(edit, change); });
  connect(objects_, &ObjectList::selected, [this](const QString& name) { select(name); });
  connect(objects_, &ObjectList::hiddenChanged, [this](const std::set<std::string>& names) {
    scene_.hide(names);
    view_shown_ = nullptr;
  });
  connect(&files_, &SceneFiles::said, [this](auto... words) { say(words...); });
  connect(&files_, &SceneFiles::restarted, [this] {
    editor_.startAnew();
    files_.forget();
    select({});
  });
  const auto sayLong = [this](const QString& what, const QString& words, bool isError) {
    say(what, words, isError);
    statusBar()->showMessage(what + ": " + words, kLongMessage_ms);
  };
  connect(&connection_, &ConnectionControl::said, sayLong);
  connect(pictures_, &PictureFiles::said, sayLong);
  connect(&tools_, &ViewTools::changed, [this] { view_shown_ = nullptr; });
  connect(&tools_, &ViewTools::measuring, [this] { hand_.letGo(); });
  connect(&connection_, &ConnectionControl::replaced, [this] { showOtherServer(); });
  connect(replay_, &ReplayPanel::said, [this](auto... words) { say(words...); });
  connect(replay_, &ReplayPanel::changed, [this] { showOtherSource(); });
  connect(&timer_, &QTimer::timeout, [this] { frame(); });
  timer_.setTimerType(Qt::PreciseTimer);
  timer_.start(static_cast<int>(1000 / options.frameLimit_Hz));
  view_->setFocus();
}

void MainWindow::restoreLayout() {
  resize(options_.width_px, options_.height_px);
  if (options_.isSizeGiven) return;
  const QSettings from("haptics", "graphics_client");
  if (restoreGeometry(from.value("geometry").toByteArray())) restoreState(from.value("layout").toByteArray());
  resize(size().boundedTo(screen()->availableSize() - QSize(2 * kFrame_px, kTitle_px)));  // also where that was another
}

void MainWindow::saveLayout() const {
  if (options_.isSizeGiven) return;
  QSettings to("haptics", "graphics_client");
  to.setValue("geometry", saveGeometry());
  to.setValue("layout", saveState());
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
  const bool gizmoChanged = gizmo_.update(*view, replay_->isShown() ? std::string() : selected_.toStdString(),
                                          properties_->spot(), view_->pointer());
  editor_.advance();
  lead(*view, now_s - drawn_s_);
  const bool dirty = view_->takeDirty() || gizmoChanged || changed(*view) || now_s - drawn_s_ >= kIdleFrame_s;
  if (dirty) {
    scene_.drawFrame(view, now_s);
    if (std::exchange(clicked_, false)) {
      const auto place = scene_.probe().found();
      if (place && tools_.isMeasuring()) tools_.measureAt(*place);
      if (place && !tools_.isMeasuring()) select(QString::fromStdString(scene_.objects().objectAt(place->position)));
    }
    import(std::exchange(dropped_, {}), surfaceUnderPointer());
    view_shown_ = view;
    drawn_s_ = now_s;
  }
  pictures_->film(now_s);
  if (!replay_->isShown()) plot(*view, now_s);
  if (now_s - refreshed_s_ < kRefresh_s) return;
  refreshed_s_ = now_s;
  objects_->show(*view);
  refresh(view);
  if (replay_->isShown()) plots_->replace(replay_->curves());
  plots_->refresh();
}

void MainWindow::plot(const MirrorView& view, double now_s) {
  if (!view.sample || view.sample->tick == plottedTick_) return;
  plottedTick_ = view.sample->tick;
  plots_->add(plotted(*view.sample, now_s));
}

/// What can be done now. Undo also where it is refused: it says why.
void MainWindow::enableActions() {
  const bool mayEdit = !replay_->isShown(), isBusy = editor_.isBusy();
  undo_->setEnabled(mayEdit && (isBusy || editor_.undoOffer()));
  redo_->setEnabled(mayEdit && (isBusy || editor_.redoOffer()));
  cancelImport_->setEnabled(importer_->canCancel());
  cancelAdvice_->setEnabled(advisor_->isBusy());
}

/// Whether the picture would be another one.
bool MainWindow::changed(const MirrorView& view) const {
  if (!view_shown_) return true;
  const MirrorView& before = *view_shown_;
  if (view.link != before.link || view.scene != before.scene || view.assetBytes != before.assetBytes ||
      view.sample.has_value() != before.sample.has_value() || scene_.objects().isSettling() || scene_.isMoving()) {
    return true;
  }
  if (!view.sample) return false;
  return looksOther(*view.sample, *before.sample) || view.secondHand.has_value() != before.secondHand.has_value() ||
         (view.secondHand && looksOther(*view.secondHand, *before.secondHand)) || view.bodies != before.bodies ||
         view.shapes != before.shapes || view.dents != before.dents;
}

/// Leads the hand where the pointer is, and has the next frame look what is there.
void MainWindow::lead(const MirrorView& view, double dt_s) {
  const bool touches = view_->isPressed() && !gizmo_.isDragging() && !tools_.isMeasuring();
  const bool looks = tools_.isMeasuring() || touches || hand_.isLed(view) || clicked_ || !dropped_.isEmpty();
  scene_.probe().aim(looks ? view_->pointer() : std::nullopt);
  hand_.lead(view, touches, gizmo_.isDragging() ? std::nullopt : surfaceUnderPointer(), dt_s);
}

/// Of an object: the floor is none.
std::optional<SurfacePoint> MainWindow::surfaceUnderPointer() {
  const auto place = scene_.probe().found();
  if (!place || scene_.objects().objectAt(place->position).empty()) return std::nullopt;
  return place;
}

void MainWindow::select(const QString& name) {
  selected_ = name;
  for (QAction* action : ofSelected_) action->setEnabled(!name.isEmpty());
  objects_->select(name);
  scene_.select({name.toStdString()});
  tools_.select(name.toStdString());
  view_shown_ = nullptr;
}

void MainWindow::refresh(const std::shared_ptr<const MirrorView>& now) {
  const MirrorView& view = *now;
  const SceneVersion::Object object = selected_.isEmpty() ? nullptr : view.scene->find(selected_.toStdString());
  std::set<std::string> others = objects_->others();
  std::erase_if(others, [&](const std::string& name) { return !view.scene->find(name); });
  properties_->show(object, others, now, scene_.objects().floor_m());
  others.insert(selected_.toStdString());
  scene_.select(std::move(others));
  properties_->setAdvice(object ? advisor_->adviceOn(*object) : QString());
  if (!report_.isEmpty() && object) {
    properties_->say(std::exchange(report_, {}), false);
  }
  for (const auto& [action, verb, offer] :
       {std::tuple{undo_, "&Undo ", editor_.undoOffer()}, std::tuple{redo_, "&Redo ", editor_.redoOffer()}}) {
    action->setText(verb + (offer ? text(offer->text) : QString()));
  }
  files_.follow();
  const bool isReplay = replay_->isShown();
  connection_.refresh(*editor_.view(), isReplay || replay_->isLoading());
  editor_.refuseAll(isReplay                          ? "a replay is shown; go back to the server first"
                    : view.link == LinkState::kClosed ? "not connected to a server"
                                                      : "");
  const QString link = isReplay ? replay_->status() : text(view.linkText);
  linkText_->setText(fontMetrics().elidedText(link, Qt::ElideRight, isReplay ? width() * 3 / 4 : width() / 2));
  linkText_->setToolTip(link);
  const QString equality = isReplay                        ? ""
                           : view.link != LinkState::kLive ? ", the last that is known"
                           : view.hashesEqual              ? ", equal to the server's"
                                                           : ", not equal yet";
  sceneText_->setText(view.epoch == 0 && !isReplay ? QString()
                                                   : QString("revision %1").arg(view.scene->revision()) + equality);
  QString servo = scene_.framesPerSecond() < kIdleRate_Hz
                      ? QString("idle")
                      : QString("%1 frames/s").arg(scene_.framesPerSecond(), 0, 'f', 0);
  if (scene_.objects().isCoarse()) servo += ", coarser while the picture moves";
  if (view.sample && view.sample->fault != Fault::kNone) servo += ", no force: a fault of the servo";
  if (const QString watchdog = watchdog_.words(view); !watchdog.isEmpty()) servo += ", " + watchdog;
  servoText_->setText(servo);
  sayHand(view);
}

void MainWindow::sayHand(const MirrorView& view) {
  if (replay_->isShown()) return handText_->setText("the hand is the recorded one");
  if (tools_.isMeasuring()) return handText_->setText(tools_.measured());
  const QString words = hand_.words(view);
  if (!view.hand.refused.empty() && handText_->text() != words) logWarning(words.toStdString());
  handText_->setText(words);
  for (QLabel* label : {sceneText_, servoText_, handText_}) label->setToolTip(label->text());
}

Vec3 MainWindow::placeOnFloor(const std::string& name, Vec3 size_m) {
  std::vector<FloorBox> taken;
  for (const NamedBox& box : scene_.objects().boxes()) {
    placed_.erase(box.name);
    FloorBox& its = taken.emplace_back(FloorBox{box.corners[0], box.corners[0]});
    for (const Vec3& corner : box.corners) {
      its.low = glm::min(its.low, glm::dvec2(corner));
      its.high = glm::max(its.high, glm::dvec2(corner));
    }
  }
  for (const auto& [waiting, box] : placed_) taken.push_back(box);
  const glm::dvec2 side(size_m), middle = freePlace(taken, side, kBeside_m);
  placed_[name] = {middle - side / 2.0, middle + side / 2.0};
  return {middle, scene_.objects().floor_m()};
}

void MainWindow::withSelected(const std::function<void(const std::set<std::string>&)>& does) {
  if (selected_.isEmpty()) return properties_->say("No object is selected", true);
  std::set<std::string> names = objects_->others();
  names.insert(selected_.toStdString());
  does(names);
}

void MainWindow::say(const QString& edit, const QString& words, bool isError) {
  properties_->say(edit + ": " + words, isError);
  if (!isError) return;
  placed_.clear();  // what was not added takes no place
  statusBar()->showMessage(edit + ": " + words, kMessage_ms);
  logWarning((edit + ": " + words).toStdString());
}

void MainWindow::finish() {
  pictures_->finish();
  importer_->finish();
  advisor_->finish();
  editor_.finish();
}

void MainWindow::askForAdvice() {
  if (!editor_.refusal().empty()) return say("advice", QString::fromStdString(editor_.refusal()), true);
  advisor_->ask(editor_.view());
}

void MainWindow::importMesh() {
  import(QFileDialog::getOpenFileNames(this, "Import mesh", {}, kMeshFiles), std::nullopt);
}

/// Meshes come where the pointer is once the next frame has found the surface there.
void MainWindow::drop(const QStringList& files, const QPoint& place) {
  QStringList meshes;
  for (const QString& file : files) {
    if (file.endsWith(".scene", Qt::CaseInsensitive)) {
      files_.open(file);
    } else {
      meshes << file;
    }
  }
  const QPoint inView = view_->mapFrom(this, place);
  if (!view_->rect().contains(inView)) return import(meshes, std::nullopt);
  view_->pointTo(inView);
  dropped_ += meshes;
}

/// Onto a surface, else on the floor.
void MainWindow::import(const QStringList& files, const std::optional<SurfacePoint>& onto) {
  for (const QString& file : files) {
    importer_->import(file,
                      [this, onto](Vec3 size_m) { return onto ? onto->position : placeOnFloor(kImport, size_m); });
  }
}

void MainWindow::showOtherServer() {
  editor_.startAnew();
  importer_->startAnew();
  files_.forget();
  replay_->leave();
  showOtherSource();
}

/// A server, or a recording.
void MainWindow::showOtherSource() {
  if (replay_->isShown()) hand_.letGo();
  hand_.startAnew();
  select({});
  view_shown_ = nullptr;
  scene_.startAnew();
  plots_->replace({});
  pausePlots_->setChecked(false);
  pausePlots_->setEnabled(!replay_->isShown());
}

void MainWindow::end() {
  ending_ = true;
  saveLayout();
  close();
  QApplication::quit();  // also out of a dialog
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (ending_) return event->accept();
  if (editor_.isSaved()) {
    saveLayout();
    return event->accept();
  }
  event->ignore();
  files_.askBeforeLoss("Quitting", [this] { end(); });
}

}  // namespace haptics

#include "moc_main_window.cpp"
