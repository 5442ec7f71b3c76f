#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace haptics::eval {

/// The real graphics_client, found beside this program, drawing offscreen, connected to a server of ours.
class ViewerProcess {
 public:
  /// Throws std::runtime_error when it cannot be started. Needs DISPLAY.
  ViewerProcess(std::uint16_t port, std::filesystem::path summary);
  ~ViewerProcess();
  ViewerProcess(const ViewerProcess&) = delete;
  ViewerProcess& operator=(const ViewerProcess&) = delete;

  /// Waits until it holds this revision, proven equal by its hash. False when that takes longer.
  [[nodiscard]] bool holds(std::uint64_t revision, double patience_s);
  /// Ends it in order. Returns the frames that it drew in a second.
  double finish();

 private:
  std::filesystem::path summary_;
  pid_t process_ = 0;
  int output_ = -1;
  std::string said_;  // not yet read to the line's end
  std::uint64_t held_ = 0;
};

}  // namespace haptics::eval
