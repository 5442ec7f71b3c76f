// VTK's cell locator and its sign by pseudonormals (vtkImplicitPolyDataDistance), as a penalty method: the nearest place of the
// surface, by no path.

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImplicitPolyDataDistance.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkVersion.h>

#include <array>

#include "tests/eval/adapters/peers/peer_scene.h"

namespace haptics::eval::peers {
namespace {

struct Body {
  vtkNew<vtkImplicitPolyDataDistance> distance;
  double stiffness_N_per_m = 0;
};

std::vector<Body> bodies;

void load(const haptics_scene& scene) {
  bodies = std::vector<Body>(scene.body_count);
  for (std::uint32_t i = 0; i < scene.body_count; ++i) {
    const haptics_body& of = scene.bodies[i];
    vtkNew<vtkPoints> points;
    for (std::uint32_t k = 0; k < of.vertex_count; ++k) points->InsertNextPoint(of.vertices + 3 * k);
    vtkNew<vtkCellArray> cells;
    for (std::uint32_t k = 0; k < of.triangle_count; ++k) {
      const std::uint32_t* const t = of.triangles + 3 * k;
      cells->InsertNextCell({t[0], t[1], t[2]});
    }
    vtkNew<vtkPolyData> mesh;
    mesh->SetPoints(points);
    mesh->SetPolys(cells);
    bodies[i].distance->SetInput(mesh);
    bodies[i].stiffness_N_per_m = of.stiffness_N_per_m;
  }
}

void tick(const haptics_pose* poses, Vec3 hip, haptics_answer& answer) {
  answerPlace(answer, hip);
  double deepest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Pose pose = toPose(poses[i]);
    Vec3 local = toLocal(pose, hip);
    std::array<double, 3> foot;
    const double depth = -bodies[i].distance->EvaluateFunctionAndGetClosestPoint(&local.x, foot.data());
    if (depth <= deepest) continue;
    deepest = depth;
    answerContact(answer, toWorld(pose, toVec3(foot.data())), hip, bodies[i].stiffness_N_per_m);
  }
}

}  // namespace
}  // namespace haptics::eval::peers

const haptics_method_functions* haptics_method() {
  using namespace haptics::eval::peers;
  static const std::string version =
      std::string("VTK ") + vtkVersion::GetVTKVersion() + ", vtkImplicitPolyDataDistance";
  static const haptics_method_functions functions{
      HAPTICS_METHOD_ABI,
      HAPTICS_MOVING_BODIES | HAPTICS_EDITS,
      "vtk_locator",
      version.c_str(),
      [](const haptics_scene* scene) { return whyNot([scene] { load(*scene); }); },
      [](const double*) {},
      [](const haptics_pose* poses, const double* hip, haptics_answer* answer) { tick(poses, toVec3(hip), *answer); }};
  return &functions;
}
