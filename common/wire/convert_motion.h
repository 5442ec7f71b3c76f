#pragma once

#include "common/error/error.h"
#include "common/scene/motion_properties.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// How an object moves, of an edit. Checked but for what needs the mesh; axes and normals come out normalised. Errors name
/// the field below Motion ("hinge.axis").
[[nodiscard]] Result<MotionProperties> motionFrom(const v1::Motion& message);
/// The same of a state: every number is kept bit for bit.
[[nodiscard]] Result<MotionProperties> announcedMotionFrom(const v1::Motion& message);
void toWire(const MotionProperties& properties, v1::Motion& message);

}  // namespace haptics
