#pragma once

#include <string>
#include <vector>

#include "haptic_server/doctor/machine_facts.h"
#include "haptic_server/doctor/wake_up_probe.h"

namespace haptics {

enum class Verdict {
  kGood,
  kWorse,    ///< The servo runs, and may be late more often than it need be.
  kMissing,  ///< The servo cannot be real-time.
};

/// One thing that matters to the servo, in plain words.
struct Finding {
  std::string what;
  std::string found;
  Verdict verdict = Verdict::kGood;
  std::string advice = {};  ///< What to change; empty when nothing is to be.
};

/// What the machine permits and how it is set up.
[[nodiscard]] std::vector<Finding> judge(const MachineFacts& facts);
/// How punctual it was.
[[nodiscard]] Finding judge(const WakeUps& wakeUps, double rate_Hz);

}  // namespace haptics
