#pragma once

#include <filesystem>

#include "haptic_server/servo/stiffness_limit.h"

namespace haptics {

/// Keeps what surfaceLimits() found, in a file of its own for each device, rate and delay: a search takes longer the higher
/// the rate is. A file is named and headed by a hash of all that the result depends on, the sources of the step included;
/// one that is damaged or cannot be read or written is as none.
class SurfaceLimitsCache {
 public:
  /// @param folder  Made where there is none. Empty: nothing is kept.
  explicit SurfaceLimitsCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// $XDG_CACHE_HOME/haptics, ~/.cache/haptics where that is not set; empty where there is no home either.
  [[nodiscard]] static std::filesystem::path userFolder();

  struct Found {
    SurfaceLimits limits;
    bool searched = false;  ///< Not read from a file.
  };
  [[nodiscard]] Found find(const DeviceInfo& device, double rate_Hz, bool stabilised) const;

  /// Where the limits of this device are kept.
  [[nodiscard]] std::filesystem::path fileFor(const DeviceInfo& device, double rate_Hz, bool stabilised) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace haptics
