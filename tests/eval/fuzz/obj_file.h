#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// Vertices and triangles as they are, in the order in which they are: nothing is welded, mended or rounded.
struct Obj {
  std::vector<Vec3f> vertices;
  std::vector<TriangleIndices> triangles;
};

/// Throws std::runtime_error naming the file that cannot be written.
[[nodiscard]] std::ofstream openToWrite(const std::filesystem::path& path);
void writeObj(const std::filesystem::path& path, const std::vector<Vec3f>& vertices,
              const std::vector<TriangleIndices>& triangles);
/// Throws std::runtime_error naming the file and the line that cannot be read.
[[nodiscard]] Obj readObj(const std::filesystem::path& path);

}  // namespace haptics::eval
