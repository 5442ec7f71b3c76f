#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

namespace pb = google::protobuf;
using Kind = Effect::Kind;
using Region = Effect::Region;

/// The fields that a kind uses, beside kind and frame, each between spaces.
std::string_view fieldsUsedBy(Kind kind) noexcept {
  switch (kind) {
    case Kind::kConstant:
      return " direction amplitude_N region point_m size_m fade_m ";
    case Kind::kSpringToPoint:
      return " point_m stiffness_N_per_m damping_Ns_per_m limit_N reach_m release_m fade_m ";
    case Kind::kSpringToLine:
    case Kind::kSpringToPlane:
      return " point_m direction stiffness_N_per_m damping_Ns_per_m limit_N reach_m release_m fade_m ";
    case Kind::kSpringToPath:
    case Kind::kGuide:
      return " path_m stiffness_N_per_m damping_Ns_per_m limit_N reach_m release_m fade_m ";
    case Kind::kForbiddenSide:
      return " point_m direction stiffness_N_per_m damping_Ns_per_m limit_N ";
    case Kind::kTube:
      return " path_m stiffness_N_per_m damping_Ns_per_m limit_N size_m ";
    case Kind::kViscosity:
      return " damping_Ns_per_m limit_N region point_m size_m fade_m ";
    case Kind::kVibration:
      return " direction amplitude_N frequency_Hz phase_rad region point_m size_m fade_m ";
    case Kind::kInertia:
      return " mass_kg stiffness_N_per_m damping_Ns_per_m limit_N region point_m size_m fade_m ";
    case Kind::kMagnet:
    case Kind::kSpringToVertex:
    case Kind::kSpringToEdge:
      return " stiffness_N_per_m damping_Ns_per_m limit_N reach_m release_m fade_m ";
    case Kind::kSamples:
      return " direction amplitude_N samples sample_rate_Hz region point_m size_m fade_m ";
    case Kind::kRecordedTexture:
      return " amplitude_N limit_N sample_rate_Hz speeds_m_per_s forces_N models ";
  }
  return "";
}

const pb::FieldDescriptor& fieldOf(std::string_view name) {
  return *v1::Effect::descriptor()->FindFieldByName(std::string(name));
}

bool isGiven(const v1::Effect& message, std::string_view name) {
  const pb::FieldDescriptor& field = fieldOf(name);
  const pb::Reflection& reflection = *message.GetReflection();
  return field.is_repeated() ? reflection.FieldSize(message, &field) > 0 : reflection.HasField(message, &field);
}

/// EFFECT_KIND_GUIDE
std::string nameOf(const pb::FieldDescriptor& field, int number) {
  return field.enum_type()->FindValueByNumber(number)->name();
}

/// The value of an enumeration, of which 0 stands for `absent`; 0: there has to be one.
template <class Enum>
Result<Enum> enumerator(const v1::Effect& message, std::string_view name, int absent) {
  const pb::FieldDescriptor& field = fieldOf(name);
  int number = message.GetReflection()->GetEnumValue(message, &field);
  if (number == 0) number = absent;
  const int count = field.enum_type()->value_count();
  if (number > 0 && number < count) return static_cast<Enum>(number);
  std::string right;
  for (int i = 1; i < count; ++i) right += (i == 1 ? "" : i + 1 < count ? ", " : " or ") + nameOf(field, i);
  const std::string what = number == 0 ? "is missing; give " : "is " + std::to_string(number) + "; give ";
  return refused(std::string(name), what + right);
}

Refusal takePath(const v1::Effect& message, std::vector<Vec3>& path) {
  const auto count = static_cast<std::size_t>(message.path_m_size());
  if (count % 3 != 0 || count < 6) {
    return Error{"path_m", "has " + std::to_string(count) + " numbers; give x, y and z of each of at least two points"};
  }
  if (count > 3 * kMaxPathPoints) {
    return Error{"path_m", "has " + std::to_string(count / 3) + " points; at most " + std::to_string(kMaxPathPoints) +
                               " make a path: leave out those that lie nearly on a line with their neighbours"};
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double value = message.path_m(static_cast<int>(i));
    const std::string at = "path_m[" + std::to_string(i) + "]";
    if (auto bad = checkRange(value, {-kMaxCoordinate_m, kMaxCoordinate_m, " m"}, at)) return bad;
  }
  for (std::size_t i = 0; i < count; i += 3) {
    const int at = static_cast<int>(i);
    path.emplace_back(message.path_m(at), message.path_m(at + 1), message.path_m(at + 2));
    const std::size_t point = path.size() - 1;
    if (point > 0 && !(glm::distance(path[point], path[point - 1]) >= kMinLength_m)) {
      return Error{"path_m", "has points " + std::to_string(point - 1) + " and " + std::to_string(point) +
                                 " (from 0) at the same place; leave one of them out"};
    }
  }
  return std::nullopt;
}

