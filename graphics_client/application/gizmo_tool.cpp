#include "graphics_client/application/gizmo_tool.h"

#include <QAction>
#include <QGuiApplication>
#include <QMenu>
#include <algorithm>
#include <utility>

#include "common/text/printable.h"
#include "common/wire/parts.h"

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

/// At a spot of an object.
GizmoPicture pictureOf(const SpotState& state, const Pose& object) {
  const Pose frame = state.isInWorld ? Pose{} : object;
  GizmoPicture picture{toWorld(frame, state.point_m.value_or(Vec3(0))), std::nullopt};
  picture.handles = {state.point_m.has_value(), state.direction.has_value()};
  if (state.direction) picture.direction = frame.rotation * *state.direction;
  return picture;
}

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

bool GizmoTool::update(const MirrorView& view, const std::string& object, const std::optional<HandleSpot>& spot,
                       const std::optional<Pixel>& pointer) {
  const SceneVersion::Object record = object.empty() ? nullptr : view.scene->find(object);
  const auto state = spot && record ? spotState(*record, *spot) : std::nullopt;
  const auto present = state ? spot : std::nullopt;
  const bool isAnother = object != object_ || present != spot_;
  if (stepped_ && (Clock::now() - lastStep_ > kPause || isAnother)) finishSteps();
  const auto boxes = scene_.objects().boxes();
  const auto box = std::ranges::find(boxes, object, &NamedBox::name);
  const bool isThere = isOn_ && view.mayEdit && record && box != boxes.end();
  if (!isThere || isAnother) release();
  object_ = isThere ? object : "";
  spot_ = present;
  std::optional<GizmoPicture> picture;
  if (isThere) {
    rest_ = state ? pictureOf(*state, view.poseOf(*record))
                  : GizmoPicture{(box->corners.front() + box->corners.back()) / 2.0, std::nullopt};
    const PictureCamera camera = scene_.cameras().picture();
    if (drag_ && pointer && pointer != draggedTo_) {
      draggedTo_ = pointer;
      const bool turns = drag_->handle().kind == GizmoHandle::Kind::kTurn;
      submit(turns ? "turn " : "move ", drag_->moveTo(camera, placeOf(*pointer)), turns);
    }
    picture = rest_;
    if (drag_) {
      picture->centre = drag_->centre();
      picture->lit = drag_->handle();
    } else if (pointer) {
      picture->lit = Gizmo(camera, rest_.centre, rest_.handles).handleAt(placeOf(*pointer));
    }
  }
  scene_.showGizmo(picture);
  return std::exchange(shown_, picture) != picture;
}

bool GizmoTool::press(const Pixel& pointer) {
  const auto begin = pose();
  if (!begin) return false;
  const PictureCamera camera = scene_.cameras().picture();
  const Gizmo gizmo(camera, rest_.centre, rest_.handles);
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
  beganAt_ = std::make_shared<std::optional<Began>>();
}

/// By as much as it is moved and turned in the picture, from where edits that are under way have it.
void GizmoTool::submit(const char* verb, const Pose& pose, bool turns) {
  const Vec3 by_m = pose.position - begin_.position;
  const Quat turn = pose.rotation * glm::conjugate(begin_.rotation);
  const QString of = !spot_ ? "" : spot_->effect ? "effect of " : "joint of ";
  editor_.drag(verb + of + QString::fromStdString(printable(object_)),
               {.compose = spot_ ? movingSpot(by_m, turn) : moving(by_m, turn, turns), .of = {object_}});
}

Composer GizmoTool::moving(Vec3 by_m, Quat turn, bool turns) const {
  return [object = object_, by_m, turn, turns, from = beganAt_](const MirrorView& view) -> Result<v1::Transaction> {
    const auto record = view.scene->find(object);
    if (!record) return refused("object \"" + object + "\"", "is not there any more");
    if (!*from) *from = Began{view.poseOf(*record), {}};
    const Pose& began = (*from)->pose;
    v1::Transaction transaction;
    v1::SetPose& edit = *transaction.add_operations()->mutable_set_pose();
    edit.mutable_object()->set_name(object);
    toWire(began.position + by_m, *edit.mutable_pose()->mutable_position());
    if (turns) toWire(turn * began.rotation, *edit.mutable_pose()->mutable_rotation());
    return transaction;
  };
}

Composer GizmoTool::movingSpot(Vec3 by_m, Quat turn) const {
  return [object = object_, spot = *spot_, by_m, turn,
          from = beganAt_](const MirrorView& view) -> Result<v1::Transaction> {
    const auto record = view.scene->find(object);
    const auto present = record ? spotState(*record, spot) : std::nullopt;
    if (!present) return refused("object \"" + object + "\"", "has it no more");
    if (!*from) *from = Began{view.poseOf(*record), *present};
    SpotState state = (*from)->spot;
    const Quat toFrame = state.isInWorld ? Quat(1, 0, 0, 0) : glm::conjugate((*from)->pose.rotation);
    if (state.point_m) *state.point_m += toFrame * by_m;
    if (state.direction) {
      state.direction = glm::normalize(toFrame * (turn * (glm::conjugate(toFrame) * *state.direction)));
    }
    v1::Transaction transaction;
    v1::Operation& operation = *transaction.add_operations();
    if (auto done = setSpot(*record, spot, state, operation); !done) return tl::unexpected(std::move(done).error());
    setObject(operation, object);
    return transaction;
  };
}

/// Of what has the gizmo.
std::optional<Pose> GizmoTool::pose() const {
  const auto view = newest_();
  const auto object = object_.empty() ? nullptr : view->scene->find(object_);
  if (!object) return std::nullopt;
  if (spot_) return Pose{{1, 0, 0, 0}, rest_.centre};
  return view->poseOf(*object);
}

}  // namespace haptics
