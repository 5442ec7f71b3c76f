#include "graphics_client/application/view_tools.h"

#include <QAction>
#include <QKeySequence>
#include <QMenu>
#include <QSettings>
#include <limits>
#include <string>

#include "common/log/log.h"
#include "graphics_client/application/measure.h"

namespace haptics {
namespace {

constexpr double kCutStep_m = 0.002;

/// Of the looks that are kept, between runs.
QString keyOf(int number) { return QString("look%1").arg(number); }

void keep(int number, const CameraRig::Look& look) {
  QVariantList numbers;
  for (const Vec3& place : {look.eye, look.focus}) numbers << place.x << place.y << place.z;
  QSettings("haptics", "graphics_client").setValue(keyOf(number), numbers);
}

/// Nothing: none is kept, or the file of the settings was spoilt.
std::optional<CameraRig::Look> kept(int number) {
  const QVariantList numbers = QSettings("haptics", "graphics_client").value(keyOf(number)).toList();
  if (numbers.size() != 6) return std::nullopt;
  const auto at = [&](int i) {
    return Vec3(numbers[i].toDouble(), numbers[i + 1].toDouble(), numbers[i + 2].toDouble());
  };
  const CameraRig::Look look{at(0), at(3)};
  const double distance_m = glm::distance(look.eye, look.focus);
  if (!(distance_m > 0) || !(distance_m < std::numeric_limits<double>::infinity())) return std::nullopt;
  return look;
}

}  // namespace

void ViewTools::addLooks(QMenu* menu, const AddAction& add) {
  add(menu, "Show &all", Qt::Key_R, "Moves the camera so that all objects are seen", [this] { scene_.frameAll(); });
  struct Look {
    const char* title;
    Qt::Key key;
    Vec3 direction;
  };
  // Not quite down: there the z axis has no up.
  static const Look kLooks[] = {{"F&ront", Qt::Key_1, {0, 1, 0}},
                                {"R&ight", Qt::Key_2, {-1, 0, 0}},
                                {"&Back", Qt::Key_3, {0, -1, 0}},
                                {"&Left", Qt::Key_4, {1, 0, 0}},
                                {"&Top", Qt::Key_5, glm::normalize(Vec3(0, 0.02, -1))},
                                {"Three &quarters", Qt::Key_6, CameraRig::kFirstDirection}};
  QMenu* looks = menu->addMenu("Look &from");
  for (const Look& look : kLooks) {
    add(looks, look.title, look.key, "Shows all objects from there",
        [this, &look] { scene_.frameAll(look.direction); });
  }
  addKeptLooks(menu, add);
}

void ViewTools::addKeptLooks(QMenu* menu, const AddAction& add) {
  QMenu* views = menu->addMenu("Kept &views");
  for (int number = 1; number <= kKeptLooks; ++number) {
    const int key = Qt::Key_F5 + number - 1;
    add(views, QString("View &%1").arg(number), QKeySequence(key), "Looks from where the view was kept", [=, this] {
      if (const auto look = kept(number)) scene_.lookAs(*look);
      emit changed();
    });
    add(views, QString("&Keep view %1").arg(number), QKeySequence(static_cast<int>(Qt::SHIFT) | key),
        "Keeps from where the picture is seen, for this and later runs", [=, this] {
          keep(number, scene_.cameras().look());
          logInfo("view " + std::to_string(number) + " is kept");
        });
  }
}

void ViewTools::addTools(QMenu* menu, const AddAction& add) {
  const auto addSwitch = [&](auto... arguments) {
    QAction* action = add(menu, arguments...);
    action->setCheckable(true);
  };
  addSwitch("&Measure", Qt::Key_M, "Click places: two for a distance, a third for the angle at the second",
            [this] { measure(!measuring_); });
  addSwitch("C&ut", Qt::Key_X, "Leaves out what is in front of the selected object's middle", [this] { cut(!cut_); });
  add(menu, "Cut &deeper", QKeySequence("Shift+X"), "By 2 mm", [this] { moveCut(kCutStep_m); });
  add(menu, "Cut le&ss deep", QKeySequence("Ctrl+Shift+X"), "By 2 mm", [this] { moveCut(-kCutStep_m); });
}

void ViewTools::measure(bool on) {
  measuring_ = on;
  measured_.clear();
  scene_.showMeasured({});
  if (on) emit measuring();
  emit changed();
}

void ViewTools::measureAt(const SurfacePoint& place) {
  if (measured_.size() >= kMaxMeasured) measured_.clear();
  measured_.push_back(place.position);
  scene_.showMeasured(measured_);
  logInfo(measureText(measured_, place.position));
  emit changed();
}

QString ViewTools::measured() const {
  const auto place = scene_.probe().found();
  return QString::fromStdString(measureText(measured_, place ? std::optional(place->position) : std::nullopt));
}

/// Through the middle of the selected object, else of all, across the line of sight.
void ViewTools::cut(bool on) {
  cut_.reset();
  if (on) {
    Vec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const NamedBox& box : scene_.objects().boxes()) {
      if (!selected_.empty() && box.name != selected_) continue;
      for (const Vec3& corner : box.corners) {
        low = glm::min(low, corner);
        high = glm::max(high, corner);
      }
    }
    if (low.x <= high.x) cut_ = CutPlane{(low + high) / 2.0, scene_.cameras().direction()};
  }
  scene_.cut(cut_);
  emit changed();
}

void ViewTools::moveCut(double way_m) {
  if (!cut_) return;
  cut_->point += way_m * cut_->normal;
  scene_.cut(cut_);
  emit changed();
}

}  // namespace haptics

#include "moc_view_tools.cpp"
