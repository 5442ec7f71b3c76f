#pragma once

#include <span>

#include "haptic_server/engine/contact/body.h"
#include "haptic_server/engine/tool/tool_contact.h"

namespace haptics::eval {

/// A tool whose points are pushed out of closed bodies by springs, along the way to the nearest surface, and that hangs on the
/// device by its coupling: the point shell of McNeely, Puterbaugh & Troy (1999), at rest in every tick. **Deviation**: the
/// depth is measured against the triangles, not against voxels.
class PenaltyShell {
 public:
  PenaltyShell(const Tool& tool, const ToolCoupling& coupling) : tool_(tool), coupling_(coupling) {}

  void reset(const Pose& device) { pose_ = device; }
  /// @return Where the tool is.
  const Pose& follow(std::span<const Body> bodies, const Pose& device);

 private:
  const Tool& tool_;
  ToolCoupling coupling_;
  Pose pose_;
};

}  // namespace haptics::eval
