// haptics._world: World and SceneWorld for Python. Positions and samples are arrays of numpy that C++ reads and writes in
// place.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <mutex>
#include <string>

#include "haptic_server/world/input_checks.h"
#include "haptic_server/world/scene_world.h"

namespace py = pybind11;

namespace haptics {
namespace {

/// A World or SceneWorld that several Python threads may call: one at a time has it, the others wait without the GIL.
template <class Kind>
class Shared {
 public:
  explicit Shared(Kind world) : world_(std::move(world)) {}

  template <class Call>
  auto with(Call call) {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) {
      const py::gil_scoped_release released;
      lock.lock();
    }
    return call(world_);
  }

 private:
  Kind world_;
  std::mutex mutex_;
};
using SharedWorld = Shared<World>;
using SharedSceneWorld = Shared<SceneWorld>;

[[nodiscard]] std::string shapeText(const py::array& array) {
  return py::str(py::tuple(array.attr("shape"))).cast<std::string>() + " of " +
         py::str(array.dtype()).cast<std::string>();
}

template <class T>
using Rows = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// Rows of three.
template <class T>
[[nodiscard]] std::span<const std::array<T, 3>> rowsOf(const Rows<T>& array, const std::string& field) {
  if (array.ndim() != 2 || array.shape(1) != 3) refuse(field, "is " + shapeText(array) + "; (n, 3) is wanted");
  return {reinterpret_cast<const std::array<T, 3>*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

/// Indices, none of which is below 0 or wraps around.
[[nodiscard]] Rows<std::uint32_t> indicesOf(const py::array& array) {
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u') refuse("triangles", "is " + shapeText(array) + "; whole numbers are wanted");
  const auto signedOnes = Rows<std::int64_t>::ensure(array);
  Rows<std::uint32_t> indices(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
  for (py::ssize_t i = 0; i < signedOnes.size(); ++i) {
    const std::int64_t index = signedOnes.data()[i];
    if (index < 0 || index > std::numeric_limits<std::uint32_t>::max())
      refuse("triangles", "names vertex " + std::to_string(index));
    indices.mutable_data()[i] = static_cast<std::uint32_t>(index);
  }
  return indices;
}

std::uint64_t add(SharedWorld& shared, const std::string& name, const Rows<float>& vertices, const py::array& triangles,
                  const World::Material& material, const World::Pose& pose) {
  const auto corners = rowsOf(vertices, "vertices");
  const Rows<std::uint32_t> indices = indicesOf(triangles);
  const World::Mesh mesh{corners, rowsOf(indices, "triangles")};
  return shared.with([&](World& world) {
    const py::gil_scoped_release released;
    return world.add(name, mesh, material, pose);
  });
}

void moveVertices(SharedWorld& shared, std::uint64_t body, const Rows<float>& vertices) {
  const auto places = rowsOf(vertices, "vertices");
  shared.with([&](World& world) { world.moveVerticesKinematic(body, places); });
}

/// In place: other types and layouts are refused, not copied.
template <class Row>
[[nodiscard]] std::span<const Row> inPlace(const py::array& array, const std::string& field) {
  constexpr py::ssize_t kColumns = sizeof(Row) / sizeof(double);
  const bool isThere = py::isinstance<py::array_t<double>>(array) && array.ndim() == 2 && array.shape(1) == kColumns &&
                       (array.flags() & py::array::c_style) != 0;
  if (!isThere) {
    refuse(field, "is " + shapeText(array) + "; (n, " + std::to_string(kColumns) +
                      ") of float64 in rows is wanted: numpy.ascontiguousarray(" + field + ", float)");
  }
  return {static_cast<const Row*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

template <class Kind>
py::array_t<World::Sample> run(Shared<Kind>& shared, const py::array& positions) {
  const auto hips = inPlace<World::Vector>(positions, "positions");
  py::array_t<World::Sample> samples(positions.shape(0));
  const std::span out(samples.mutable_data(), hips.size());
  shared.with([&](Kind& world) {
    const py::gil_scoped_release released;
    world.run(hips, out);
  });
  return samples;
}

std::size_t hold(SharedWorld& shared, const Rows<float>& vertices, const py::array& triangles,
                 const World::Tool& tool) {
  const auto corners = rowsOf(vertices, "vertices");
  const Rows<std::uint32_t> indices = indicesOf(triangles);
  const World::Mesh mesh{corners, rowsOf(indices, "triangles")};
  return shared.with([&](World& world) {
    const py::gil_scoped_release released;
    return world.hold(mesh, tool);
  });
}

py::array_t<World::ToolSample> runTool(SharedWorld& shared, const py::array& poses) {
  const auto devices = inPlace<World::Pose>(poses, "poses");
  py::array_t<World::ToolSample> samples(poses.shape(0));
  const std::span out(samples.mutable_data(), devices.size());
  shared.with([&](World& world) {
    const py::gil_scoped_release released;
    world.runTool(devices, out);
  });
  return samples;
}

/// @param scene  A file, or a haptics.Scene.
std::unique_ptr<SharedSceneWorld> load(const py::object& scene, const World::Device& device,
                                       std::vector<std::string> folders) {
  const std::string text = py::str(scene).cast<std::string>();
  const bool isFile = !py::hasattr(scene, "transaction");
  if (!isFile) folders.insert(folders.begin(), py::str(scene.attr("folder")).cast<std::string>());
  const py::gil_scoped_release released;
  if (isFile) return std::make_unique<SharedSceneWorld>(SceneWorld::load(text, device, std::move(folders)));
  SceneWorld world(device, std::move(folders));
  (void)world.apply(text);
  return std::make_unique<SharedSceneWorld>(std::move(world));
}

}  // namespace

PYBIND11_MODULE(_world, module) {
  constexpr const char* kRunIs =
      "A tick for each of positions (n, 3), float64 in rows, read in place: samples (n,) of SAMPLE.";
  PYBIND11_NUMPY_DTYPE(World::Sample, force_N, ihip_m, normal, penetration_m, body, triangle, fault, sliding,
                       allowanceSpent, depenetrated);
  PYBIND11_NUMPY_DTYPE(World::Pose, position_m, rotation);
  PYBIND11_NUMPY_DTYPE(World::ToolSample, force_N, torque_Nm, proxy, touching, fault, waits);
  module.doc() = "Bodies, and the force on a hand that touches them: the haptic server's step in this process.";
  module.attr("SAMPLE") = py::dtype::of<World::Sample>();
  module.attr("TOOL_SAMPLE") = py::dtype::of<World::ToolSample>();

  py::enum_<World::Fault>(module, "Fault")
      .value("NONE", World::Fault::kNone)
      .value("NON_FINITE_HIP", World::Fault::kNonFiniteHip)
      .value("NON_FINITE_FORCE", World::Fault::kNonFiniteForce)
      .value("MISSED_TICKS", World::Fault::kMissedTicks)
      .def(
          "__str__", [](World::Fault fault) { return faultInWords(fault); }, py::prepend());

  py::class_<World::Device>(module, "Device", "The device whose force this is, and the rate of its loop. SI units.")
      .def(py::init([](double rate_Hz, double maxForce_N, double resolution_m, double delay_s, double mass_kg,
                       double viscousFriction_Ns_per_m, double coulombFriction_N, double maxStiffness_N_per_m,
                       bool predicts) {
             return World::Device{
                 rate_Hz,           maxForce_N,           resolution_m, delay_s, mass_kg, viscousFriction_Ns_per_m,
                 coulombFriction_N, maxStiffness_N_per_m, predicts};
           }),
           py::kw_only(), py::arg("rate_Hz") = 1000, py::arg("max_force_N") = 3.3, py::arg("resolution_m") = 0,
           py::arg("delay_s") = 0, py::arg("mass_kg") = 0, py::arg("viscous_friction_Ns_per_m") = 0,
           py::arg("coulomb_friction_N") = 0, py::arg("max_stiffness_N_per_m") = 0, py::arg("predicts") = true)
      .def_static("named", &World::Device::named, py::arg("name"),
                  "omni, touch, premium-1.5, desktop, falcon or omega.3, at 1 kHz.")
      .def_readwrite("rate_Hz", &World::Device::rate_Hz)
      .def_readwrite("max_force_N", &World::Device::maxForce_N);

  py::class_<World::Material>(module, "Material", "What a body's surface feels like. SI units.")
      .def(py::init([](double stiffness, double damping, double staticFriction, double dynamicFriction,
                       double roundedBelow_rad) {
             return World::Material{stiffness, damping, staticFriction, dynamicFriction, roundedBelow_rad};
           }),
           py::kw_only(), py::arg("stiffness_N_per_m") = 800, py::arg("damping_Ns_per_m") = 0.5,
           py::arg("static_friction") = 0, py::arg("dynamic_friction") = 0, py::arg("rounded_below_rad") = 0);

  py::class_<World::Pose>(module, "Pose", "Body frame to world: x_world = rotation * x_body + position.")
      .def(py::init([](const World::Vector& position_m, const std::array<double, 4>& rotation) {
             return World::Pose{position_m, rotation};
           }),
           py::arg("position_m") = World::Vector{}, py::arg("rotation") = std::array<double, 4>{1, 0, 0, 0},
           "rotation: unit quaternion w, x, y, z")
      .def_readonly("position_m", &World::Pose::position_m)
      .def_readonly("rotation", &World::Pose::rotation);

  py::class_<World::Tool>(module, "Tool", "A tool with a shape, in place of a point. SI units.")
      .def(py::init([](double spacing_m, double stiffness, double torsion, double maxTorque_Nm) {
             return World::Tool{spacing_m, stiffness, torsion, maxTorque_Nm};
           }),
           py::kw_only(), py::arg("spacing_m") = 0.002, py::arg("stiffness_N_per_m") = 800,
           py::arg("torsion_Nm_per_rad") = 1, py::arg("max_torque_Nm") = 0.2);

  py::class_<SharedWorld>(module, "World",
                          "Bodies, and the force on a hand that touches them (metres, newtons, world frame). Threads\n"
                          "may share one: one call at a time runs, without the GIL. ValueError names what is refused.")
      .def(py::init([](const World::Device& device) { return std::make_unique<SharedWorld>(World(device)); }),
           py::arg("device") = World::Device{})
      .def("add", &add, py::arg("name"), py::arg("vertices"), py::arg("triangles"),
           py::arg("material") = World::Material{}, py::arg("pose") = World::Pose{},
           "vertices (n, 3) in metres, triangles (m, 3) of their numbers, counter-clockwise from outside; returns the\n"
           "body's number.")
      .def(
          "set_pose",
          [](SharedWorld& shared, std::uint64_t body, const World::Pose& pose) {
            shared.with([&](World& world) { world.setPose(body, pose); });
          },
          py::arg("body"), py::arg("pose"))
      .def(
          "move_kinematic",
          [](SharedWorld& shared, std::uint64_t body, const World::Pose& pose) {
            shared.with([&](World& world) { world.moveKinematic(body, pose); });
          },
          py::arg("body"), py::arg("pose"),
          "A motion from where the body is to this pose, which pushes the hand; before every tick, or less often.")
      .def("move_vertices_kinematic", &moveVertices, py::arg("body"), py::arg("vertices"),
           "The same of the body's vertices, (n, 3) in its frame, one for each that add() got.")
      .def(
          "set_material",
          [](SharedWorld& shared, std::uint64_t body, const World::Material& material) {
            shared.with([&](World& world) { world.setMaterial(body, material); });
          },
          py::arg("body"), py::arg("material"))
      .def(
          "remove",
          [](SharedWorld& shared, std::uint64_t body) { shared.with([&](World& world) { world.remove(body); }); },
          py::arg("body"))
      .def("run", &run<World>, py::arg("positions"), kRunIs)
      .def("hold", &hold, py::arg("vertices"), py::arg("triangles"), py::arg("tool") = World::Tool{},
           "The hand holds this tool from now on, for run_tool(); returns how many of its points are followed.")
      .def("run_tool", &runTool, py::arg("poses"),
           "A tick for each of poses (n, 7), x y z and w x y z, float64 in rows, read in place: samples (n,) of\n"
           "TOOL_SAMPLE.");

  py::class_<SceneWorld::Body>(module, "Body", "Of a SceneWorld.")
      .def_readonly("number", &SceneWorld::Body::number)
      .def_readonly("name", &SceneWorld::Body::name)
      .def_readonly("pose", &SceneWorld::Body::pose);

  py::class_<SharedSceneWorld>(
      module, "SceneWorld",
      "The scene of a scene file, with all that one can say. Files that it names are below its\n"
      "folder or the given ones. Threads and errors as World's.")
      .def(py::init(&load), py::arg("scene"), py::arg("device") = World::Device{},
           py::arg("folders") = std::vector<std::string>{}, "scene: a file, or a haptics.Scene")
      .def(
          "apply",
          [](SharedSceneWorld& shared, const py::object& edit) {
            return shared.with([&, text = py::str(edit).cast<std::string>()](SceneWorld& world) {
              const py::gil_scoped_release released;
              return world.apply(text);
            });
          },
          py::arg("edit"),
          "One edit, a haptics.Scene or in the text of scene files, all of it or none; returns what it kept and "
          "dropped.")
      .def(
          "bodies",
          [](SharedSceneWorld& shared) { return shared.with([](SceneWorld& world) { return world.bodies(); }); },
          "With their poses now.")
      .def(
          "keep_dents", [](SharedSceneWorld& shared) { shared.with([](SceneWorld& world) { world.keepDents(); }); },
          "Makes the dents that stay in plastic bodies part of their shapes; until then 6 are held.")
      .def(
          "root", [](SharedSceneWorld& shared) { return shared.with([](SceneWorld& world) { return world.root(); }); },
          "SHA-256 over all objects and their meshes, in hexadecimal digits; that of a server with the same scene.")
      .def("run", &run<SceneWorld>, py::arg("positions"), kRunIs);
}

}  // namespace haptics
