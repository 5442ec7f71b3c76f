#include "graphics_client/application/property_panel.h"

#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QSlider>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "common/wire/convert.h"

namespace haptics {
namespace {

v1::Material& materialIn(v1::Operation& operation) { return *operation.mutable_set_material()->mutable_material(); }

double degrees(double radians) { return radians * 180 / std::numbers::pi; }
double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// A number of an object, and the edit that sets it. Nothing: the object has none, and the row is off.
struct Number {
  const char* label;
  const char* tip;
  const char* unit;
  double least, most;
  int decimals;
  bool logarithmic;  ///< Its slider; least > 0.
  std::optional<double> (*get)(const ObjectRecord&);
  void (*set)(const ObjectRecord&, double value, v1::Operation&);
};

template <int kAxis>
std::optional<double> position_mm(const ObjectRecord& object) {
  return 1e3 * object.pose.position[kAxis];
}

template <int kAxis>
void setPosition_mm(const ObjectRecord& object, double value, v1::Operation& operation) {
  Vec3 place = object.pose.position;
  place[kAxis] = 1e-3 * value;
  v1::Vector3& position = *operation.mutable_set_pose()->mutable_pose()->mutable_position();
  position.set_x(place.x);
  position.set_y(place.y);
  position.set_z(place.z);
}

template <int kAxis>
std::optional<double> angle_deg(const ObjectRecord& object) {
  return degrees(glm::eulerAngles(object.pose.rotation)[kAxis]);
}

template <int kAxis>
void setAngle_deg(const ObjectRecord& object, double value, v1::Operation& operation) {
  Vec3 angles = glm::eulerAngles(object.pose.rotation);
  angles[kAxis] = radians(value);
  const Quat rotation(angles);
  v1::Quaternion& message = *operation.mutable_set_pose()->mutable_pose()->mutable_rotation();
  message.set_w(rotation.w);
  message.set_x(rotation.x);
  message.set_y(rotation.y);
  message.set_z(rotation.z);
}

void setFriction(const ObjectRecord& object, double mu_static, double mu_dynamic, v1::Operation& operation) {
  static_cast<void>(object);
  v1::Friction& friction = *materialIn(operation).mutable_friction();
  friction.set_mu_static(mu_static);
  friction.set_mu_dynamic(std::min(mu_static, mu_dynamic));
}

bool hasPlainFriction(const ObjectRecord& object) {
  const auto& friction = object.material.surface.friction;
  return !friction || std::holds_alternative<std::monostate>(friction->over);
}

double muStatic(const ObjectRecord& object) {
  const auto& friction = object.material.surface.friction;
  return friction ? friction->mu_static : 0;
}

double muDynamic(const ObjectRecord& object) {
  const auto& friction = object.material.surface.friction;
  return friction ? friction->mu_dynamic : 0;
}

const Number kNumbers[] = {
    {"x", "Where the object is, world frame", " mm", -2000, 2000, 1, false, position_mm<0>, setPosition_mm<0>},
    {"y", "Where the object is, world frame", " mm", -2000, 2000, 1, false, position_mm<1>, setPosition_mm<1>},
    {"z", "Where the object is, world frame", " mm", -2000, 2000, 1, false, position_mm<2>, setPosition_mm<2>},
    {"turn x", "How the object is turned: about x, then y, then z", "°", -180, 180, 1, false, angle_deg<0>,
     setAngle_deg<0>},
    {"turn y", "How the object is turned: about x, then y, then z", "°", -90, 90, 1, false, angle_deg<1>,
     setAngle_deg<1>},
    {"turn z", "How the object is turned: about x, then y, then z", "°", -180, 180, 1, false, angle_deg<2>,
     setAngle_deg<2>},
    {"stiffness", "Of the surface. More than the device bears is felt as what it bears", " N/m", 10, 20'000, 0, true,
     [](const ObjectRecord& object) { return std::optional(object.material.stiffness_N_per_m); },
     [](const ObjectRecord& /*object*/, double value, v1::Operation& operation) {
       materialIn(operation).set_stiffness_n_per_m(value);
     }},
    {"damping", "Of the motion into the surface", " N s/m", 0, 20, 2, false,
     [](const ObjectRecord& object) { return std::optional(object.material.damping_Ns_per_m); },
     [](const ObjectRecord& /*object*/, double value, v1::Operation& operation) {
       materialIn(operation).set_damping_ns_per_m(value);
     }},
    {"shading", "Force shading: lines flatter than this angle are felt as rounded; 0: none", "°", 0, 180, 0, false,
     [](const ObjectRecord& object) {
       const auto& shading = object.material.surface.shading;
       return std::optional(shading ? degrees(shading->crease_rad) : 0);
     },
     [](const ObjectRecord& /*object*/, double value, v1::Operation& operation) {
       v1::Shading& shading = *materialIn(operation).mutable_shading();
       if (value > 0) shading.set_crease_rad(radians(value));
     }},
    {"static friction", "Coefficient up to which the hand sticks; 0: none", "", 0, 3, 2, false,
     [](const ObjectRecord& object) {
       return hasPlainFriction(object) ? std::optional(muStatic(object)) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       setFriction(object, value, muDynamic(object), operation);
     }},
    {"dynamic friction", "Coefficient while the hand slides, not above the static one", "", 0, 3, 2, false,
     [](const ObjectRecord& object) {
       return hasPlainFriction(object) ? std::optional(muDynamic(object)) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       setFriction(object, std::max(muStatic(object), value), value, operation);
     }},
    {"texture height", "Amplitude of the texture", " mm", 0.01, 5, 2, true,
     [](const ObjectRecord& object) {
       const auto& texture = object.material.surface.texture;
       return texture ? std::optional(1e3 * texture->amplitude_m) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       v1::ObjectState state;
       toWire(object, state);
       *materialIn(operation).mutable_texture() = state.texture();
       materialIn(operation).mutable_texture()->set_amplitude_m(1e-3 * value);
     }},
    {"tissue stiffness", "Of a soft object, in series with that of its surface", " N/m", 10, 5'000, 0, true,
     [](const ObjectRecord& object) {
       const auto& softness = object.deformation.softness;
       return softness ? std::optional(softness->stiffness_N_per_m) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       v1::ObjectState state;
       toWire(object, state);
       auto& softness = *operation.mutable_set_deformation()->mutable_deformation()->mutable_softness();
       softness = state.deformation().softness();
       softness.set_stiffness_n_per_m(value);
     }},
};

/// A slider and a field for a number.
class NumberRow : public PropertyPanel::Row {
 public:
  using Change = std::function<void(double)>;

