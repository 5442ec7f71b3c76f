#pragma once

#include <optional>
#include <string_view>

#include "tests/eval/fuzz/edit_drive.h"
#include "tests/eval/fuzz/solid_oracle.h"

namespace haptics::eval {

enum class EditFailure {
  kStep,       ///< The written force changes by more than kMaxStep_N_per_s allows in a tick.
  kInside,     ///< The IHIP is inside of a closed body when the edit is to be felt in full.
  kUnfelt,     ///< The edit is not adopted by then, or not felt in full.
  kNotFinite,  ///< A force.
};
[[nodiscard]] std::string_view nameOf(EditFailure failure);

/// What an edit did under a HIP at rest.
struct EditVerdict {
  double step_N = 0;       ///< Of the written force from tick to tick, the largest,
  double excess_N = 0;     ///< by how much one is above what is allowed, the largest,
  std::uint64_t tick = 0;  ///< and where.
  double inside_m = 0;     ///< When it is to be felt in full; 0 outside of all, and where it was inside before.
  double missing_N = 0;    ///< Likewise, of the force that the scene's own parameters say.
  bool adopted = true;
  bool finite = true;

  [[nodiscard]] std::optional<EditFailure> failure() const;
};

/// Judges what is felt from an edit on while the HIP rests.
///
/// Every change of the written force is the edit's, but for these.
///  - What also comes in a run that goes on from the same state without the edit: the largest of its steps is allowed on
///    top of the limit.
///  - What a viscous tissue gives way at a penetration that stays, no faster than its own time constant.
///  - Ticks in which the dynamics, and not an edit, move a body at the HIP by more than 10 um a second are not judged: such a
///    body pushes, slips off and strikes as it does without edits. By less, its spring follows. In the tick of an adoption,
///    which is judged always, it may go on as it did in the tick before.
/// Some time after the edit the IHIP is looked for inside of all closed bodies by winding number, at rest and the touched
/// one as it is dented, and the force is compared with the scene's own stiffness times the penetration, unless it is so far
/// from what was felt on the way that it cannot be there yet, or a body moves there.
class EditJudge {
 public:
  static constexpr double kMaxStep_N_per_s = 35;

  explicit EditJudge(const EditRun& run) : run_(run) {}

  /// Before the tick of the edit.
  void begin(EditDrive& drive);
  /// After each tick from then on, the HIP being the same.
  void observe(EditDrive& drive, Vec3 hip);
  /// When the edit is to be felt in full.
  void settle(const EditDrive& drive);
  /// After the last tick.
  [[nodiscard]] EditVerdict end();
  /// Of the IHIP after the last tick, in the deepest closed body that does not leave; 0 outside of all.
  [[nodiscard]] double depth_m(const EditDrive& drive);

 private:
  void observeTwin(EditDrive& drive, Vec3 hip);
  [[nodiscard]] double relaxation_N(const EditDrive& drive) const;
  [[nodiscard]] double motion_N(const EditDrive& drive, double moved_m) const;
  [[nodiscard]] double missing_N(const EditDrive& drive) const;
  [[nodiscard]] SolidOracle dentedOracle(const HapticState& state, std::size_t body, const FuzzObject& object) const;
  [[nodiscard]] const SolidOracle& oracle(std::size_t mesh);

  const EditRun& run_;
  std::vector<std::optional<SolidOracle>> oracles_;
  EditVerdict verdict_;
  double most_N_ = 0;  // of the contact since then
  Vec3 last_N_{0};
  Vec3 lastContact_N_{0};
  double flutter_N_ = 0;  // largest jump of the contact force of late
  std::uint64_t lastObject_ = 0;
  double lastMoved_m_ = 0;
  double lastStep_N_ = 0;
  Vec3 twinLast_N_{0};
  std::uint64_t twinLastObject_ = 0;
  double twinStep_N_ = 0;  // while no body moves
  double twinAnyStep_N_ = 0;
  bool twin_ = false;
  bool insideBefore_ = false;
  struct Step {
    std::uint64_t tick;
    double above_N;  // the limit and what relaxes
  };
  Step worst_{};
  Step worstAdoption_{};  // of bodies that move
};

/// Runs the step along a run and judges all of its windows. @return The first failure, or the first of one kind.
struct EditFinding {
  EditFailure failure;
  std::size_t window = 0;
  EditVerdict verdict;
};
[[nodiscard]] std::optional<EditFinding> findFailure(const EditRun& run,
                                                     std::optional<EditFailure> kind = std::nullopt);

}  // namespace haptics::eval
