#include "haptic_server/recording/recording_quota.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <system_error>
#include <vector>

namespace haptics {
namespace fs = std::filesystem;
namespace {

struct Recording {
  fs::path path;
  std::size_t bytes = 0;
};

/// Newest first.
std::vector<Recording> recordingsIn(const fs::path& folder) {
  std::vector<Recording> recordings;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code unknown;
    const std::uintmax_t bytes = at->file_size(unknown);
    if (!unknown && isFlightRecording(at->path())) recordings.push_back({at->path(), bytes});
  }
  std::ranges::sort(recordings, std::ranges::greater(), &Recording::path);
  return recordings;
}

bool isOfFault(const Recording& recording) {
  return recording.path.filename().string().find("-on_request") == std::string::npos;
}

/// Oldest first, as long as it is asked for more.
void removeOldest(std::vector<Recording> recordings,
                  const std::function<bool(const std::vector<Recording>&)>& isTooMuch) {
  const auto newestFault = std::ranges::find_if(recordings, isOfFault);
  const fs::path kept = newestFault == recordings.end() ? fs::path() : newestFault->path;
  while (isTooMuch(recordings)) {
    const auto oldest = std::find_if(recordings.rbegin(), recordings.rend(),
                                     [&](const Recording& recording) { return recording.path != kept; });
    if (oldest == recordings.rend() || oldest->path == recordings.front().path) return;
    std::error_code ignored;  // a file that cannot be removed costs its space
    fs::remove(oldest->path, ignored);
    recordings.erase(std::next(oldest).base());
  }
}

/// Free, but for what is to be left.
std::int64_t spare_bytes(const fs::path& folder, const RecordingQuota& quota) {
  constexpr std::uintmax_t kTenth = 10;
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error) return 1;  // writing will tell
  const std::uintmax_t left = std::min<std::uintmax_t>(quota.leave_bytes, space.capacity / kTenth);
  return static_cast<std::int64_t>(space.available) - static_cast<std::int64_t>(left);
}

}  // namespace

bool isFlightRecording(const fs::path& file) {
  return file.filename().string().starts_with("flight-") && file.extension() == ".haptics";
}

void rotateRecordings(const fs::path& folder, const RecordingQuota& quota) {
  removeOldest(recordingsIn(folder), [&](const std::vector<Recording>& recordings) {
    std::size_t bytes = 0;
    for (const Recording& recording : recordings) bytes += recording.bytes;
    return recordings.size() > quota.maxFiles || bytes > quota.most_bytes;
  });
}

Result<void> makeRoomForRecording(const fs::path& folder, const RecordingQuota& quota) {
  removeOldest(recordingsIn(folder), [&](const std::vector<Recording>&) { return spare_bytes(folder, quota) <= 0; });
  if (spare_bytes(folder, quota) > 0) return {};
  return refused(folder.string(), "the disk is full but for what is kept free of recordings");
}

}  // namespace haptics
