#pragma once

#include <memory>
#include <string>

#include "graphics_client/mirror/server_link.h"
#include "graphics_client/ros2/dds.h"
#include "graphics_client/ros2/message_types.h"

namespace haptics {

/// Edits of the scene for other programs: a service of ROS 2, of the type haptics_msgs/srv/Edit. Each request is answered once:
/// when the edit is felt, or is refused, or at once where there is no server. An edit whose answer is lost with the server's is
/// not answered.
class EditService {
 public:
  /// The link outlives this.
  EditService(const dds::Participant& participant, const std::string& name, ServerLink& link);

 private:
  struct Replies;

  ServerLink& link_;
  std::shared_ptr<Replies> replies_;                   // also of edits whose answer comes after this
  dds::Subscription<ros2::EditRequest> subscription_;  // its thread ends first

  void take(const ros2::EditRequest& request);
};

}  // namespace haptics
