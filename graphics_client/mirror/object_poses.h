#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "common/maths/vec.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// Where other programs have the objects, told to the server as a stream of samples that push the hand
/// (SetPose::kinematic). One transaction is in flight at most; while it is, an object's newest pose replaces the one that
/// waits, so that no flood reaches the server; one that the server refuses holds up no other. Any thread.
class ObjectPoses {
 public:
  /// Gets a line where something is wrong, at most one a second.
  using Say = std::function<void(const std::string&)>;

  /// The link outlives this.
  ObjectPoses(ServerLink& link, Say say);
  ~ObjectPoses();
  ObjectPoses(const ObjectPoses&) = delete;
  ObjectPoses& operator=(const ObjectPoses&) = delete;

  /// @param pose  World; the rotation need not be of unit length. One that is not finite, or whose rotation is none, and of an
  ///              object that the scene does not have, is refused.
  void set(std::string_view object, const Pose& pose);
  /// Says so.
  void refuse(std::string_view object, const std::string& why);

 private:
  struct Stream;
  std::shared_ptr<Stream> stream_;
};

}  // namespace haptics
