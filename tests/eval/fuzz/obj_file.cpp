#include "tests/eval/fuzz/obj_file.h"

#include <algorithm>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace haptics::eval {

std::ofstream openToWrite(const std::filesystem::path& path) {
  std::ofstream file(path);
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
  return file;
}

void writeObj(const std::filesystem::path& path, const std::vector<Vec3f>& vertices,
              const std::vector<TriangleIndices>& triangles) {
  std::ofstream file = openToWrite(path);
  file.precision(std::numeric_limits<float>::max_digits10);
  for (const Vec3f v : vertices) file << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const TriangleIndices& t : triangles) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
}

Obj readObj(const std::filesystem::path& path) {
  Obj obj;
  std::ifstream file(path);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    std::string kind;
    if (!(words >> kind)) continue;
    Vec3f v;
    TriangleIndices t{};
    if (kind == "v" && words >> v.x >> v.y >> v.z) {
      obj.vertices.push_back(v);
    } else if (kind == "f" && words >> t[0] >> t[1] >> t[2] && std::min({t[0], t[1], t[2]}) > 0 &&
               std::max({t[0], t[1], t[2]}) <= obj.vertices.size()) {
      obj.triangles.push_back({t[0] - 1, t[1] - 1, t[2] - 1});
    } else {
      throw std::runtime_error(path.string() + ", line " + std::to_string(number) +
                               ": is to be \"v x y z\" or \"f a b c\" of vertices that come before");
    }
  }
  if (obj.triangles.empty()) throw std::runtime_error(path.string() + ": holds no triangles");
  return obj;
}

}  // namespace haptics::eval