Refusal takeSamples(const v1::Effect& message, std::vector<float>& samples) {
  const auto count = static_cast<std::size_t>(message.samples_size());
  if (count < 2 || count > kMaxSamples) {
    return Error{"samples", "has " + std::to_string(count) + "; give 2 to " + std::to_string(kMaxSamples) +
                                ": a lower rate makes fewer, and none above half the servo's is felt"};
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float value = message.samples(static_cast<int>(i));
    if (auto bad = checkRange(value, {-1, 1, ""}, "samples[" + std::to_string(i) + "]")) return bad;
  }
  samples.assign(message.samples().begin(), message.samples().end());
  return std::nullopt;
}

std::string listName(std::string_view name, std::size_t i) { return std::string(name) + "[" + std::to_string(i) + "]"; }

/// Speeds or forces of the models of a recorded texture.
Refusal takeAscending(const pb::RepeatedField<double>& given, std::string_view name, Range range,
                      std::vector<double>& values) {
  if (given.empty() || static_cast<std::size_t>(given.size()) > kMaxTextureModels) {
    return Error{std::string(name),
                 "has " + std::to_string(given.size()) + "; give 1 to " + std::to_string(kMaxTextureModels)};
  }
  values.assign(given.begin(), given.end());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (auto bad = checkRange(values[i], range, listName(name, i))) return bad;
    if (i > 0 && !(values[i] > values[i - 1]))
      return outside(listName(name, i), values[i], "give more than the one before, " + numberText(values[i - 1]));
  }
  return std::nullopt;
}

/// Reflection coefficients within the unit circle have all poles there, and so has what is between two such models.
Refusal takeTexture(const v1::Effect& message, Effect& effect) {
  constexpr double kMaxReflection = 0.99999;
  if (auto bad = takeAscending(message.speeds_m_per_s(), "speeds_m_per_s", {1e-4, 10, " m/s"}, effect.speeds_m_per_s))
    return bad;
  if (auto bad = takeAscending(message.forces_n(), "forces_N", {1e-3, 100, " N"}, effect.forces_N)) return bad;
  const std::size_t count = effect.speeds_m_per_s.size() * effect.forces_N.size();
  if (count > kMaxTextureModels) {
    return Error{"speeds_m_per_s", "and forces_N make " + std::to_string(count) + " pairs; at most " +
                                       std::to_string(kMaxTextureModels) + " have a model"};
  }
  const auto size = static_cast<std::size_t>(message.models_size());
  if (size % count != 0 || size < 2 * count || size > (1 + kMaxTextureOrder) * count) {
    return Error{"models", "has " + std::to_string(size) + " numbers for " + std::to_string(count) +
                               " models; give each a deviation and equally many reflection coefficients, 1 to " +
                               std::to_string(kMaxTextureOrder)};
  }
  effect.models.assign(message.models().begin(), message.models().end());
  for (std::size_t i = 0; i < size; ++i) {
    const bool isDeviation = i % (size / count) == 0;
    const double least = isDeviation ? 0 : -kMaxReflection, most = isDeviation ? 1 : kMaxReflection;
    if (auto bad = checkRange(effect.models[i], {least, most, ""}, listName("models", i))) {
      if (!isDeviation) bad->reason += ": with more it has poles on the unit circle or beyond, and would not die away";
      return bad;
    }
  }
  return std::nullopt;
}

Refusal takeDirection(const v1::Effect& message, Vec3& direction) {
  direction = vectorFrom(message.direction());
  if (direction == Vec3(0)) return Error{"direction", "has length 0; give a direction of length 1"};
  return checkUnitVector(message.direction(), "direction");
}

/// Numbers that may stay away, and then are 0.
bool mayBeAbsent(Kind kind, const pb::FieldDescriptor& field) {
  return field.has_presence() || field.number() == v1::Effect::kPhaseRadFieldNumber ||
         (field.number() == v1::Effect::kDampingNsPerMFieldNumber && kind != Kind::kViscosity) ||
         field.number() == v1::Effect::kFadeMFieldNumber;
}

