#include "tests/eval/methods.h"

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/baselines/finite_proxy.h"
#include "tests/eval/baselines/global_closest.h"
#include "tests/eval/baselines/god_object.h"
#include "tests/eval/baselines/intermediate_plane.h"
#include "tests/eval/baselines/pseudocode.h"
#include "tests/eval/baselines/spring_world.h"
#include "tests/eval/baselines/surface_after_contact.h"
#include "tests/eval/baselines/surface_as_printed.h"
#include "tests/eval/corrections_off.h"
#include "tests/eval/runtime_method.h"

namespace haptics::eval {
namespace {

template <class Type>
std::unique_ptr<Renderer> make() {
  return std::make_unique<Type>();
}

Method published(std::string_view name, std::string_view about, std::unique_ptr<Renderer> (*maker)()) {
  return {.name = name, .about = about, .make = maker, .streams = true};
}

const std::array kMethods{
    Method{kOurs, "the production step", make<RuntimeMethod>, true, true, true, true, true, true, true},
    Method{"ours_shaded", "the same with force shading on every body", make<ShadedMethod>, true, true, true},
    Method{"ours_float", "its contact core with the search in float", oursUnder<kInFloat>, true, false},
    published("pseudocode_closed", "as printed; a polygon holds its edges and vertices",
              make<Pseudocode<Primitives::kClosed>>),
    published("pseudocode_open", "as printed; a polygon is its interior only", make<Pseudocode<Primitives::kOpen>>),
    published("global_closest", "penalty towards the closest point of the whole surface", make<GlobalClosest>),
    published("god_object", "up to three active planes by Lagrange multipliers", make<GodObject>),
    published("god_object_by_rays", "the same over a ray test that is not watertight", make<GodObjectByRays>),
    published("finite_proxy_1mm", "a sphere among offset faces, cylinders and spheres", make<FiniteProxy>),
    published("intermediate_plane_30Hz", "tangent plane, put anew 30 times a second", make<IntermediatePlane<30>>),
    published("intermediate_plane_100Hz", "tangent plane, put anew 100 times a second", make<IntermediatePlane<100>>),
};

const std::array kAblatedMethods{
    Method{"ours_without_feature_codes", "the printed loop", oursUnder<kWithoutFeatureCodes>, true, false},
    Method{"ours_without_pseudonormals", "sign by the polygon's normal", oursUnder<kWithoutPseudonormals>, true, false},
    Method{"ours_without_same_tick_search", "first force a tick late", oursUnder<kWithoutSameTickSearch>, true, false},
    Method{"ours_without_exit_retest", "free at once when it leaves", oursUnder<kWithoutExitRetest>, true, false},
    Method{.name = "ours_without_object_frames",
           .about = "segments in the world",
           .make = oursUnder<kWithoutObjectFrames>,
           .edits = false,
           .streams = true},
    Method{"ours_without_containment", "an IHIP that is inside a body is not noticed", oursUnder<kWithoutContainment>,
           true, false},
    Method{"ours_without_guard", "the path is tested against nothing", oursUnder<kWithoutGuard>, true, false},
    Method{"ours_without_several_surfaces", "one at a time", oursUnder<kWithoutSeveralSurfaces>, true, false},
    Method{"ours_without_budget", "searches to the end", oursUnder<kWithoutBudget>, true, false},
    Method{"ours_without_scale_free_tolerances", "lengths in metres", oursUnder<kWithoutScaleFreeTolerances>, true,
           false},
    Method{"ours_without_substeps", "a tick is a step", oursUnder<kWithoutSubsteps>, true, false},
    Method{"ours_without_watertight_test", "the usual ray test", oursUnder<kWithoutWatertightTest>, true, false},
    Method{"ours_without_closed_gaps", "segments pass between flush surfaces", oursUnder<kWithoutClosedGaps>, true,
           false},
};

Method forSurfaces(std::string_view name, std::string_view about, std::unique_ptr<Renderer> (*maker)()) {
  return {.name = name, .about = about, .make = maker, .contact = false, .edits = false, .surfaces = true};
}

const std::array kSingleConcernMethods{
    forSurfaces("ours_without_gain_clamp", "K as it was set", make<MethodWithoutGainClamp>),
    forSurfaces("surface_as_printed", "section 4 as printed", make<SurfaceAsPrinted>),
    forSurfaces("bump_mapping", "the same with bump mapping", make<BumpMapping>),
    Method{.name = "surface_after_contact",
           .about = "soft bodies moved by the force of the tick before",
           .make = make<SurfaceAfterContact>,
           .contact = false,
           .edits = false,
           .softness = true},
    Method{.name = "ours_without_reprojection",
           .about = "an edit lets go of the contact",
           .make = make<MethodThatAttachesAnew>,
           .contact = false},
    Method{.name = "ours_without_turning_over",
           .about = "mirrored triangles as they are",
           .make = make<MethodThatTurnsNothingOver>,
           .contact = false},
    Method{.name = "ours_without_ways_between_samples",
           .about = "what is driven is at its last sample",
           .make = make<MethodThatHoldsSamples>,
           .contact = false,
           .edits = false,
           .streams = true},
    Method{.name = "ours_without_overlaps",
           .about = "what is put into others is taken for apart",
           .make = make<MethodThatOverlooksPutBodies>,
           .contact = false,
           .edits = false,
           .bodies = true},
    Method{.name = "springs_between_bodies",
           .about = "bodies that meet pushed apart by springs and dampers",
           .make = make<SpringsBetweenBodies>,
           .contact = false,
           .edits = false,
           .bodies = true},
};

}  // namespace

std::span<const Method> singleConcernMethods() { return kSingleConcernMethods; }
std::span<const Method> ablatedMethods() { return kAblatedMethods; }
std::span<const Method> methods() { return kMethods; }
std::span<const Method> chartMethods() {
  static const std::vector<Method> all = [] {
    std::vector<Method> charted(kMethods.begin(), kMethods.end());
    charted.push_back(findMethod("ours_without_substeps", kAblatedMethods));
    return charted;
  }();
  return all;
}

const Method& findMethod(std::string_view name, std::span<const Method> among) {
  if (isOutside(name)) return outsideMethod(std::string(name));
  std::string known;
  for (const Method& method : among) {
    if (method.name == name) return method;
    known += (known.empty() ? "" : ", ") + std::string(method.name);
  }
  throw std::invalid_argument("--method: there is none called " + std::string(name) + "; there are " + known +
                              ", and libraries (./FILE.so) and commands ('python3 FILE.py') from outside");
}

}  // namespace haptics::eval
