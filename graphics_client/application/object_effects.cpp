#include "graphics_client/application/object_effects.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"
#include "haptics/v1/options.pb.h"

namespace haptics {
namespace {

namespace pb = google::protobuf;
using Kind = Effect::Kind;
using Region = Effect::Region;

/// How far a new effect is from the object (metres), and of a new region or tube the size.
constexpr double kAbove_m = 0.01, kUsualSize_m = 0.05, kUsualTube_m = 0.03;
/// A tap, where an object is given samples.
constexpr std::size_t kTapSamples = 100;
constexpr double kTap_Hz = 250, kTapDecay_per_s = 60;
constexpr double kFarthest_mm = 500;

/// Ends of sliders, in the unit of scene.proto.
const std::map<std::string_view, std::pair<double, double>> kUsual{{"stiffness_N_per_m", {10, 5000}},
                                                                   {"damping_Ns_per_m", {0, 20}},
                                                                   {"amplitude_N", {0.01, 10}},
                                                                   {"frequency_Hz", {1, 500}},
                                                                   {"phase_rad", {-std::numbers::pi, std::numbers::pi}},
                                                                   {"limit_N", {0.01, 10}},
                                                                   {"reach_m", {1e-3, 0.3}},
                                                                   {"release_m", {1e-3, 0.3}},
                                                                   {"fade_m", {0, 0.1}},
                                                                   {"mass_kg", {0.01, 10}},
                                                                   {"sample_rate_Hz", {100, 48'000}}};

/// As it is shown.
struct ShownUnit {
  const char* name;
  double factor;
  int decimals;
};
ShownUnit shownUnit(const std::string& unit) {
  static const std::map<std::string, ShownUnit> kUnits{{"N/m", {" N/m", 1, 0}},
                                                       {"N s/m", {" N s/m", 1, 2}},
                                                       {"N", {" N", 1, 2}},
                                                       {"Hz", {" Hz", 1, 1}},
                                                       {"m", {" mm", 1e3, 1}},
                                                       {"kg", {" kg", 1, 3}},
                                                       {"rad", {"°", 180 / std::numbers::pi, 0}}};
  return kUnits.at(unit);
}

std::string words(std::string name) {
  std::ranges::replace(name, '_', ' ');
  std::ranges::transform(name, name.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return name;
}

/// "EFFECT_REGION_BOX" as "box".
std::string wordsOf(const pb::EnumDescriptor& type, int number) {
  const std::string& first = type.value(0)->name();
  const std::size_t prefix = first.size() - std::string_view("UNSPECIFIED").size();
  return words(type.FindValueByNumber(number)->name().substr(prefix));
}

const pb::FieldDescriptor& fieldOf(std::string_view name) {
  return *v1::Effect::descriptor()->FindFieldByName(std::string(name));
}
const v1::Scalar& scalarOf(const pb::FieldDescriptor& field) { return field.options().GetExtension(v1::scalar); }

using Change = std::function<Result<void>(Effect&)>;

void write(const std::vector<Effect>& effects, v1::Operation& operation) {
  toWire(effects, *operation.mutable_set_effects()->mutable_effects());
}

Result<void> changed(const ObjectRecord& object, const EffectPlace& place, v1::Operation& operation,
                     const Change& change) {
  if (effectAt(object, place) == nullptr) return refused(effectName(place.kind), "is not there any more");
  std::vector<Effect> effects = object.effects;
  if (auto done = change(effects[place.number]); !done) return done;
  write(effects, operation);
  return {};
}

/// Without a reach nothing has a border; a release is beyond it, a fade within.
void makeConsistent(Effect& effect) {
  if (usesField(effect.kind, "reach_m")) {
    if (effect.reach_m == 0) effect.release_m = effect.fade_m = 0;
    if (effect.release_m > 0) effect.release_m = std::max(effect.release_m, effect.reach_m);
    effect.fade_m = std::min(effect.fade_m, std::max(effect.reach_m, effect.release_m));
  }
}

NumberProperty numberOf(const EffectPlace& place, const char* label, const char* tip, ShownUnit unit, double least,
                        double most, bool logarithmic, std::function<std::optional<double>(const Effect&)> get,
                        std::function<void(Effect&, double)> set) {
  return {label,
          tip,
          unit.name,
          unit.factor * least,
          unit.factor * most,
          unit.decimals,
          logarithmic,
          [place, unit, get = std::move(get)](const ObjectRecord& object) -> std::optional<double> {
            const Effect* effect = effectAt(object, place);
            const auto value = effect == nullptr ? std::nullopt : get(*effect);
            return value ? std::optional(unit.factor * *value) : std::nullopt;
          },
          [place, unit, set = std::move(set)](const ObjectRecord& object, double value, v1::Operation& operation) {
            static_cast<void>(changed(object, place, operation, [&](Effect& effect) -> Result<void> {
              set(effect, value / unit.factor);
              return {};
            }));
          },
          true};
}

/// The field of this number among the members.
template <class T, class Of>
T& member(Of& effect, std::size_t field) {
  T* found = nullptr;
  fields::forEachMember(
      [&]<class Member>(std::size_t i, Member& value) {
        if constexpr (std::is_same_v<std::remove_const_t<Member>, std::remove_const_t<T>>) {
          if (i == field) found = &value;
        }
      },
      effect);
  return *found;
}

/// "sample rate" of sample_rate_Hz: until the unit.
const char* labelOf(const pb::FieldDescriptor& field) {
  static std::map<std::string, std::string> labels;
  const auto [label, isNew] = labels.emplace(field.name(), "");
  if (isNew) {
    const std::string& name = field.name();
    const std::size_t end = name.find('_');
    label->second = words(name.substr(0, name.starts_with("sample_rate") ? name.rfind('_') : end));
  }
  return label->second.c_str();
}

void addNumber(std::vector<NumberProperty>& rows, const EffectPlace& place, std::string_view name, std::size_t i) {
  const pb::FieldDescriptor& field = fieldOf(name);
  const v1::Scalar& scalar = scalarOf(field);
  const auto [least, most] = kUsual.at(name);
  const auto isThere = [name](const Effect& effect) {
    const bool hasBorder =
        usesField(effect.kind, "reach_m") ? effect.reach_m > 0 : effect.region != Region::kEverywhere;
    return (name != "fade_m" && name != "release_m") || hasBorder;
  };
  rows.push_back(numberOf(
      place, labelOf(field), scalar.help().c_str(), shownUnit(scalar.unit()), least, most, least > 0,
      [i, isThere](const Effect& effect) {
        return isThere(effect) ? std::optional(member<const double>(effect, i)) : std::nullopt;
      },
      [i](Effect& effect, double value) {
        member<double>(effect, i) = value;
        makeConsistent(effect);
      }));
}

constexpr const char* kXyz[] = {"x", "y", "z"};

bool hasPoint(const Effect& effect) {
  if (!usesField(effect.kind, "point_m")) return false;
  return !usesField(effect.kind, "region") || effect.region == Region::kBox || effect.region == Region::kSphere;
}

void addVectors(std::vector<NumberProperty>& rows, const EffectPlace& place) {
  static constexpr const char* kPoint[] = {"point x", "point y", "point z"};
  static constexpr const char* kDirection[] = {"direction x", "direction y", "direction z"};
  static constexpr const char* kSize[] = {"size x", "size y", "size z"};
  constexpr ShownUnit kMillimetres{" mm", 1e3, 1}, kNone{"", 1, 3};
  constexpr double kFar = 1e-3 * kFarthest_mm;
  for (int axis = 0; axis < 3; ++axis) {
    if (!usesField(place.kind, "point_m")) break;
    rows.push_back(numberOf(
        place, kPoint[axis], "Of what it pulls to, or the middle of its region, in its frame", kMillimetres, -kFar,
        kFar, false,
        [axis](const Effect& effect) { return hasPoint(effect) ? std::optional(effect.point_m[axis]) : std::nullopt; },
        [axis](Effect& effect, double value) { effect.point_m[axis] = value; }));
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!usesField(place.kind, "direction")) break;
    rows.push_back(numberOf(
        place, kDirection[axis], "Part of a direction of length 1, in its frame: the two others go along", kNone, -1, 1,
        false, [axis](const Effect& effect) { return std::optional(effect.direction[axis]); },
        [axis](Effect& effect, double value) { setComponent(effect.direction, axis, value); }));
  }
  const bool isTube = place.kind == Kind::kTube;
  for (int axis = 0; axis < (isTube ? 1 : 3); ++axis) {
    if (!usesField(place.kind, "size_m")) break;
    rows.push_back(numberOf(
        place, isTube ? "diameter" : kSize[axis],
        isTube ? "Of the tube" : "Sides of the box; x is the diameter of the sphere", kMillimetres, 1e-3, 0.5, true,
        [axis, isTube](const Effect& effect) {
          const bool isThere =
              isTube || effect.region == Region::kBox || (effect.region == Region::kSphere && axis == 0);
          return isThere ? std::optional(effect.size_m[axis]) : std::nullopt;
        },
        [axis](Effect& effect, double value) { effect.size_m[axis] = value; }));
  }
}

ChoiceProperty choiceOf(const EffectPlace& place, const char* label, const char* field, const char* tip,
                        std::function<int(const Effect&)> get,
                        std::function<void(Effect&, int, const Surroundings&)> set) {
  const pb::EnumDescriptor& type = *fieldOf(field).enum_type();
  std::vector<std::string> entries;
  for (int i = 1; i < type.value_count(); ++i) entries.push_back(wordsOf(type, i));
  return {label, tip, std::move(entries),
          [place, get = std::move(get)](const ObjectRecord& object) -> std::optional<std::size_t> {
            const Effect* effect = effectAt(object, place);
            return effect == nullptr ? std::nullopt : std::optional(static_cast<std::size_t>(get(*effect) - 1));
          },
          [place, set = std::move(set)](const ObjectRecord& object, std::size_t entry, const Surroundings& around,
                                        v1::Operation& operation) {
            return changed(object, place, operation, [&](Effect& effect) -> Result<void> {
              set(effect, static_cast<int>(entry) + 1, around);
              return {};
            });
          }};
}

/// It stays where it is.
void setFrame(Effect& effect, Effect::Frame frame, const Pose& object) {
  if (frame == effect.frame) return;
  const bool toWorldFrame = frame == Effect::Frame::kWorld;
  const auto point = [&](Vec3 at) { return toWorldFrame ? toWorld(object, at) : toLocal(object, at); };
  effect.frame = frame;
  if (hasPoint(effect)) effect.point_m = point(effect.point_m);
  for (Vec3& at : effect.path_m) at = point(at);
  const Quat turn = toWorldFrame ? object.rotation : glm::conjugate(object.rotation);
  if (effect.direction != Vec3(0)) effect.direction = glm::normalize(turn * effect.direction);
}

void setRegion(Effect& effect, Region region, const ObjectBox& box) {
  const bool hadPoint = hasPoint(effect);
  effect.region = region;
  const bool hasSize = region == Region::kBox || region == Region::kSphere;
  if (!hasSize) effect.point_m = effect.size_m = Vec3(0);
  if (hasSize && !hadPoint) effect.point_m = box.top_m();
  if (region == Region::kBox) effect.size_m = Vec3(effect.size_m.x > 0 ? effect.size_m.x : kUsualSize_m);
  if (region == Region::kSphere) effect.size_m = {effect.size_m.x > 0 ? effect.size_m.x : kUsualSize_m, 0, 0};
  if (region == Region::kEverywhere) effect.fade_m = 0;
}

}  // namespace

const Effect* effectAt(const ObjectRecord& object, const EffectPlace& place) {
  const bool isThere = place.number < object.effects.size() && object.effects[place.number].kind == place.kind;
  return isThere ? &object.effects[place.number] : nullptr;
}

std::string effectName(Kind kind) { return wordsOf(*fieldOf("kind").enum_type(), static_cast<int>(kind)); }

std::vector<Kind> effectKinds() {
  std::vector<Kind> kinds;
  for (int i = 1; i < fieldOf("kind").enum_type()->value_count(); ++i) {
    if (!usesField(static_cast<Kind>(i), "models")) kinds.push_back(static_cast<Kind>(i));
  }
  return kinds;
}

Effect usualEffect(Kind kind, const ObjectBox& box) {
  Effect effect{.kind = kind};
  fields::forEachMember(
      [&]<class T>(std::size_t i, T& value) {
        if constexpr (std::is_same_v<T, double>) {
          const auto name = fields::nameOf(Effect::kFieldNames, i);
          if (usesField(kind, name)) value = scalarOf(fieldOf(name)).initial();
        }
      },
      effect);
  if (usesField(kind, "region")) effect.fade_m = 0;  // it is everywhere
  const Vec3 place = box.top_m() + Vec3(0, 0, kAbove_m);
  if (hasPoint(effect)) effect.point_m = place;
  if (usesField(kind, "direction")) effect.direction = {0, 0, kind == Kind::kConstant ? -1 : 1};
  if (kind == Kind::kSpringToLine) effect.direction = {1, 0, 0};
  if (usesField(kind, "path_m")) {
    const double half_m = std::max((box.high_m.x - box.low_m.x) / 2, kAbove_m);
    effect.path_m = {place - Vec3(half_m, 0, 0), place, place + Vec3(half_m, 0, 0)};
  }
  if (kind == Kind::kTube) effect.size_m.x = kUsualTube_m;
  if (usesField(kind, "samples")) {
    for (std::size_t i = 0; i < kTapSamples; ++i) {
      const double t_s = static_cast<double>(i) / effect.sample_rate_Hz;
      effect.samples.push_back(
          static_cast<float>(std::exp(-kTapDecay_per_s * t_s) * std::sin(2 * std::numbers::pi * kTap_Hz * t_s)));
    }
  }
  return effect;
}

std::vector<NumberProperty> effectNumbers(const EffectPlace& place) {
  std::vector<NumberProperty> rows;
  const Effect none;
  fields::forEachMember(
      [&]<class T>(std::size_t i, const T& /*value*/) {
        const auto name = fields::nameOf(Effect::kFieldNames, i);
        if constexpr (std::is_same_v<T, double>) {
          if (usesField(place.kind, name)) addNumber(rows, place, name, i);
        }
      },
      none);
  addVectors(rows, place);
  return rows;
}

std::vector<ChoiceProperty> effectChoices(const EffectPlace& place) {
  std::vector<ChoiceProperty> rows;
  rows.push_back(choiceOf(
      place, "frame", "frame", "It moves and turns with the object, and pushes it back; or it stays in the world",
      [](const Effect& effect) { return static_cast<int>(effect.frame); },
      [](Effect& effect, int frame, const Surroundings& around) {
        setFrame(effect, static_cast<Effect::Frame>(frame), around.pose);
      }));
  if (usesField(place.kind, "region")) {
    rows.push_back(choiceOf(
        place, "region", "region", "Where it is felt; inside: of the object, whose mesh is closed",
        [](const Effect& effect) { return static_cast<int>(effect.region); },
        [](Effect& effect, int region, const Surroundings& around) {
          if (static_cast<Region>(region) == Region::kInside) setFrame(effect, Effect::Frame::kObject, around.pose);
          setRegion(effect, static_cast<Region>(region), around.box);
        }));
  }
  rows.push_back(choiceOf(
      place, "felt", "trigger", "Always, while the hand touches the object, or while a button of the device is pressed",
      [](const Effect& effect) { return static_cast<int>(effect.trigger); },
      [](Effect& effect, int trigger, const Surroundings& /*around*/) {
        effect.trigger = static_cast<Effect::Trigger>(trigger);
      }));
  return rows;
}

std::vector<NumberProperty> pathNumbers(const EffectPlace& place, std::size_t point) {
  constexpr ShownUnit kMillimetres{" mm", 1e3, 1};
  std::vector<NumberProperty> rows;
  if (!usesField(place.kind, "path_m")) return rows;
  for (int axis = 0; axis < 3; ++axis) {
    rows.push_back(numberOf(
        place, kXyz[axis], "Of the chosen point of the path, in its frame", kMillimetres, -1e-3 * kFarthest_mm,
        1e-3 * kFarthest_mm, false,
        [axis, point](const Effect& effect) {
          return point < effect.path_m.size() ? std::optional(effect.path_m[point][axis]) : std::nullopt;
        },
        [axis, point](Effect& effect, double value) {
          if (point < effect.path_m.size()) effect.path_m[point][axis] = value;
        }));
  }
  return rows;
}

void addEffect(const ObjectRecord& object, Effect effect, v1::Operation& operation) {
  std::vector<Effect> effects = object.effects;
  effects.push_back(std::move(effect));
  write(effects, operation);
}

Result<void> removeEffect(const ObjectRecord& object, const EffectPlace& place, v1::Operation& operation) {
  if (effectAt(object, place) == nullptr) return refused(effectName(place.kind), "is not there any more");
  std::vector<Effect> effects = object.effects;
  effects.erase(effects.begin() + static_cast<std::ptrdiff_t>(place.number));
  write(effects, operation);
  return {};
}

Result<void> addPathPoint(const ObjectRecord& object, const EffectPlace& place, std::size_t after,
                          v1::Operation& operation) {
  return changed(object, place, operation, [after](Effect& effect) -> Result<void> {
    std::vector<Vec3>& path = effect.path_m;
    if (after >= path.size()) return refused("path", "has no such point any more");
    const Vec3 at =
        after + 1 < path.size() ? (path[after] + path[after + 1]) / 2.0 : 2.0 * path[after] - path[after - 1];
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(after) + 1, at);
    return {};
  });
}

Result<void> removePathPoint(const ObjectRecord& object, const EffectPlace& place, std::size_t point,
                             v1::Operation& operation) {
  return changed(object, place, operation, [point](Effect& effect) -> Result<void> {
    if (point >= effect.path_m.size()) return refused("path", "has no such point any more");
    effect.path_m.erase(effect.path_m.begin() + static_cast<std::ptrdiff_t>(point));
    return {};
  });
}

std::optional<SpotState> spotState(const ObjectRecord& object, const HandleSpot& spot) {
  if (!spot.effect) {
    if (!object.motion || !object.motion->joint) return std::nullopt;
    return SpotState{object.motion->joint->anchor_m, object.motion->joint->axis};
  }
  const Effect* effect = effectAt(object, *spot.effect);
  if (effect == nullptr) return std::nullopt;
  SpotState state{.isInWorld = effect->frame == Effect::Frame::kWorld};
  if (hasPoint(*effect)) state.point_m = effect->point_m;
  if (spot.pathPoint < effect->path_m.size()) state.point_m = effect->path_m[spot.pathPoint];
  if (usesField(effect->kind, "direction")) state.direction = effect->direction;
  return state.point_m || state.direction ? std::optional(state) : std::nullopt;
}

Result<void> setSpot(const ObjectRecord& object, const HandleSpot& spot, const SpotState& state,
                     v1::Operation& operation) {
  if (!spot.effect) {
    if (!object.motion || !object.motion->joint) return refused("joint", "is not there any more");
    MotionProperties motion = *object.motion;
    motion.joint->anchor_m = state.point_m.value_or(motion.joint->anchor_m);
    motion.joint->axis = state.direction.value_or(motion.joint->axis);
    toWire(motion, *operation.mutable_set_motion()->mutable_motion());
    return {};
  }
  return changed(object, *spot.effect, operation, [&](Effect& effect) -> Result<void> {
    if (state.direction && usesField(effect.kind, "direction")) effect.direction = *state.direction;
    if (!state.point_m) return {};
    if (spot.pathPoint < effect.path_m.size()) {
      effect.path_m[spot.pathPoint] = *state.point_m;
    } else if (hasPoint(effect)) {
      effect.point_m = *state.point_m;
    }
    return {};
  });
}

}  // namespace haptics
