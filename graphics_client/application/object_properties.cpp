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
/// Ends of a joint to both sides.
constexpr double kUsualTurn_rad = std::numbers::pi / 2, kUsualWay_m = 0.05;
/// Points that a new tool touches with, along its longest side; a box has then 3,750 of 8,192.
constexpr double kPointsAlongATool = 25, kMinSpacing_m = 5e-4;

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
    {"x", kPositionTip, " mm", -200, 200, 1, false, position_mm<0>, setPosition_mm<0>},
    {"y", kPositionTip, " mm", -200, 200, 1, false, position_mm<1>, setPosition_mm<1>},
    {"z", kPositionTip, " mm", -200, 200, 1, false, position_mm<2>, setPosition_mm<2>},
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
     [](const ObjectRecord& /*object*/, bool on, const Surroundings& /*around*/, v1::Operation& operation) {
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

void addFloor(v1::Motion& motion, const Surroundings& around) {
  v1::Plane& floor = *motion.add_planes();
  floor.mutable_normal()->set_z(1);
  floor.set_offset_m(around.floor_m);
}

bool meetsOthers(const ObjectRecord& object) { return object.motion && object.motion->collision; }

void setMoves(const ObjectRecord& object, bool on, const Surroundings& around, v1::Operation& operation) {
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
  addFloor(motion, around);
}

const JointProperties* jointOf(const ObjectRecord& object) {
  return moves(object) && object.motion->joint ? &*object.motion->joint : nullptr;
}
bool hasJoint(const ObjectRecord& object) { return jointOf(object) != nullptr; }
double noEnd(const JointProperties& joint) {
  return joint.kind == JointProperties::Kind::kHinge ? kMaxJointAngle_rad : kMaxCoordinate_m;
}
bool hasEnds(const ObjectRecord& object) {
  const JointProperties* joint = jointOf(object);
  return joint != nullptr && (joint->lowest > -noEnd(*joint) || joint->highest < noEnd(*joint));
}

template <class Change>
void changeJoint(const ObjectRecord& object, v1::Operation& operation, const Change& change) {
  MotionProperties motion = *object.motion;
  change(*motion.joint);
  toWire(motion, *operation.mutable_set_motion()->mutable_motion());
}

void setEnds(const ObjectRecord& object, bool on, const Surroundings& /*around*/, v1::Operation& operation) {
  changeJoint(object, operation, [on](JointProperties& joint) {
    const double usual = joint.kind == JointProperties::Kind::kHinge ? kUsualTurn_rad : kUsualWay_m;
    joint.highest = on ? usual : noEnd(joint);
    joint.lowest = -joint.highest;
  });
}

/// Free, hinge or slider. A joint takes the place of planes to rest on.
Result<void> setJoint(const ObjectRecord& object, std::size_t entry, const Surroundings& around,
                      v1::Operation& operation) {
  if (!moves(object)) return refused("joint", "the object does not move any more");
  MotionProperties motion = *object.motion;
  using Kind = JointProperties::Kind;
  const JointProperties before = motion.joint.value_or(JointProperties{.anchor_m = around.box.centre_m()});
  motion.joint.reset();
  if (entry > 0) {
    motion.planes.clear();
    motion.joint = {.kind = static_cast<Kind>(entry), .anchor_m = before.anchor_m, .axis = before.axis};
    motion.joint->highest = noEnd(*motion.joint);
    motion.joint->lowest = -motion.joint->highest;
  }
  v1::Motion& message = *operation.mutable_set_motion()->mutable_motion();
  toWire(motion, message);
  if (entry == 0 && motion.planes.empty()) addFloor(message, around);
  return {};
}

std::optional<std::size_t> jointEntry(const ObjectRecord& object) {
  if (!moves(object)) return std::nullopt;
  return object.motion->joint ? static_cast<std::size_t>(object.motion->joint->kind) : 0;
}

template <Vec3 JointProperties::*kVector>
NumberProperty ofJoint(const char* label, const char* tip, const char* unit, double factor, double most, int axis) {
  return {label,
          tip,
          unit,
          -most,
          most,
          factor == 1 ? 3 : 1,
          false,
          [factor, axis](const ObjectRecord& object) -> std::optional<double> {
            const JointProperties* joint = jointOf(object);
            return joint == nullptr ? std::nullopt : std::optional(factor * (joint->*kVector)[axis]);
          },
          [factor, axis](const ObjectRecord& object, double value, v1::Operation& operation) {
            changeJoint(object, operation, [&](JointProperties& joint) {
              if (factor == 1) {
                setComponent(joint.*kVector, axis, value);
              } else {
                (joint.*kVector)[axis] = value / factor;
              }
            });
          },
          true};
}

template <double JointProperties::*kEnd>
NumberProperty endOf(JointProperties::Kind kind, const char* label, double least, double most) {
  const bool isHinge = kind == JointProperties::Kind::kHinge;
  const double factor = isHinge ? degrees(1) : 1e3;
  return {label,
          "From where the scene has it, by the joint",
          isHinge ? "°" : " mm",
          least,
          most,
          1,
          false,
          [kind, factor](const ObjectRecord& object) -> std::optional<double> {
            if (!hasEnds(object) || jointOf(object)->kind != kind) return std::nullopt;
            return factor * jointOf(object)->*kEnd;
          },
          [factor](const ObjectRecord& object, double value, v1::Operation& operation) {
            changeJoint(object, operation, [&](JointProperties& joint) { joint.*kEnd = value / factor; });
          },
          true};
}

const ToolProperties* toolOf(const ObjectRecord& object) {
  return object.motion && object.motion->tool ? &*object.motion->tool : nullptr;
}

void setTool(const ObjectRecord& /*object*/, bool on, const Surroundings& around, v1::Operation& operation) {
  v1::Motion& motion = *operation.mutable_set_motion()->mutable_motion();
  if (on) motion.mutable_tool()->set_spacing_m(std::max(around.box.longest_m() / kPointsAlongATool, kMinSpacing_m));
}

template <double ToolProperties::*kValue>
NumberProperty ofTool(const char* label, const char* tip, const char* unit, double factor, double least, double most) {
  return {label,
          tip,
          unit,
          least,
          most,
          2,
          true,
          [factor](const ObjectRecord& object) -> std::optional<double> {
            const ToolProperties* tool = toolOf(object);
            return tool == nullptr ? std::nullopt : std::optional(factor * tool->*kValue);
          },
          [factor](const ObjectRecord& object, double value, v1::Operation& operation) {
            MotionProperties motion = *object.motion;
            (*motion.tool).*kValue = value / factor;
            toWire(motion, *operation.mutable_set_motion()->mutable_motion());
          },
          true};
}

std::vector<NumberProperty> withJointAndTool(std::span<const NumberProperty> rows) {
  constexpr const char* kAnchorTip = "A point of the hinge's axis, in the object's frame";
  constexpr const char* kAxisTip =
      "Part of the joint's axis, of length 1, in the object's frame: the two others go along";
  std::vector<NumberProperty> all(rows.begin(), rows.end());
  int axis = 0;
  for (const char* label : {"anchor x", "anchor y", "anchor z"})
    all.push_back(ofJoint<&JointProperties::anchor_m>(label, kAnchorTip, " mm", 1e3, 500, axis++));
  axis = 0;
  for (const char* label : {"axis x", "axis y", "axis z"})
    all.push_back(ofJoint<&JointProperties::axis>(label, kAxisTip, "", 1, 1, axis++));
  using Kind = JointProperties::Kind;
  all.push_back(endOf<&JointProperties::lowest>(Kind::kHinge, "turns from", -360, 0));
  all.push_back(endOf<&JointProperties::highest>(Kind::kHinge, "turns to", 0, 360));
  all.push_back(endOf<&JointProperties::lowest>(Kind::kSlider, "slides from", -500, 0));
  all.push_back(endOf<&JointProperties::highest>(Kind::kSlider, "slides to", 0, 500));
  all.push_back(ofTool<&ToolProperties::spacing_m>(
      "tool spacing", "Between the points of its surface that touch, which are 8,192 at most", " mm", 1e3, 0.5, 20));
  all.push_back(ofTool<&ToolProperties::torsion_Nm_per_rad>(
      "tool torsion", "Of the spring that turns it to where the device is turned", " Nm/rad", 1, 0.01, 10));
  return all;
}

const SwitchProperty kMotionSwitches[] = {
    {"moves",
     "Is pushed by the stylus, falls, comes to rest on the floor and is stopped by others; else stays where it is",
     moves, setMoves, true},
    {"meets others",
     "Objects that move are stopped by it, and it by them; else they pass through. Its mesh has to be closed",
     meetsOthers,
     [](const ObjectRecord& object, bool on, const Surroundings& /*around*/, v1::Operation& operation) {
       setMeetsOthers(object, on, operation);
     }},
    {"stops at ends", "Of its joint: how far it turns or slides", hasEnds, setEnds, false, hasJoint},
    {"tool", "The hand holds the object in place of a point, and feels with the whole of it",
     [](const ObjectRecord& object) { return toolOf(object) != nullptr; }, setTool}};

const ChoiceProperty kMotionChoices[] = {
    {"joint", "Free, or turns about an axis, or slides along one", {"free", "hinge", "slider"}, jointEntry, setJoint}};

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
  static const std::vector<NumberProperty> kMotionNumbers = withJointAndTool(kMotion);
  static const PropertyGroup kGroups[] = {{"Place", {}, false, kPlace},
                                          {"Surface", {}, false, kSurfaceNumbers},
                                          {"Texture", {}, true, kTexture},
                                          {"Softness", kSoft, false, kSoftness},
                                          {"Motion", kMotionSwitches, false, kMotionNumbers, kMotionChoices}};
  return kGroups;
}

double ObjectBox::longest_m() const {
  const Vec3 sides = high_m - low_m;
  return std::max({sides.x, sides.y, sides.z});
}

ObjectBox boxOf(const TriMesh& mesh) {
  Vec3f low = mesh.vertices.front(), high = low;
  for (const Vec3f& vertex : mesh.vertices) {
    low = glm::min(low, vertex);
    high = glm::max(high, vertex);
  }
  return {low, high};
}

void setComponent(Vec3& direction, int axis, double value) {
  const double share = std::clamp(value, -1.0, 1.0);
  Vec3 rest = direction;
  rest[axis] = 0;
  if (rest == Vec3(0)) rest[(axis + 1) % 3] = 1;
  direction = glm::normalize(rest) * std::sqrt(1 - share * share);
  direction[axis] = share;
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
  if (operation.has_set_effects()) set(operation.mutable_set_effects());
}

}  // namespace haptics
