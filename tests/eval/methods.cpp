#include "tests/eval/methods.h"

#include <array>

#include "tests/eval/baselines/finite_proxy.h"
#include "tests/eval/baselines/global_closest.h"
#include "tests/eval/baselines/god_object.h"
#include "tests/eval/baselines/intermediate_plane.h"
#include "tests/eval/baselines/pseudocode.h"
#include "tests/eval/ours.h"

namespace haptics::eval {
namespace {

template <class Type>
std::unique_ptr<Renderer> make() {
  return std::make_unique<Type>();
}

constexpr std::array kMethods{
    Method{kOurs, "the production step", make<Ours>},
    Method{"pseudocode_closed", "as printed; a polygon holds its edges and vertices",
           make<Pseudocode<Primitives::kClosed>>},
    Method{"pseudocode_open", "as printed; a polygon is its interior only", make<Pseudocode<Primitives::kOpen>>},
    Method{"global_closest", "penalty towards the closest point of the whole surface", make<GlobalClosest>},
    Method{"god_object", "up to three active planes by Lagrange multipliers", make<GodObject>},
    Method{"god_object_by_rays", "the same over a ray test that is not watertight", make<GodObjectByRays>},
    Method{"finite_proxy_1mm", "a sphere among offset faces, cylinders and spheres", make<FiniteProxy>},
    Method{"intermediate_plane_30Hz", "tangent plane, put anew 30 times a second", make<IntermediatePlane<30>>},
    Method{"intermediate_plane_100Hz", "tangent plane, put anew 100 times a second", make<IntermediatePlane<100>>},
};

}  // namespace

std::span<const Method> methods() { return kMethods; }

}  // namespace haptics::eval
