#include "graphics_client/application/gizmo_tool.h"

#include <QAction>
#include <QGuiApplication>
#include <QMenu>
#include <algorithm>
#include <utility>

#include "common/text/printable.h"

namespace haptics {
namespace {

/// Steps that are farther apart are edits of their own.
constexpr std::chrono::milliseconds kPause{500};

constexpr double kStep_m = 1e-3, kLongStep_m = 1e-2;

struct Step {
  const char* title;
  Qt::Key key;
  Vec3 inPicture;  ///< To the right, up, and into it.
};
const Step kArrowSteps[] = {{"&Left", Qt::Key_Left, {-1, 0, 0}},  {"&Right", Qt::Key_Right, {1, 0, 0}},
                            {"&Up", Qt::Key_Up, {0, 1, 0}},       {"&Down", Qt::Key_Down, {0, -1, 0}},
                            {"&Away", Qt::Key_PageUp, {0, 0, 1}}, {"&Nearer", Qt::Key_PageDown, {0, 0, -1}}};

PicturePoint placeOf(const Pixel& pixel) { return {pixel[0] + 0.5, pixel[1] + 0.5}; }

}  // namespace

void GizmoTool::addActions(QMenu* menu, QWidget* picture) {
  QAction* on = menu->addAction("&Move and turn");
  on->setObjectName("gizmo");
  on->setCheckable(true);
  on->setShortcut(Qt::Key_G);
  on->setToolTip("Handles at the selected object: drag an arrow to move it, a ring to turn it");
  on->setStatusTip(on->toolTip());
  QMenu* steps = menu->addMenu("&Step");
  steps->setEnabled(false);
  QObject::connect(on, &QAction::toggled, [this, steps](bool isOn) {
    isOn_ = isOn;
    steps->setEnabled(isOn);
  });
  for (const Step& step : kArrowSteps) {
    QAction* action = steps->addAction(step.title);
    action->setShortcuts({QKeySequence(step.key), QKeySequence(Qt::ShiftModifier | step.key)});
    action->setShortcutContext(Qt::WidgetShortcut);
    action->setToolTip("Moves the selected object by 1 mm; with Shift by 10 mm");
    action->setStatusTip(action->toolTip());
    picture->addAction(action);
    QObject::connect(action, &QAction::triggered, [this, &step] {
      const bool isLong = QGuiApplication::keyboardModifiers().testFlag(Qt::ShiftModifier);
      this->step(step.inPicture * (isLong ? kLongStep_m : kStep_m));
    });
  }
}

bool GizmoTool::update(const MirrorView& view, const std::string& object, const std::optional<Pixel>& pointer) {
  if (stepped_ && (Clock::now() - lastStep_ > kPause || object != object_)) finishSteps();
  const auto boxes = scene_.objects().boxes();
  const auto box = std::ranges::find(boxes, object, &NamedBox::name);
  const bool isThere = isOn_ && view.mayEdit && !object.empty() && box != boxes.end();
  if (!isThere || object != object_) release();
  object_ = isThere ? object : "";
  std::optional<GizmoPicture> picture;
  if (isThere) {
    centre_ = (box->corners.front() + box->corners.back()) / 2.0;
    const PictureCamera camera = scene_.cameras().picture();
    if (drag_ && pointer && pointer != draggedTo_) {
      draggedTo_ = pointer;
      const bool turns = drag_->handle().kind == GizmoHandle::Kind::kTurn;
      submit(turns ? "turn " : "move ", drag_->moveTo(camera, placeOf(*pointer)), turns);
    }
    picture = GizmoPicture{drag_ ? drag_->centre() : centre_, std::nullopt};
    if (drag_) {
      picture->lit = drag_->handle();
    } else if (pointer) {
      picture->lit = Gizmo(camera, centre_).handleAt(placeOf(*pointer));
    }
  }
  scene_.showGizmo(picture);
  return std::exchange(shown_, picture) != picture;
}

bool GizmoTool::press(const Pixel& pointer) {
  const auto begin = pose();
  if (!begin) return false;
  const PictureCamera camera = scene_.cameras().picture();
  const Gizmo gizmo(camera, centre_);
  const auto handle = gizmo.handleAt(placeOf(pointer));
  if (!handle) return false;
  finishSteps();
  this->begin(*begin);
  drag_.emplace(*handle, gizmo, *begin, camera, placeOf(pointer));
  draggedTo_ = pointer;
  return true;
}

bool GizmoTool::release() {
  if (!drag_) return false;
  drag_.reset();
  editor_.finishDrag();
  return true;
}

/// By so many metres along the picture's right, its up and the line of sight. Nothing while it is off.
void GizmoTool::step(Vec3 inPicture_m) {
  if (drag_) return;
  if (!stepped_) {
    stepped_ = pose();
    if (!stepped_) return;
    begin(*stepped_);
  }
  const PictureCamera camera = scene_.cameras().picture();
  stepped_->position += camera.right * inPicture_m.x + camera.up * inPicture_m.y + camera.into * inPicture_m.z;
  lastStep_ = Clock::now();
  submit("move ", *stepped_, false);
}

void GizmoTool::finishSteps() {
  if (std::exchange(stepped_, std::nullopt)) editor_.finishDrag();
}

void GizmoTool::begin(const Pose& pose) {
  begin_ = pose;
  beganAt_ = std::make_shared<std::optional<Pose>>();
}

/// By as much as it is moved and turned in the picture, from where edits that are under way have it.
void GizmoTool::submit(const char* verb, const Pose& pose, bool turns) {
  const Vec3 by_m = pose.position - begin_.position;
  const Quat turn = pose.rotation * glm::conjugate(begin_.rotation);
  const Composer compose = [object = object_, by_m, turn, turns,
                            from = beganAt_](const MirrorView& view) -> Result<v1::Transaction> {
    const auto record = view.scene->find(object);
    if (!record) return refused("object \"" + object + "\"", "is not there any more");
    if (!*from) *from = view.poseOf(*record);
    v1::Transaction transaction;
    v1::SetPose& edit = *transaction.add_operations()->mutable_set_pose();
    edit.mutable_object()->set_name(object);
    const Vec3 place = (*from)->position + by_m;
    v1::Vector3& position = *edit.mutable_pose()->mutable_position();
    position.set_x(place.x);
    position.set_y(place.y);
    position.set_z(place.z);
    if (!turns) return transaction;
    const Quat turned = turn * (*from)->rotation;
    v1::Quaternion& rotation = *edit.mutable_pose()->mutable_rotation();
    rotation.set_w(turned.w);
    rotation.set_x(turned.x);
    rotation.set_y(turned.y);
    rotation.set_z(turned.z);
    return transaction;
  };
  editor_.drag(verb + QString::fromStdString(printable(object_)), {.compose = compose, .of = {object_}});
}

/// Of the object that has the gizmo.
std::optional<Pose> GizmoTool::pose() const {
  const auto view = newest_();
  const auto object = object_.empty() ? nullptr : view->scene->find(object_);
  if (!object) return std::nullopt;
  return view->poseOf(*object);
}

}  // namespace haptics
