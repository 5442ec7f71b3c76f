#include "tests/eval/correction_figures/ablations.h"

#include <algorithm>
#include <array>

#include "tests/eval/corrections_off.h"

namespace haptics::eval {
namespace {

struct Ablation {
  std::string_view name;
  const Corrections& corrections;
};

constexpr std::array kAblations{
    Ablation{"ours", kAllCorrections},
    Ablation{"ours_float", kInFloat},
    Ablation{"ours_without_feature_codes", kWithoutFeatureCodes},
    Ablation{"ours_without_pseudonormals", kWithoutPseudonormals},
    Ablation{"ours_without_same_tick_search", kWithoutSameTickSearch},
    Ablation{"ours_without_exit_retest", kWithoutExitRetest},
    Ablation{"ours_without_object_frames", kWithoutObjectFrames},
    Ablation{"ours_without_containment", kWithoutContainment},
    Ablation{"ours_without_guard", kWithoutGuard},
    Ablation{"ours_without_several_surfaces", kWithoutSeveralSurfaces},
    Ablation{"ours_without_budget", kWithoutBudget},
    Ablation{"ours_without_scale_free_tolerances", kWithoutScaleFreeTolerances},
    Ablation{"ours_without_substeps", kWithoutSubsteps},
    Ablation{"ours_without_watertight_test", kWithoutWatertightTest},
};

}  // namespace

std::unique_ptr<Renderer> makeAblation(std::string_view name) {
  const auto found = std::ranges::find(kAblations, name, &Ablation::name);
  return found == kAblations.end() ? nullptr : std::make_unique<AblatedMethod>(found->corrections);
}

}  // namespace haptics::eval
