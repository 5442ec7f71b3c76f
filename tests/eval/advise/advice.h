#pragma once

#include "tests/eval/advise/candidate.h"
#include "tests/eval/advise/steadiness.h"
#include "tests/eval/report.h"

namespace haptics::eval {

/// What one object needs.
struct ObjectAdvice {
  std::string name;
  std::vector<Candidate> candidates;  ///< Finest first; none where no hand gets to the object from above.
  std::size_t advised = 0;            ///< The coarsest of which it and all finer ones are good.
};

/// How the advised meshes rest under a device at one rate.
struct RateAdvice {
  double rate_Hz;
  bool steady = true;                 ///< On every object, with no hand and with a light one.
  double worstCycle_um = 0;           ///< Limit cycle.
  std::vector<std::string> unsteady;  ///< Object, hand and what happens.
  double passiveTo_N_per_m = 0;       ///< min(2b/T, 2f/quantum) of the device alone (Abbott and Okamura 2005).
};

/// What the whole scene needs.
struct SceneAdvice {
  std::vector<ObjectAdvice> objects;
  std::vector<RateAdvice> rates;  ///< Rising.

  /// Lowest steady rate; null when none is.
  [[nodiscard]] const RateAdvice* advisedRate() const;
};

/// @param tolerance  As in candidatesFor().
[[nodiscard]] SceneAdvice adviceFor(std::vector<LoadedObject> scene, const DevicePreset& device, double tolerance);

/// In words, for a terminal.
void print(const SceneAdvice& advice, const DevicePreset& device);
[[nodiscard]] std::vector<Record> recordsOf(const SceneAdvice& advice);

}  // namespace haptics::eval
