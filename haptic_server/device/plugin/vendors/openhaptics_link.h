#pragma once

#include <cstdint>

#include "haptic_server/device/plugin/device_plugin.h"

namespace haptics {

/// Between the plug-in and the process that has the maker's library: datagrams of a socket, its descriptor 3 there.
inline constexpr int kHostSocket = 3;

/// To the plug-in, first of all.
struct HostHello {
  char refusal[256];  ///< Empty: the device is open.
  haptics_device_info info;
};

/// To the plug-in, each millisecond. In the server's frame.
struct HostState {
  haptics_device_state state;
  std::uint64_t measured_ns;  ///< CLOCK_MONOTONIC.
  std::uint32_t isBroken;     ///< 1: there is no position; the condition says why.
  std::uint32_t reserved;
};

/// From the plug-in. N, the server's frame.
struct HostForce {
  double force_N[3];
};

}  // namespace haptics
