#pragma once

#include <cstdint>

namespace haptics {

/// While one lives, heap allocations and frees by its thread are counted. Programs that link the servo library
/// count through malloc itself, so libraries are seen too.
class AllocationTripwire {
 public:
  AllocationTripwire() noexcept;
  ~AllocationTripwire();
  AllocationTripwire(const AllocationTripwire&) = delete;
  AllocationTripwire& operator=(const AllocationTripwire&) = delete;

  /// Counted in all threads since the program began.
  [[nodiscard]] static std::uint64_t count() noexcept;
  static void heapTouched() noexcept;  ///< Called by the hooks.
};

}  // namespace haptics
