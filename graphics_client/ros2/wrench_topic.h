#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "graphics_client/mirror/server_link.h"
#include "graphics_client/ros2/dds.h"
#include "graphics_client/ros2/message_types.h"

namespace haptics {

/// What other programs add to the force of a hand. The newest counts; a thousand a second go to the server at most.
class WrenchTopic {
 public:
  /// Gets a line where something is wrong, at most one a second.
  using Say = std::function<void(const std::string&)>;

  /// The link outlives this.
  /// @param hand  As the server numbers them, from 0.
  WrenchTopic(const dds::Participant& participant, const std::string& topic, std::size_t hand, ServerLink& link,
              Say say);

 private:
  ServerLink& link_;
  const std::size_t hand_;
  const std::string topic_;
  const Say say_;
  std::uint64_t quietUntil_ns_ = 0;
  dds::Subscription<ros2::WrenchStamped> subscription_;  // its thread ends first

  void take(const ros2::WrenchStamped& message);
  void refuse(const std::string& why);
};

}  // namespace haptics
