#include "graphics_client/application/object_properties.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <vector>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "graphics_client/application/texture_families.h"
#include "haptics/v1/options.pb.h"

namespace haptics {
namespace {

/// Of an object that is made soft or movable.
constexpr double kUsualTissue_N_per_m = 300, kUsualDent_m = 0.015;
constexpr double kUsualMass_kg = 0.1;
/// How fast what is pushed comes to rest (per second).
constexpr double kUsualDamping_per_s = 0.5;

v1::Material& materialIn(v1::Operation& operation) { return *operation.mutable_set_material()->mutable_material(); }

/// The standard's transfer curve (IEC 61966-2-1), and back.
double encodeSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}
double decodeSrgb(double shown) { return shown <= 0.04045 ? shown / 12.92 : std::pow((shown + 0.055) / 1.055, 2.4); }

double degrees(double radians) { return radians * 180 / std::numbers::pi; }
double radians(double degrees) { return degrees * std::numbers::pi / 180; }

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

constexpr const char* kPositionTip = "Where the object is, world frame";
constexpr const char* kAngleTip = "How the object is turned: about x, then y, then z";

const NumberProperty kPlace[] = {
    {"x", kPositionTip, " mm", -2000, 2000, 1, false, position_mm<0>, setPosition_mm<0>},
    {"y", kPositionTip, " mm", -2000, 2000, 1, false, position_mm<1>, setPosition_mm<1>},
    {"z", kPositionTip, " mm", -2000, 2000, 1, false, position_mm<2>, setPosition_mm<2>},
    {"turn x", kAngleTip, "°", -180, 180, 1, false, angle_deg<0>, setAngle_deg<0>},
    {"turn y", kAngleTip, "°", -90, 90, 1, false, angle_deg<1>, setAngle_deg<1>},
    {"turn z", kAngleTip, "°", -180, 180, 1, false, angle_deg<2>, setAngle_deg<2>},
};

void setFriction(double mu_static, double mu_dynamic, v1::Operation& operation) {
  v1::Friction& friction = *materialIn(operation).mutable_friction();
  friction.set_mu_static(mu_static);
  friction.set_mu_dynamic(std::min(mu_static, mu_dynamic));
}

double muStatic(const ObjectRecord& object) {
  const auto& friction = object.material.surface.friction;
  return friction ? friction->mu_static : 0;
}

double muDynamic(const ObjectRecord& object) {
  const auto& friction = object.material.surface.friction;
  return friction ? friction->mu_dynamic : 0;
}

/// Over a map two numbers alone do not say what the friction is.
template <double (*kCoefficient)(const ObjectRecord&)>
std::optional<double> plainFriction(const ObjectRecord& object) {
  const auto& friction = object.material.surface.friction;
  const bool isPlain = !friction || (std::holds_alternative<std::monostate>(friction->over) &&
                                     std::holds_alternative<std::monostate>(friction->dynamicOver));
  return isPlain ? std::optional(kCoefficient(object)) : std::nullopt;
}

const NumberProperty kSurface[] = {
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
       if (value != 0) shading.set_crease_rad(radians(value));
     }},
    {"static friction", "Coefficient up to which the hand sticks; 0: none", "", 0, 3, 2, false, plainFriction<muStatic>,
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       setFriction(value, muDynamic(object), operation);
     }},
    {"dynamic friction", "Coefficient while the hand slides, not above the static one", "", 0, 3, 2, false,
     plainFriction<muDynamic>,
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       setFriction(std::max(muStatic(object), value), value, operation);
     }},
};

const NumberProperty kTexture[] = {
    {"texture height", "Amplitude of the texture", " mm", 0.01, 5, 3, true,
     [](const ObjectRecord& object) {
       const auto& texture = object.material.surface.texture;
       return texture ? std::optional(1e3 * texture->amplitude_m) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       v1::Texture& texture = *materialIn(operation).mutable_texture();
       texture = textureOf(object.material.surface);
       texture.set_amplitude_m(1e-3 * value);
     }},
    {"texture size", "Of its waves, cells or grains; of an image or pattern: of one tile", " mm", 0.2, 200, 2, true,
     [](const ObjectRecord& object) -> std::optional<double> {
       const auto& texture = object.material.surface.texture;
       const auto size_m = texture ? textureSize_m(texture->family) : std::nullopt;
       return size_m ? std::optional(1e3 * *size_m) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       SurfaceProperties surface = object.material.surface;
       setTextureSize_m(surface.texture->family, 1e-3 * value);
       *materialIn(operation).mutable_texture() = textureOf(surface);
     }},
};

