#include "tests/eval/advise/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <ranges>

#include "common/text/grouped.h"

namespace haptics::eval {
namespace {

constexpr double kLeastGain_MB = 0.1;
constexpr double kLeastGain_ratio = 0.05;
constexpr double kLeastGain_ns = 50;  // less comes and goes with what else the machine does

bool isGained(const Candidate& own, const Candidate& advised) {
  const auto faster = [&](double Candidate::*time_ns) {
    return advised.*time_ns < (1 - kLeastGain_ratio) * own.*time_ns;
  };
  return own.memory_MB - advised.memory_MB >= kLeastGain_MB ||
         (own.hot_ns - advised.hot_ns >= kLeastGain_ns && faster(&Candidate::hot_ns) && faster(&Candidate::cold_ns));
}

std::string savedText(const Candidate& own, const Candidate& advised) {
  const double saved_MB = own.memory_MB - advised.memory_MB;
  char text[64];
  if (saved_MB >= kLeastGain_MB) {
    std::snprintf(text, sizeof text, "saves %.1f MB", saved_MB);
  } else {
    std::snprintf(text, sizeof text, "saves %.0f ns of a tick's %.0f", own.hot_ns - advised.hot_ns, own.hot_ns);
  }
  return text;
}

bool isPerVertex(const FactorMap& map) { return std::holds_alternative<PerVertexScale>(map); }

/// Mapped round a box that by default is the mesh's, or grown on the mesh.
bool isOfMesh(const FieldFamily& family) {
  if (std::holds_alternative<MappedFamily>(family) || std::holds_alternative<GrownFamily>(family)) return true;
  const auto* layers = std::get_if<LayeredFamily>(&family);
  return layers != nullptr &&
         std::ranges::any_of(layers->layers, [](const FieldLayer& layer) { return isOfMesh(layer.family); });
}

bool isOfMesh(const FactorMap& map) {
  const auto* family = std::get_if<FieldFamily>(&map);
  return family != nullptr && isOfMesh(*family);
}

std::string whySurfaceStays(const SurfaceProperties& surface) {
  std::vector<FactorMap> maps;
  if (surface.friction) maps = {surface.friction->over, surface.friction->dynamicOver};
  if (surface.stiffnessOver) maps.push_back(surface.stiffnessOver->over);
  if (surface.softnessOver) maps.push_back(surface.softnessOver->over);
  if (surface.shading && !surface.shading->creases.empty()) return "its creases name its vertices";
  if (std::ranges::any_of(maps, isPerVertex)) return "its values are one to a vertex";
  const bool ofMesh = std::ranges::any_of(maps, [](const FactorMap& map) { return isOfMesh(map); });
  if (ofMesh || (surface.texture && isOfMesh(surface.texture->family))) {
    return "its pattern is mapped or grown on this mesh";
  }
  return "";
}

std::size_t coarsestGood(const std::vector<Candidate>& candidates) {
  const auto bad = std::find_if(candidates.begin() + 1, candidates.end(), [](const Candidate& c) { return !c.good(); });
  return static_cast<std::size_t>(bad - candidates.begin()) - 1;
}

/// Low and high corner, world.
std::array<Vec3, 2> boxOf(const LoadedObject& object) {
  std::array<Vec3, 2> box{Vec3(std::numeric_limits<double>::infinity()),
                          Vec3(-std::numeric_limits<double>::infinity())};
  for (const Vec3f v : object.mesh->vertices) {
    const Vec3 place = toWorld(object.pose, Vec3(v));
    box = {glm::min(box[0], place), glm::max(box[1], place)};
  }
  return box;
}

bool boxesMeet(const LoadedObject& a, const LoadedObject& b) {
  const auto [lowA, highA] = boxOf(a);
  const auto [lowB, highB] = boxOf(b);
  for (int k = 0; k < 3; ++k) {
    if (highA[k] < lowB[k] || highB[k] < lowA[k]) return false;
  }
  return true;
}

/// Why an object's mesh has to stay whatever is felt on it at rest; empty where it need not.
/// @param exact  The other mesh is of the same shape.
std::string whyMeshStays(const std::vector<LoadedObject>& scene, std::size_t index, bool exact) {
  const LoadedObject& object = scene[index];
  if (std::string why = whySurfaceStays(object.material.surface); !why.empty()) return why;
  if (object.deformation.residue) return "its residue moves its vertices";
  if (object.deformation.softness) return "its softness moves its vertices, and it was judged as rigid";
  if (object.deformation.lattice) return "its lattice moves its vertices, and it was judged without";
  if (exact) return "";
  for (const LoadedObject& other : scene) {
    if (!other.deformation.softness || !boxesMeet(object, other)) continue;
    return other.name + ", which yields, is where it is, and was judged as rigid";
  }
  if (!object.motion) return "";
  if (object.motion->collision) return "other bodies meet it, and it was judged by the hand alone";
  return object.motion->fixed ? "" : "it moves, and it was judged at rest";
}

}  // namespace

std::string meshFileOf(const ObjectAdvice& object) { return object.name + ".ply"; }

void decide(ObjectAdvice& advice, const std::vector<LoadedObject>& scene, std::size_t object) {
  const auto keep = [&](const std::string& why) { advice.verdict = {false, "keep; " + why}; };
  advice.advised = 0;
  if (!advice.judged()) {
    advice.verdict = {false, "not judged: no hand gets there from above"};
    return;
  }
  const std::size_t enough = coarsestGood(advice.candidates);
  const Candidate& own = advice.candidates.front();
  const Candidate& found = advice.candidates[enough];
  if (enough == 0) return keep("every triangle is needed");
  if (!isGained(own, found)) return keep("nothing is to be gained");
  const std::string counts = grouped(found.triangles) + " of " + grouped(own.triangles) + " triangles";
  const std::string bound = whyMeshStays(scene, object, found.exact);
  if (!bound.empty()) return keep(counts + " would do for a rigid body at rest, but " + bound);
  advice.advised = enough;
  advice.verdict = {true, "use " + meshFileOf(advice) + ", " + counts + ", " + savedText(own, found)};
}

std::string notJudgedOf(const ObjectAdvice& object) {
  std::string list;
  for (const SceneFeature& feature : object.features) {
    if (!feature.judged()) list += (list.empty() ? "" : ", ") + feature.name + " (" + feature.whyNot + ")";
  }
  return list;
}

std::string notFeltOf(const ObjectAdvice& object) {
  std::string list;
  for (const SceneFeature& feature : object.features) {
    if (!feature.judged() || feature.felt()) continue;
    list += (list.empty() ? "" : ", ") + feature.name + ", which costs " +
            std::to_string(std::max(0L, std::lround(feature.cost_ns))) + " ns a tick";
  }
  return list;
}

std::string decidedBy(const SceneAdvice& advice, const DevicePreset& device) {
  if (!advice.rate) return "";
  if (*advice.rate == 0) return "no lower one was tried";
  const std::size_t below = *advice.rate - 1;
  std::string list;
  for (const std::string& what : summaryAt(advice, below, device).fails) list += (list.empty() ? "" : ", ") + what;
  return std::to_string(std::lround(kRates_Hz[below])) + " Hz fails: " + list;
}

std::string verdictOf(const ToolAdvice& tool) {
  if (tool.candidates.empty())
    return "not judged: it is held as a tool, and there is nothing that it gets to from above";
  char text[64] = "each of its points is needed";
  if (tool.advised > 0) {
    std::snprintf(text, sizeof text, "spacing_m: %.6g feels the same", tool.candidates[tool.advised].spacing_m);
  }
  return std::string("keep its mesh, which is not judged: it is held as a tool; ") + text;
}

}  // namespace haptics::eval