Refusal takeNumber(const v1::Effect& message, Kind kind, std::string_view name, double& value) {
  const pb::FieldDescriptor& field = fieldOf(name);
  value = message.GetReflection()->GetDouble(message, &field);
  if (mayBeAbsent(kind, field) && !isGiven(message, name)) return std::nullopt;
  if (kind == Kind::kViscosity && value == 0 && field.number() == v1::Effect::kDampingNsPerMFieldNumber)
    return Error{std::string(name), "is 0 or missing; viscosity has more than 0"};
  return checkScalar(value, field, std::string(name));
}

Refusal checkDiameter(const Effect& effect, const std::string& of) {
  if (auto bad = checkLength(effect.size_m.x, "size_m.x")) return bad;
  if (effect.size_m.y == 0 && effect.size_m.z == 0) return std::nullopt;
  return Error{"size_m", "has y or z; of a " + of + " only x is used, its diameter"};
}

Refusal checkRegion(const v1::Effect& message, const Effect& effect) {
  if (effect.region == Region::kEverywhere) {
    for (const char* name : {"point_m", "size_m", "fade_m"}) {
      if (isGiven(message, name)) return Error{name, "is given without a region; give one, or leave it out"};
    }
    return std::nullopt;
  }
  if (effect.region == Region::kInside) {
    for (const char* name : {"point_m", "size_m"}) {
      if (isGiven(message, name)) return Error{name, "is given, but the inside of an object has its own; leave it out"};
    }
    return std::nullopt;
  }
  if (effect.region == Region::kBox) return checkSize(message.size_m(), "size_m");
  return checkDiameter(effect, "sphere");
}

Refusal checkReach(const v1::Effect& message, const Effect& effect) {
  if (effect.reach_m == 0) {
    for (const char* name : {"release_m", "fade_m"}) {
      if (isGiven(message, name)) return Error{name, "is given without reach_m; give one, or leave it out"};
    }
    return std::nullopt;
  }
  if (isGiven(message, "release_m") && effect.release_m < effect.reach_m) {
    return outside("release_m", effect.release_m,
                   "give at least reach_m, " + numberText(effect.reach_m) + ": nearer, it would take hold and let go");
  }
  const double border_m = std::max(effect.reach_m, effect.release_m);
  if (effect.fade_m <= border_m) return std::nullopt;
  return outside("fade_m", effect.fade_m,
                 "give at most the way to the border, " + numberText(border_m) + " m, which release_m or reach_m is");
}

bool isOfMesh(const Effect& effect) noexcept {
  return effect.kind == Kind::kMagnet || effect.kind == Kind::kSpringToVertex || effect.kind == Kind::kSpringToEdge ||
         effect.kind == Kind::kRecordedTexture || effect.region == Region::kInside;
}

/// What is of the object's mesh is where that is; without an end, a search would be of all of it.
Refusal checkOfMesh(const v1::Effect& message, const Effect& effect) {
  if (!isOfMesh(effect)) return std::nullopt;
  if (effect.frame == Effect::Frame::kWorld)
    return Error{"frame", "is EFFECT_FRAME_WORLD; what is of the object's mesh moves with it: leave it out"};
  if (!usesField(effect.kind, "reach_m") || isGiven(message, "reach_m")) return std::nullopt;
  return Error{"reach_m", "is missing; give how near the hand has to be"};
}