  NumberRow(const Number& number, QFormLayout* form, Change change, const std::function<void()>& finished)
      : number_(number), box_(new QDoubleSpinBox), slider_(new QSlider(Qt::Horizontal)) {
    box_->setObjectName(number.label);
    box_->setRange(number.least, number.most);
    box_->setDecimals(number.decimals);
    box_->setSuffix(QString::fromUtf8(number.unit));
    box_->setKeyboardTracking(false);
    box_->setToolTip(number.tip);
    box_->setAccessibleName(number.label);
    slider_->setObjectName(QString(number.label) + " slider");
    slider_->setRange(0, kSteps);
    slider_->setToolTip(number.tip);
    slider_->setAccessibleName(QString(number.label) + " slider");
    auto* row = new QWidget;
    auto* layout = new QHBoxLayout(row);
    layout->setContentsMargins(0, 0, 0, 0);
    layout->addWidget(slider_, 1);
    layout->addWidget(box_);
    form->addRow(number.label, row);
    QObject::connect(slider_, &QSlider::valueChanged, [this, change](int step) {
      const double value = valueAt(step);
      const QSignalBlocker quiet(box_);
      box_->setValue(value);
      change(value);
    });
    QObject::connect(slider_, &QSlider::sliderReleased, finished);
    QObject::connect(box_, QOverload<double>::of(&QDoubleSpinBox::valueChanged),
                     [this, change, finished](double value) {
                       const QSignalBlocker quiet(slider_);
                       slider_->setValue(stepAt(value));
                       change(value);
                       finished();
                     });
  }

  [[nodiscard]] bool isHeld() const override { return slider_->isSliderDown() || box_->hasFocus(); }

  void show(const ObjectRecord& object) override {
    const std::optional<double> value = number_.get(object);
    box_->setEnabled(value.has_value());
    slider_->setEnabled(value.has_value());
    const QSignalBlocker quietBox(box_), quietSlider(slider_);
    box_->setValue(value.value_or(number_.least));
    slider_->setValue(stepAt(value.value_or(number_.least)));
  }

 private:
  static constexpr int kSteps = 1000;

  [[nodiscard]] double valueAt(int step) const {
    const double share = double(step) / kSteps;
    return number_.logarithmic ? number_.least * std::pow(number_.most / number_.least, share)
                               : number_.least + share * (number_.most - number_.least);
  }
  [[nodiscard]] int stepAt(double value) const {
    const double within = std::clamp(value, number_.least, number_.most);
    const double share = number_.logarithmic ? std::log(within / number_.least) / std::log(number_.most / number_.least)
                                             : (within - number_.least) / (number_.most - number_.least);
    return static_cast<int>(std::lround(kSteps * share));
  }

