#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tests/eval/fuzz/edit_finding.h"
#include "tests/eval/fuzz/obj_file.h"

namespace haptics::eval {
namespace {

constexpr const char* kExplanation =
    "# The step under a hand at rest. SI units, world frame.\n"
    "# window: first tick, the one by which the edit is to be felt, end, number of objects, kind of edit.\n"
    "# mesh: number; of one that a lattice pulled, the number of the one that it has its triangles from.\n"
    "# scene: tick before which it comes, revision.\n"
    "# object: id, mesh, shape, pose (w x y z, x y z), revision of the pose, stiffness, damping, leaving,\n"
    "#   mass (0: does not move), crease (0: no shading), friction, texture's amplitude, wavelength, bump mapped;\n"
    "#   of a soft one: radius, degree, stiffness, time of return, plastic part.\n";
constexpr const char* kNone = "none";

std::filesystem::path meshFile(const std::filesystem::path& folder, std::size_t mesh) {
  return folder / ("mesh" + std::to_string(mesh) + ".obj");
}

void write(std::ostream& file, const FuzzObject& o, std::size_t mesh) {
  const Quat& q = o.pose.rotation;
  const Vec3& p = o.pose.position;
  file << "object " << o.id << ' ' << mesh << ' ' << o.shape << ' ' << q.w << ' ' << q.x << ' ' << q.y << ' ' << q.z
       << ' ' << p.x << ' ' << p.y << ' ' << p.z << ' ' << o.poseRevision << ' ' << o.stiffness_N_per_m << ' '
       << o.damping_Ns_per_m << ' ' << o.pendingRemoval << ' ' << o.mass_kg << ' ' << o.crease_rad << ' ' << o.friction
       << ' ' << o.textureAmplitude_m << ' ' << o.textureWavelength_m << ' ' << o.bumpMapped;
  if (o.tissue) {
    file << ' ' << o.tissue->falloff.radius_m() << ' ' << o.tissue->falloff.degree() << ' '
         << o.tissue->stiffness_N_per_m << ' ' << o.tissue->returnTime_s << ' ' << o.tissue->plastic;
  }
  file << '\n';
}

/// @return Whether all is there.
bool read(std::istream& words, FuzzObject& o) {
  Quat& q = o.pose.rotation;
  Vec3& p = o.pose.position;
  words >> o.id >> o.mesh >> o.shape >> q.w >> q.x >> q.y >> q.z >> p.x >> p.y >> p.z >> o.poseRevision >>
      o.stiffness_N_per_m >> o.damping_Ns_per_m >> o.pendingRemoval >> o.mass_kg >> o.crease_rad >> o.friction >>
      o.textureAmplitude_m >> o.textureWavelength_m >> o.bumpMapped;
  if (!words) return false;
  double radius_m = 0;
  if (!(words >> radius_m)) return true;
  unsigned degree = 0;
  double stiffness = 0;
  double return_s = 0;
  double plastic = 0;
  words >> degree >> stiffness >> return_s >> plastic;
  o.tissue = SoftTissue{Falloff(radius_m, degree), stiffness, return_s, plastic};
  return static_cast<bool>(words);
}

/// A mesh that is not pulled has a file; the others follow what they are pulled from.
class Numbers {
 public:
  explicit Numbers(const EditRun& run) {
    for (const FuzzScene& scene : run.scenes) {
      for (const FuzzObject& object : scene.objects) use(run, object.mesh);
    }
  }
  [[nodiscard]] std::size_t of(std::size_t mesh) const { return numbers_.at(mesh); }
  [[nodiscard]] const std::vector<std::size_t>& used() const { return used_; }

