#pragma once

#include <string>

namespace haptics {

/// Who leads the simulated hand, as the server last said.
struct HandLeader {
  bool led = false;        ///< By somebody; else the hand explores.
  bool isSelf = false;     ///< By this client.
  std::string clientName;  ///< Of the leader.
  std::string refused;     ///< Why this client does not lead; empty: it was not refused.
};

}  // namespace haptics