Result<Effect> announcedEffectFrom(const v1::Effect& message) {
  Effect effect;
  if (auto bad = take(enumerator<Kind>(message, "kind", 0), effect.kind)) return refuse(bad);
  if (auto bad = take(enumerator<Effect::Frame>(message, "frame", v1::EFFECT_FRAME_OBJECT), effect.frame))
    return refuse(bad);
  if (auto bad = take(enumerator<Region>(message, "region", v1::EFFECT_REGION_EVERYWHERE), effect.region))
    return refuse(bad);
  if (auto bad = take(enumerator<Effect::Trigger>(message, "trigger", v1::EFFECT_TRIGGER_ALWAYS), effect.trigger))
    return refuse(bad);
  Refusal first;
  const auto read = [&]<class T>(std::size_t i, T& value) {
    const std::string name(fields::nameOf(Effect::kFieldNames, i));
    if (first || name == "kind" || name == "frame" || name == "trigger") return;
    const bool isUsed = usesField(effect.kind, name);
    if (!isUsed && isGiven(message, name) && !(name == "region" && effect.region == Region::kEverywhere))
      first =
          Error{name, "is given, but " + nameOf(fieldOf("kind"), message.kind()) + " does not use it; leave it out"};
    if (first || !isUsed) return;
    if constexpr (std::is_same_v<T, double>) first = takeNumber(message, effect.kind, name, value);
    if constexpr (std::is_same_v<T, std::vector<Vec3>>) first = takePath(message, value);
    if constexpr (std::is_same_v<T, std::vector<float>>) first = takeSamples(message, value);
  };
  fields::forEachMember(read, effect);
  if (first) return refuse(first);
  if (auto bad = checkPosition(message.point_m(), "point_m")) return refuse(bad);
  effect.point_m = vectorFrom(message.point_m());
  effect.size_m = vectorFrom(message.size_m());
  if (usesField(effect.kind, "direction")) {
    if (auto bad = takeDirection(message, effect.direction)) return refuse(bad);
  }
  if (usesField(effect.kind, "region")) {
    if (auto bad = checkRegion(message, effect)) return refuse(bad);
  }
  if (effect.kind == Kind::kTube) {
    if (auto bad = checkDiameter(effect, "tube")) return refuse(bad);
  }
  if (effect.kind == Kind::kRecordedTexture) {
    if (auto bad = takeTexture(message, effect)) return refuse(bad);
  }
  if (usesField(effect.kind, "reach_m")) {
    if (auto bad = checkReach(message, effect)) return refuse(bad);
  }
  if (auto bad = checkOfMesh(message, effect)) return refuse(bad);
  return effect;
}

}  // namespace

bool usesField(Kind kind, std::string_view field) {
  return fieldsUsedBy(kind).find(" " + std::string(field) + " ") != std::string_view::npos;
}

Result<std::vector<Effect>> announcedEffectsFrom(const pb::RepeatedPtrField<v1::Effect>& messages) {
  if (static_cast<std::size_t>(messages.size()) > kMaxEffects) {
    return refused("effects", "has " + std::to_string(messages.size()) + " entries; a scene has at most " +
                                  std::to_string(kMaxEffects));
  }
  std::vector<Effect> effects;
  bool isRecorded = false;
  for (int i = 0; i < messages.size(); ++i) {
    auto effect = announcedEffectFrom(messages[i]);
    const std::string field = listName("effects", static_cast<std::size_t>(i)) + ".";
    if (auto bad = take(std::move(effect), effects.emplace_back(), field)) return refuse(bad);
    if (effects.back().kind != Kind::kRecordedTexture) continue;
    if (isRecorded) return refused(field + "kind", "is EFFECT_KIND_RECORDED_TEXTURE again; give an object one of them");
    isRecorded = true;
  }
  return effects;
}

Result<std::vector<Effect>> effectsFrom(const pb::RepeatedPtrField<v1::Effect>& messages) {
  auto effects = announcedEffectsFrom(messages);
  if (!effects) return effects;
  for (Effect& effect : *effects) {
    if (effect.direction != Vec3(0)) effect.direction = normalised(effect.direction);
  }
  return effects;
}

void toWire(const std::vector<Effect>& effects, pb::RepeatedPtrField<v1::Effect>& messages) {
  messages.Clear();
  for (const Effect& effect : effects) {
    v1::Effect& message = *messages.Add();
    const pb::Reflection& reflection = *message.GetReflection();
    const auto write = [&]<class T>(std::size_t i, const T& value) {
      const pb::FieldDescriptor& field = fieldOf(fields::nameOf(Effect::kFieldNames, i));
      if constexpr (std::is_same_v<T, Effect::Trigger>) {
        if (value != Effect::Trigger::kAlways) message.set_trigger(static_cast<v1::EffectTrigger>(value));
      } else if constexpr (std::is_enum_v<T>) {
        reflection.SetEnumValue(&message, &field, static_cast<int>(value));
      } else if constexpr (std::is_same_v<T, double>) {
        if (value != 0) reflection.SetDouble(&message, &field, value);
      } else if constexpr (std::is_same_v<T, Vec3>) {
        if (value != Vec3(0)) toWire(value, static_cast<v1::Vector3&>(*reflection.MutableMessage(&message, &field)));
      } else if constexpr (std::is_same_v<T, std::vector<float>>) {
        message.mutable_samples()->Add(value.begin(), value.end());
      } else if constexpr (std::is_same_v<T, std::vector<double>>) {
        for (const double number : value) reflection.AddDouble(&message, &field, number);
      } else {
        for (const Vec3& point : value) {
          for (const double number : {point.x, point.y, point.z}) message.add_path_m(number);
        }
      }
    };
    fields::forEachMember(write, effect);
  }
}

}  // namespace haptics
