#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "common/hash/content_hash.h"
#include "haptic_server/state/record_chain.h"

namespace haptics {

/// Reads the files of a state folder again and again, so that what a disk damages is found while the server still holds
/// the scene, not when it starts and no longer does. On a thread of its own, which gives way to the others at the
/// processor and the disk; what was just read is not left in the page cache, which would hide the disk.
class StateScrubber {
 public:
  struct Options {
    std::filesystem::path folder;
    /// Those that the scene names now. Both functions are called on the scrubber's thread.
    std::function<std::vector<ContentHash>()> assets;
    /// This file is missing or damaged: of this asset, or, with none, of the log or its checkpoint. Reported once, until it
    /// was whole again; false: to be reported again.
    std::function<bool(const std::filesystem::path& file, const std::optional<ContentHash>& asset)> repair;
    /// Before each file, so that it is about one in this time; shorter finds damage sooner and reads more.
    std::chrono::milliseconds pause = std::chrono::seconds(2);
    std::size_t rate_bytes_per_s = std::size_t(8) << 20;  ///< Within a file.
  };

  explicit StateScrubber(Options options);  ///< Starts.
  ~StateScrubber();                         ///< Stops.

 private:
  struct LogCheck {
    LogEnd end = LogEnd::kWhole;
    std::size_t offset = 0;
    bool operator==(const LogCheck&) const = default;
  };
  Options options_;
  std::set<std::filesystem::path> reported_;  // damaged, and not seen whole since
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;  // guarded by mutex_
  std::thread thread_;

  void run();
  void scrub();
  [[nodiscard]] bool wait(std::chrono::nanoseconds time);
  template <class Take>
  [[nodiscard]] bool readSlowly(const std::filesystem::path& file, Take take);
  [[nodiscard]] std::optional<LogCheck> checkLog(const std::filesystem::path& file);
  void scrubLog(const char* name);
  void scrubAsset(const ContentHash& asset);
  void report(const std::filesystem::path& file, const std::optional<ContentHash>& asset);
};

}  // namespace haptics