  const Number& number_;
  QDoubleSpinBox* box_;
  QSlider* slider_;
};

/// Textures to choose from, in their usual sizes.
struct Family {
  const char* name;
  void (*make)(v1::ScalarField&);
  bool (*is)(const FieldFamily&);
};

const Family kFamilies[] = {
    {"waves",
     [](v1::ScalarField& field) {
       v1::FourierTerm& term = *field.mutable_fourier()->add_terms();
       term.mutable_direction()->set_x(1);
       term.set_wavelength_m(0.006);
     },
     [](const FieldFamily& family) { return std::holds_alternative<FourierFamily>(family); }},
    {"noise", [](v1::ScalarField& field) { field.mutable_noise()->set_wavelength_m(0.008); },
     [](const FieldFamily& family) { return std::holds_alternative<NoiseFamily>(family); }},
    {"cells", [](v1::ScalarField& field) { field.mutable_cellular()->set_cell_m(0.008); },
     [](const FieldFamily& family) { return std::holds_alternative<CellularFamily>(family); }},
    {"sandpaper", [](v1::ScalarField& field) { field.mutable_grain()->set_grain_m(0.002); },
     [](const FieldFamily& family) { return std::holds_alternative<GrainFamily>(family); }},
};

class TextureRow : public PropertyPanel::Row {
 public:
  TextureRow(QFormLayout* form, const std::function<void(const Family*)>& change) : box_(new QComboBox) {
    box_->setObjectName("texture");
    box_->setToolTip("Family of the texture");
    box_->addItem("none");
    for (const Family& family : kFamilies) box_->addItem(family.name);
    box_->addItem("of a file");
    form->addRow("texture", box_);
    QObject::connect(box_, QOverload<int>::of(&QComboBox::activated), [this, change](int index) {
      if (index > static_cast<int>(std::size(kFamilies))) return box_->setCurrentIndex(shown_);
      change(index == 0 ? nullptr : &kFamilies[index - 1]);
    });
  }
  [[nodiscard]] bool isHeld() const override { return false; }
  void show(const ObjectRecord& object) override {
    const auto& texture = object.material.surface.texture;
    shown_ = 0;
    if (texture) {
      const auto* family = std::ranges::find_if(kFamilies, [&](const Family& f) { return f.is(texture->family); });
      shown_ = static_cast<int>(family - std::begin(kFamilies)) + 1;
    }
    box_->setCurrentIndex(shown_);
  }

 private:
  QComboBox* box_;
  int shown_ = 0;
};

}  // namespace

PropertyPanel::PropertyPanel() : title_(new QLabel), answer_(new QLabel), rowsOf_(new QWidget) {
  setObjectName("properties");
  form_ = new QFormLayout(rowsOf_);
  form_->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  const auto finish = [this] { emit finished(); };
  for (const Number& number : kNumbers) {
    rows_.push_back(std::make_unique<NumberRow>(
        number, form_,
        [this, &number](double value) {
          if (!shown_) return;
          v1::Operation operation;
          number.set(*shown_, value, operation);
          change(number.label, std::move(operation));
        },
        finish));
  }
  rows_.push_back(std::make_unique<TextureRow>(form_, [this](const Family* family) {
    if (!shown_) return;
    v1::Operation operation;
    v1::Texture& texture = *materialIn(operation).mutable_texture();
    if (family != nullptr) {
      constexpr double kUsualHeight_m = 3e-4;
      family->make(*texture.mutable_field());
      texture.set_amplitude_m(kUsualHeight_m);
    }
    change("texture", std::move(operation));
    emit finished();
  }));
  auto* scroll = new QScrollArea;
  scroll->setWidget(rowsOf_);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  title_->setTextFormat(Qt::PlainText);
  answer_->setTextFormat(Qt::PlainText);
  answer_->setWordWrap(true);
  answer_->setObjectName("answer");
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(title_);
  layout->addWidget(answer_);
  layout->addWidget(scroll, 1);
  show(nullptr, false);
}

void PropertyPanel::show(const SceneVersion::Object& object, bool mayEdit) {
  const bool isAnother = (object ? object->id : 0) != (shown_ ? shown_->id : 0);
  shown_ = object;
  if (isAnother) answer_->clear();
  rowsOf_->setVisible(object != nullptr);
  rowsOf_->setEnabled(mayEdit);
  title_->setText(!object    ? "Nothing is selected: click an object."
                  : !mayEdit ? QString::fromStdString(object->name) + " (this connection may look, not edit)"
                             : QString::fromStdString(object->name));
  if (!object) return;
  for (const auto& row : rows_) {
    if (isAnother || !row->isHeld()) row->show(*object);
  }
}

void PropertyPanel::say(const QString& text, bool isError) {
  answer_->setText(text);
  answer_->setStyleSheet(isError ? "color: #b00020" : "");
}

void PropertyPanel::change(const QString& property, v1::Operation operation) {
  const auto name = [this](auto* edit) { edit->mutable_object()->set_name(shown_->name); };
  if (operation.has_set_pose()) name(operation.mutable_set_pose());
  if (operation.has_set_material()) name(operation.mutable_set_material());
  if (operation.has_set_deformation()) name(operation.mutable_set_deformation());
  v1::Transaction transaction;
  *transaction.add_operations() = std::move(operation);
  emit edited(property + " of " + QString::fromStdString(shown_->name), transaction);
}

}  // namespace haptics
