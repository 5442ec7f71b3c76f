#pragma once

#include <algorithm>
#include <optional>

#include "tests/eval/advise/candidate.h"
#include "tests/eval/advise/failure_motions.h"
#include "tests/eval/advise/features.h"
#include "tests/eval/advise/material_option.h"
#include "tests/eval/advise/tool_spacing.h"
#include "tests/eval/report.h"

namespace haptics::eval {

/// What is to be done with an object's mesh.
struct Verdict {
  bool use = false;  ///< Another mesh in place of the scene's.
  std::string text;  ///< "use torus.ply, 5,792 of 16,384 triangles, saves 0.6 MB", "keep; ...", "not judged: ...".
};

/// What one object needs.
struct ObjectAdvice {
  std::string name;
  std::vector<Candidate> candidates;  ///< Finest first; none where no hand gets to the object from above.
  std::size_t advised = 0;            ///< The mesh to use.
  Verdict verdict;
  std::vector<SceneFeature> features;
  std::vector<FailureMotion> motions;      ///< With the advised meshes; none where the mesh is open.
  std::optional<ForceDifference> checked;  ///< The written scene, by other strokes than it was advised by.
  double textureRate_Hz = 0;               ///< That its finest felt pattern asks for (patternRate_Hz()); 0: none.
  std::vector<MaterialOption> options;     ///< None where there are no candidates.

  [[nodiscard]] bool judged() const noexcept { return !candidates.empty(); }
  /// No check, or one that the hand felt in no more than 1 % of the ticks.
  [[nodiscard]] bool checkedWell() const noexcept {
    return !checked || (checked->felt_ratio <= 0.01 && checked->wrongSideTicks == 0);
  }
  /// No motion leaves the IHIP inside.
  [[nodiscard]] bool holds() const noexcept { return std::ranges::all_of(motions, &FailureMotion::holds); }
  [[nodiscard]] const Candidate& mesh() const { return candidates[advised]; }
  /// The scene's own material.
  [[nodiscard]] const MaterialOption& ownOption() const;
  /// The own material where it is steady at this rate, else of the good ones the one that is nearest to it; null when that
  /// is not good, or there is none.
  [[nodiscard]] const MaterialOption* optionAt(std::size_t rate) const;
  /// "stiffness up", "stiffness down", "damping up", "damping down", both of the options; empty when it is no such step.
  [[nodiscard]] std::string stepBetween(const MaterialOption& from, const MaterialOption& to) const;
};

/// What the whole scene needs.
struct SceneAdvice {
  std::vector<ObjectAdvice> objects;
  std::optional<ToolAdvice> tool;   ///< Where the hand holds one; it is none of the objects then.
  std::optional<std::size_t> rate;  ///< The lowest at which every object has a good option; none when there is none.

  /// The option that is advised for an object: at the advised rate, or where there is none its own.
  [[nodiscard]] const MaterialOption& optionOf(const ObjectAdvice& object) const;
};

/// @param tolerance  As in candidatesFor().
[[nodiscard]] SceneAdvice adviceFor(std::vector<LoadedObject> scene, const DevicePreset& device, double tolerance);

/// "motion (judged at rest), softness (judged as rigid)"; empty where there is nothing that is not judged.
[[nodiscard]] std::string notJudgedOf(const ObjectAdvice& object);
/// "texture, which costs 35 ns a tick"; empty where all that is judged is felt.
[[nodiscard]] std::string notFeltOf(const ObjectAdvice& object);
/// Of the advised rate, which criteria the next lower one fails: "250 Hz fails: tap on torus".
[[nodiscard]] std::string decidedBy(const SceneAdvice& advice, const DevicePreset& device);

/// In words, for a terminal.
void print(const SceneAdvice& advice, const DevicePreset& device);
[[nodiscard]] std::vector<Record> recordsOf(const SceneAdvice& advice, const DevicePreset& device);

/// Of a rate: how the options that are best there do.
struct RateSummary {
  std::vector<std::string> fails;     ///< Criterion and object: "tap on torus", "rest on box", "texture of tile".
  double epsilon_p99 = 0;             ///< Of the object that feels most different.
  double worstCycle_um = 0;           ///< Limit cycle.
  std::vector<std::string> unsteady;  ///< Object, hand and what happens.
  double core_ratio = 0;              ///< Of a processor core, for the contact on the slowest object.
  double passiveTo_N_per_m = 0;  ///< min(2b/T, 2f/quantum) of the device alone, without stabiliser and hand (Abbott
                                 ///< and Okamura 2005).

  [[nodiscard]] bool good() const noexcept { return fails.empty(); }
};
[[nodiscard]] RateSummary summaryAt(const SceneAdvice& advice, std::size_t rate, const DevicePreset& device);

}  // namespace haptics::eval
