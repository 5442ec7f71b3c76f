#pragma once

#include <numbers>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/scene/deformation_properties.h"
#include "common/scene/effect_properties.h"
#include "common/scene/motion_properties.h"
#include "common/scene/surface_edits.h"
#include "haptics/v1/scene.pb.h"

// An object's properties between the wire and the program. Everything is checked but for what needs the mesh. What an
// edit asks for comes out in the form of records: axes, directions, normals and rotations normalised, creases in order.
// Of a state ("announced") every number is kept bit for bit, and every source is an asset. Errors name the field below
// the message ("texture.amplitude_m").
namespace haptics {

inline constexpr double kMaxJointAngle_rad = 200 * std::numbers::pi;  ///< Several whole turns: a knob may have them.

/// A family, and where the field of each mapped or grown one in it comes from (whose hash is in place when that is an
/// asset).
struct FieldEdit {
  FieldFamily family;
  std::vector<FamilySource> sources;
};
/// Every number is kept bit for bit.
[[nodiscard]] Result<FieldEdit> fieldFrom(const v1::ScalarField& message);
/// Directions and rotations to unit length.
void normalise(FieldFamily& family);
void toWire(const FieldFamily& family, v1::ScalarField& message);

[[nodiscard]] Result<SurfaceEdit> surfaceFrom(const v1::Material& message);
[[nodiscard]] Result<SurfaceProperties> surfaceFrom(const v1::ObjectState& message);
void toWire(const SurfaceProperties& properties, v1::ObjectState& message);

[[nodiscard]] Result<MotionProperties> motionFrom(const v1::Motion& message);
[[nodiscard]] Result<MotionProperties> announcedMotionFrom(const v1::Motion& message);
void toWire(const MotionProperties& properties, v1::Motion& message);

[[nodiscard]] Result<DeformationEdit> deformationFrom(const v1::Deformation& message);
[[nodiscard]] Result<DeformationProperties> announcedDeformationFrom(const v1::Deformation& message);
void toWire(const DeformationProperties& properties, v1::Deformation& message);

/// Errors name "effects[2].reach_m".
[[nodiscard]] Result<std::vector<Effect>> effectsFrom(const google::protobuf::RepeatedPtrField<v1::Effect>& messages);
[[nodiscard]] Result<std::vector<Effect>> announcedEffectsFrom(
    const google::protobuf::RepeatedPtrField<v1::Effect>& messages);
/// @param field  Of v1::Effect, beside kind, frame and trigger, which all have.
[[nodiscard]] bool usesField(Effect::Kind kind, std::string_view field);
void toWire(const std::vector<Effect>& effects, google::protobuf::RepeatedPtrField<v1::Effect>& messages);

}  // namespace haptics
