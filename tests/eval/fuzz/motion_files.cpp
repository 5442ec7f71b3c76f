#include <charconv>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/eval/fuzz/contact_finding.h"
#include "tests/eval/fuzz/obj_file.h"

namespace haptics::eval {
namespace {

constexpr std::size_t kPoseNumbers = 7;
constexpr std::size_t kHipNumbers = 4;  ///< With the tick.

std::filesystem::path meshFile(const std::filesystem::path& folder, const char* what, std::size_t body) {
  return folder / (what + std::to_string(body) + ".obj");
}

std::vector<double> numbersOf(const std::string& line) {
  std::vector<double> numbers;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (at < end) {
    double number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc()) return {};
    numbers.push_back(number);
    at = next + 1;
  }
  return numbers;
}

ContactFrame frameFrom(const std::vector<double>& n) {
  ContactFrame frame{{n[1], n[2], n[3]}, {}};
  for (std::size_t i = kHipNumbers; i < n.size(); i += kPoseNumbers) {
    frame.poses.push_back({{n[i], n[i + 1], n[i + 2], n[i + 3]}, {n[i + 4], n[i + 5], n[i + 6]}});
  }
  return frame;
}

FlatTop readFlat(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const std::vector<double> n = numbersOf(line);
  constexpr std::size_t kNumbers = kPoseNumbers + 4;
  if (n.size() != kNumbers)
    throw std::runtime_error(path.string() + ": is to be seven numbers of a pose, and the least and largest x and y");
  return {{{n[0], n[1], n[2], n[3]}, {n[4], n[5], n[6]}}, {n[7], n[8], 0}, {n[9], n[10], 0}};
}

}  // namespace

void writeMotion(const ContactMotion& motion, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < motion.meshes.size(); ++i) {
    const FuzzMesh& mesh = motion.meshes[i];
    writeObj(meshFile(folder, "body", i), mesh.vertices, mesh.triangles);
    if (!mesh.closed()) writeObj(meshFile(folder, "gap", i), mesh.vertices, mesh.missing);
    if (mesh.upper == 0) continue;
    const auto end = mesh.triangles.begin() + static_cast<std::ptrdiff_t>(mesh.upper);
    writeObj(meshFile(folder, "upper", i), mesh.vertices, {mesh.triangles.begin(), end});
  }
  if (motion.flat) {
    std::ofstream flat = openToWrite(folder / "flat.csv");
    flat.precision(std::numeric_limits<double>::max_digits10);
    const auto& [p, low, high] = *motion.flat;
    flat << p.rotation.w << ',' << p.rotation.x << ',' << p.rotation.y << ',' << p.rotation.z << ',' << p.position.x
         << ',' << p.position.y << ',' << p.position.z << ',' << low.x << ',' << low.y << ',' << high.x << ',' << high.y
         << '\n';
  }
  std::ofstream file = openToWrite(folder / "motion.csv");
  file.precision(std::numeric_limits<double>::max_digits10);
  for (std::size_t tick = 0; tick < motion.frames.size(); ++tick) {
    const ContactFrame& frame = motion.frames[tick];
    file << tick << ',' << frame.hip.x << ',' << frame.hip.y << ',' << frame.hip.z;
    for (const Pose& p : frame.poses) {
      file << ',' << p.rotation.w << ',' << p.rotation.x << ',' << p.rotation.y << ',' << p.rotation.z << ','
           << p.position.x << ',' << p.position.y << ',' << p.position.z;
    }
    file << '\n';
  }
}

ContactMotion readMotion(const std::filesystem::path& folder) {
  ContactMotion motion;
  for (std::size_t i = 0; std::filesystem::exists(meshFile(folder, "body", i)); ++i) {
    Obj body = readObj(meshFile(folder, "body", i));
    FuzzMesh mesh{std::move(body.vertices), std::move(body.triangles), {}};
    if (const auto gap = meshFile(folder, "gap", i); std::filesystem::exists(gap))
      mesh.missing = readObj(gap).triangles;
    if (const auto upper = meshFile(folder, "upper", i); std::filesystem::exists(upper))
      mesh.upper = readObj(upper).triangles.size();
    motion.meshes.push_back(std::move(mesh));
  }
  if (std::filesystem::exists(folder / "flat.csv")) motion.flat = readFlat(folder / "flat.csv");
  if (motion.meshes.empty()) throw std::runtime_error(folder.string() + ": holds no body0.obj");
  std::ifstream file(folder / "motion.csv");
  std::string line;
  while (std::getline(file, line)) {
    const std::vector<double> numbers = numbersOf(line);
    if (numbers.size() != kHipNumbers + kPoseNumbers * motion.meshes.size()) {
      throw std::runtime_error((folder / "motion.csv").string() + ", line " + std::to_string(motion.frames.size() + 1) +
                               ": is to be the tick, the HIP's x y z and seven numbers of each body");
    }
    motion.frames.push_back(frameFrom(numbers));
  }
  if (motion.frames.size() < 2) throw std::runtime_error((folder / "motion.csv").string() + ": holds no two ticks");
  return motion;
}

}  // namespace haptics::eval