/// The object's, to be changed.
v1::Softness& softnessIn(v1::Operation& operation, const ObjectRecord& object) {
  v1::ObjectState state;
  toWire(object.deformation, *state.mutable_deformation());
  v1::Softness& softness = *operation.mutable_set_deformation()->mutable_deformation()->mutable_softness();
  softness = state.deformation().softness();
  return softness;
}

template <double Softness::*kValue>
std::optional<double> softness(const ObjectRecord& object) {
  const auto& softness = object.deformation.softness;
  return softness ? std::optional((*softness).*kValue) : std::nullopt;
}

const NumberProperty kSoftness[] = {
    {"tissue stiffness", "Of a soft object, in series with that of its surface", " N/m", 10, 5'000, 0, true,
     softness<&Softness::stiffness_N_per_m>,
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       softnessIn(operation, object).set_stiffness_n_per_m(value);
     }},
    {"dent radius", "How far around the stylus the surface gives, at most the object's longest side", " mm", 1, 100, 1,
     true,
     [](const ObjectRecord& object) -> std::optional<double> {
       const auto radius_m = softness<&Softness::radius_m>(object);
       return radius_m ? std::optional(1e3 * *radius_m) : std::nullopt;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       softnessIn(operation, object).set_radius_m(1e-3 * value);
     }},
    {"dents return in", "Time constant with which a dent goes back; 0: at once", " s", 0, 60, 1, false,
     softness<&Softness::return_s>,
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       softnessIn(operation, object).set_return_s(value);
     }},
    {"dents that stay", "The part of the deepest dent that stays, as in clay: 0 to 1", "", 0, 1, 2, false,
     softness<&Softness::plastic>,
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       softnessIn(operation, object).set_plastic(value);
     }},
};

const SwitchProperty kSoft[] = {
    {"soft", "Yields to the stylus; else rigid",
     [](const ObjectRecord& object) { return object.deformation.softness.has_value(); },
     [](const ObjectRecord& /*object*/, bool on, double /*floor_m*/, v1::Operation& operation) {
       v1::Softness& softness = *operation.mutable_set_deformation()->mutable_deformation()->mutable_softness();
       if (!on) return;
       softness.set_stiffness_n_per_m(kUsualTissue_N_per_m);
       softness.set_radius_m(kUsualDent_m);
     }}};

bool moves(const ObjectRecord& object) { return object.motion && !object.motion->fixed && !object.motion->tool; }

v1::Motion& motionIn(v1::Operation& operation, const ObjectRecord& object) {
  v1::Motion& motion = *operation.mutable_set_motion()->mutable_motion();
  if (object.motion) toWire(*object.motion, motion);
  return motion;
}

const NumberProperty kMotion[] = {
    {"mass", "Of an object that moves, evenly filled", " kg", 0.001, 10, 3, true,
     [](const ObjectRecord& object) { return moves(object) ? std::optional(object.motion->mass_kg) : std::nullopt; },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       motionIn(operation, object).set_mass_kg(value);
     }},
    {"gravity", "Downwards, of this object", " m/s²", 0, 20, 2, false,
     [](const ObjectRecord& object) -> std::optional<double> {
       if (!moves(object)) return {};
       const Vec3& gravity = object.motion->gravity_m_per_s2;
       if (gravity.x != 0 || gravity.y != 0) return {};
       return 0 - gravity.z;
     },
     [](const ObjectRecord& object, double value, v1::Operation& operation) {
       motionIn(operation, object).mutable_gravity_m_per_s2()->set_z(-value);
     }},
};

bool meetsOthers(const ObjectRecord& object) { return object.motion && object.motion->collision; }

void setMoves(const ObjectRecord& object, bool on, double floor_m, v1::Operation& operation) {
  v1::Motion& motion = *operation.mutable_set_motion()->mutable_motion();
  if (!on) {
    if (!meetsOthers(object)) return;
    motion.set_fixed(true);
    motion.mutable_collision();
    return;
  }
  motion.set_mass_kg(kUsualMass_kg);
  motion.set_linear_damping_per_s(kUsualDamping_per_s);
  motion.set_angular_damping_per_s(kUsualDamping_per_s);
  motion.mutable_collision();
  v1::Plane& floor = *motion.add_planes();
  floor.mutable_normal()->set_z(1);
  floor.set_offset_m(floor_m);
}

