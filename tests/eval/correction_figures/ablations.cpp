#include "tests/eval/correction_figures/ablations.h"

#include <algorithm>
#include <array>

#include "tests/eval/corrections_off.h"

namespace haptics::eval {
namespace {

struct Ablation {
  std::string_view name;
  std::unique_ptr<Renderer> (*make)();
};

template <class Corrections>
std::unique_ptr<Renderer> make() {
  return std::make_unique<OursUnder<Corrections>>();
}

constexpr std::array kAblations{
    Ablation{"ours", make<AllCorrections>},
    Ablation{"ours_float", make<InFloat>},
    Ablation{"ours_without_feature_codes", make<WithoutFeatureCodes>},
    Ablation{"ours_without_pseudonormals", make<WithoutPseudonormals>},
    Ablation{"ours_without_same_tick_search", make<WithoutSameTickSearch>},
    Ablation{"ours_without_exit_retest", make<WithoutExitRetest>},
    Ablation{"ours_without_object_frames", make<WithoutObjectFrames>},
    Ablation{"ours_without_containment", make<WithoutContainment>},
    Ablation{"ours_without_guard", make<WithoutGuard>},
    Ablation{"ours_without_several_surfaces", make<WithoutSeveralSurfaces>},
    Ablation{"ours_without_budget", make<WithoutBudget>},
    Ablation{"ours_without_scale_free_tolerances", make<WithoutScaleFreeTolerances>},
    Ablation{"ours_without_substeps", make<WithoutSubsteps>},
    Ablation{"ours_without_watertight_test", make<WithoutWatertightTest>},
};

}  // namespace

std::unique_ptr<Renderer> makeAblation(std::string_view name) {
  const auto found = std::ranges::find(kAblations, name, &Ablation::name);
  return found == kAblations.end() ? nullptr : found->make();
}

}  // namespace haptics::eval
