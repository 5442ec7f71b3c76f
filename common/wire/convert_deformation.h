#pragma once

#include "common/error/error.h"
#include "common/scene/deformation_properties.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// How an object's shape gives, of an edit. Checked but for what needs the mesh. Errors name the field below Deformation
/// ("softness.radius_m").
[[nodiscard]] Result<DeformationEdit> deformationFrom(const v1::Deformation& message);
/// The same of a state.
[[nodiscard]] Result<DeformationProperties> announcedDeformationFrom(const v1::Deformation& message);
void toWire(const DeformationProperties& properties, v1::Deformation& message);

}  // namespace haptics