const SwitchProperty kMotionSwitches[] = {
    {"moves",
     "Is pushed by the stylus, falls, comes to rest on the floor and is stopped by others; else stays where it is",
     moves, setMoves, true},
    {"meets others",
     "Objects that move are stopped by it, and it by them; else they pass through. Its mesh has to be closed",
     meetsOthers, [](const ObjectRecord& object, bool on, double /*floor_m*/, v1::Operation& operation) {
       setMeetsOthers(object, on, operation);
     }}};

/// The rows, and one for each other number of the material, by what scene.proto says of it.
std::vector<NumberProperty> withScalars(std::span<const NumberProperty> rows) {
  static std::deque<std::string> texts;
  std::vector<NumberProperty> all(rows.begin(), rows.end());
  const auto add = [&all](std::string_view name, double /*none*/) {
    const auto& field = materialScalar(name);
    const v1::Scalar& scalar = field.options().GetExtension(v1::scalar);
    std::string word(name.substr(0, name.find('_')));
    if (std::ranges::any_of(all, [&](const NumberProperty& row) { return row.label == word; }))
      word += " (" + scalar.unit() + ")";
    const std::string& label = texts.emplace_back(std::move(word));
    const std::string& unit = texts.emplace_back(" " + scalar.unit());
    const auto get = [name](const ObjectRecord& object) {
      std::optional<double> its;
      forEachScalar([&](std::string_view other, double value) { its = other == name ? value : its; },
                    object.material.surface.scalars);
      return its;
    };
    const auto set = [&field](const ObjectRecord& /*object*/, double value, v1::Operation& operation) {
      materialIn(operation).GetReflection()->SetDouble(&materialIn(operation), &field, value);
    };
    all.push_back({label.c_str(), scalar.help().c_str(), unit.c_str(), 0, scalar.most(), 2, false, get, set});
  };
  const SurfaceScalars<double> none;
  forEachScalar(add, none);
  return all;
}

}  // namespace

std::span<const PropertyGroup> propertyGroups() {
  static const std::vector<NumberProperty> kSurfaceNumbers = withScalars(kSurface);
  static const PropertyGroup kGroups[] = {{"Place", {}, false, kPlace},
                                          {"Surface", {}, false, kSurfaceNumbers},
                                          {"Texture", {}, true, kTexture},
                                          {"Softness", kSoft, false, kSoftness},
                                          {"Motion", kMotionSwitches, false, kMotion}};
  return kGroups;
}

std::array<int, 3> shownColor(const Color& color) {
  const auto shown = [](float part) {
    return static_cast<int>(std::lround(255 * encodeSrgb(std::clamp(part, 0.F, 1.F))));
  };
  return {shown(color.red), shown(color.green), shown(color.blue)};
}

void setShownColor(std::array<int, 3> color, v1::Operation& operation) {
  const auto linear = [](int part) { return static_cast<float>(decodeSrgb(part / 255.0)); };
  v1::Color& message = *materialIn(operation).mutable_color();
  message.set_red(linear(color[0]));
  message.set_green(linear(color[1]));
  message.set_blue(linear(color[2]));
}

void setMeetsOthers(const ObjectRecord& object, bool on, v1::Operation& operation) {
  v1::Motion& motion = *operation.mutable_set_motion()->mutable_motion();
  const bool isFree = object.motion && !object.motion->fixed;
  if (isFree) toWire(*object.motion, motion);
  if (on) {
    motion.mutable_collision();
    if (!isFree) motion.set_fixed(true);
  } else {
    motion.clear_collision();
  }
}

void setObject(v1::Operation& operation, const std::string& name) {
  const auto set = [&](auto* edit) { edit->mutable_object()->set_name(name); };
  if (operation.has_set_pose()) set(operation.mutable_set_pose());
  if (operation.has_set_material()) set(operation.mutable_set_material());
  if (operation.has_set_motion()) set(operation.mutable_set_motion());
  if (operation.has_set_deformation()) set(operation.mutable_set_deformation());
}

}  // namespace haptics
