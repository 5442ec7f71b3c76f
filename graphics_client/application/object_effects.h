#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graphics_client/application/object_properties.h"

// What a user sees and sets of the effects that an object carries. An edit replaces all of an object's effects: each operation here
// is made of the record as it then is, and so keeps the others.
namespace haptics {

/// An effect of an object. Another kind at its place is another effect.
struct EffectPlace {
  std::size_t number = 0;  ///< Among the object's, from 0.
  Effect::Kind kind = Effect::Kind::kConstant;
  bool operator==(const EffectPlace&) const = default;
};

/// A place of an object that handles in the picture move, with a direction that they turn.
struct HandleSpot {
  std::optional<EffectPlace> effect = std::nullopt;  ///< None: the object's joint.
  std::size_t pathPoint = 0;                         ///< Of an effect's path.
  bool operator==(const HandleSpot&) const = default;
};

/// Null: it is not there any more.
[[nodiscard]] const Effect* effectAt(const ObjectRecord& object, const EffectPlace& place);

/// "spring to point".
[[nodiscard]] std::string effectName(Effect::Kind kind);
/// That can be added without data of their own: a recorded texture is made of a recording (make_texture.py).
[[nodiscard]] std::vector<Effect::Kind> effectKinds();
/// Felt at the upper side of a box, and there alone where its kind has a place.
[[nodiscard]] Effect usualEffect(Effect::Kind kind, const ObjectBox& box);

/// The fields that the kind has.
[[nodiscard]] std::vector<NumberProperty> effectNumbers(const EffectPlace& place);
[[nodiscard]] std::vector<ChoiceProperty> effectChoices(const EffectPlace& place);
/// Of a point of its path.
[[nodiscard]] std::vector<NumberProperty> pathNumbers(const EffectPlace& place, std::size_t point);

void addEffect(const ObjectRecord& object, Effect effect, v1::Operation& operation);
/// Refused: it is not there any more. Likewise below.
[[nodiscard]] Result<void> removeEffect(const ObjectRecord& object, const EffectPlace& place, v1::Operation& operation);
/// Adds a point half-way to the next, or beyond the last.
[[nodiscard]] Result<void> addPathPoint(const ObjectRecord& object, const EffectPlace& place, std::size_t after,
                                        v1::Operation& operation);
[[nodiscard]] Result<void> removePathPoint(const ObjectRecord& object, const EffectPlace& place, std::size_t point,
                                           v1::Operation& operation);

/// A spot as it stands, in its frame.
struct SpotState {
  std::optional<Vec3> point_m = std::nullopt;    ///< None: it has a direction alone, shown at the frame's origin.
  std::optional<Vec3> direction = std::nullopt;  ///< Unit.
  bool isInWorld = false;                        ///< Else in the object's frame.
};
/// Nothing: there is nothing to drag.
[[nodiscard]] std::optional<SpotState> spotState(const ObjectRecord& object, const HandleSpot& spot);
[[nodiscard]] Result<void> setSpot(const ObjectRecord& object, const HandleSpot& spot, const SpotState& state,
                                   v1::Operation& operation);

}  // namespace haptics