 private:
  void use(const EditRun& run, std::size_t mesh) {
    if (numbers_.contains(mesh)) return;
    if (run.meshes[mesh].refitted) use(run, *run.meshes[mesh].refitted);
    numbers_[mesh] = used_.size();
    used_.push_back(mesh);
  }
  std::map<std::size_t, std::size_t> numbers_;
  std::vector<std::size_t> used_;
};

bool readLine(const std::string& line, const std::filesystem::path& folder, EditRun& run) {
  std::istringstream words(line);
  std::string kind;
  if (!(words >> kind) || kind.starts_with('#')) return true;
  if (kind == "rate_Hz") return words >> run.rate_Hz && run.rate_Hz > 0;
  if (kind == "device") {
    words >> run.device;
    if (run.device == kNone) run.device.clear();
    return static_cast<bool>(words);
  }
  if (kind == "stabiliser") return static_cast<bool>(words >> run.stabiliser);
  if (kind == "window") {
    EditWindow& window = run.windows.emplace_back();
    words >> window.begin >> window.settled >> window.end >> window.objects >> std::ws;
    return static_cast<bool>(std::getline(words, window.edit));
  }
  if (kind == "mesh") {
    std::size_t number = 0;
    if (!(words >> number) || number != run.meshes.size()) return false;
    Obj obj = readObj(meshFile(folder, number));
    EditRun::Mesh& mesh =
        run.meshes.emplace_back(EditRun::Mesh{{std::move(obj.vertices), std::move(obj.triangles), {}}, {}});
    if (!isClosed(mesh.mesh.triangles)) mesh.mesh.missing = mesh.mesh.triangles;
    std::size_t from = 0;
    if (words >> from) mesh.refitted = from;
    return !mesh.refitted || from < number;
  }
  if (kind == "scene") {
    FuzzScene& scene = run.scenes.emplace_back();
    return static_cast<bool>(words >> scene.tick >> scene.revision);
  }
  if (kind != "object" || run.scenes.empty()) return false;
  FuzzObject& object = run.scenes.back().objects.emplace_back();
  return read(words, object) && object.mesh < run.meshes.size();
}

/// Where the HIP is, and for how many ticks.
void writeHips(const std::vector<Vec3>& hips, const std::filesystem::path& path) {
  std::ofstream file = openToWrite(path);
  file.precision(std::numeric_limits<double>::max_digits10);
  for (std::size_t i = 0; i < hips.size();) {
    std::size_t ticks = 1;
    while (i + ticks < hips.size() && hips[i + ticks] == hips[i]) ++ticks;
    file << ticks << ',' << hips[i].x << ',' << hips[i].y << ',' << hips[i].z << '\n';
    i += ticks;
  }
}

std::vector<Vec3> readHips(const std::filesystem::path& path) {
  std::vector<Vec3> hips;
  std::ifstream file(path);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream numbers(line);
    char comma = 0;
    std::size_t ticks = 0;
    Vec3 hip(0);
    if (!(numbers >> ticks >> comma >> hip.x >> comma >> hip.y >> comma >> hip.z)) {
      throw std::runtime_error(path.string() + ", line " + std::to_string(number) + ": is to be ticks,x,y,z");
    }
    hips.insert(hips.end(), ticks, hip);
  }
  return hips;
}

}  // namespace

void writeRun(const EditRun& run, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const Numbers numbers(run);
  std::ofstream file = openToWrite(folder / "edits.txt");
  file.precision(std::numeric_limits<double>::max_digits10);
  file << kExplanation << "rate_Hz " << run.rate_Hz << "\ndevice " << (run.device.empty() ? kNone : run.device)
       << "\nstabiliser " << run.stabiliser << '\n';
  for (const EditWindow& w : run.windows)
    file << "window " << w.begin << ' ' << w.settled << ' ' << w.end << ' ' << w.objects << ' ' << w.edit << '\n';
  for (const std::size_t mesh : numbers.used()) {
    const EditRun::Mesh& m = run.meshes[mesh];
    writeObj(meshFile(folder, numbers.of(mesh)), m.mesh.vertices, m.mesh.triangles);
    file << "mesh " << numbers.of(mesh);
    if (m.refitted) file << ' ' << numbers.of(*m.refitted);
    file << '\n';
  }
  for (const FuzzScene& scene : run.scenes) {
    file << "scene " << scene.tick << ' ' << scene.revision << '\n';
    for (const FuzzObject& object : scene.objects) write(file, object, numbers.of(object.mesh));
  }
  writeHips(run.hips, folder / "hip.csv");
}

bool isRun(const std::filesystem::path& folder) { return std::filesystem::exists(folder / "edits.txt"); }

EditRun readRun(const std::filesystem::path& folder) {
  EditRun run;
  std::ifstream file(folder / "edits.txt");
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (!readLine(line, folder, run)) {
      throw std::runtime_error((folder / "edits.txt").string() + ", line " + std::to_string(number) +
                               ": is not as the file's first lines say");
    }
  }
  run.hips = readHips(folder / "hip.csv");
  if (run.scenes.empty() || run.windows.empty() || run.hips.size() < run.windows.back().end) {
    throw std::runtime_error(folder.string() + ": holds no scene, no window, or fewer places than ticks");
  }
  return run;
}

}  // namespace haptics::eval
