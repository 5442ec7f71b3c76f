#include "tests/eval/worst/mesh_writer.h"

#include <array>
#include <cstdio>
#include <cstring>

#include "tests/eval/random.h"

namespace haptics::eval {
namespace {

using shapes::Shape;

template <class... Values>
void print(std::string& to, const char* format, Values... values) {
  std::array<char, 120> line;
  to.append(line.data(), static_cast<std::size_t>(std::snprintf(line.data(), line.size(), format, values...)));
}

void printVertices(std::string& to, const std::vector<Vec3f>& vertices, const char* format) {
  for (const Vec3f v : vertices) {
    print(to, format, static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
  }
}

std::string offOf(const Shape& shape) {
  std::string off;
  print(off, "OFF\n%zu %zu 0\n", shape.vertices.size(), shape.triangles.size());
  printVertices(off, shape.vertices, "%.9g %.9g %.9g\n");
  for (const auto& [a, b, c] : shape.triangles) print(off, "3 %u %u %u\n", a, b, c);
  return off;
}

std::string objOf(const Shape& shape) {
  std::string obj;
  printVertices(obj, shape.vertices, "v %.9g %.9g %.9g\n");
  for (const auto& [a, b, c] : shape.triangles) print(obj, "f %u %u %u\n", a + 1, b + 1, c + 1);
  return obj;
}

std::string plyOf(const Shape& shape) {
  std::string ply;
  print(ply, "ply\nformat ascii 1.0\nelement vertex %zu\n", shape.vertices.size());
  ply += "property float x\nproperty float y\nproperty float z\n";
  print(ply, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n", shape.triangles.size());
  printVertices(ply, shape.vertices, "%.9g %.9g %.9g\n");
  for (const auto& [a, b, c] : shape.triangles) print(ply, "3 %u %u %u\n", a, b, c);
  return ply;
}

std::string stlOf(const Shape& shape) {
  std::string stl(80, ' ');
  const auto put = [&stl](const auto& value) {
    std::array<char, sizeof value> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    stl.append(bytes.data(), bytes.size());
  };
  put(static_cast<std::uint32_t>(shape.triangles.size()));
  for (const auto& triangle : shape.triangles) {
    put(Vec3f(0));
    for (const std::uint32_t v : triangle) put(shape.vertices[v]);
    put(std::uint16_t{0});
  }
  return stl;
}

}  // namespace

MeshFile fileOf(Shape shape, double gene) {
  const int kind = static_cast<int>(gene * 8);
  if (kind >= 4) {
    Random random(1);
    for (std::size_t i = shape.triangles.size(); i > 1; --i) {
      std::swap(shape.triangles[i - 1], shape.triangles[static_cast<std::size_t>(random.below(static_cast<int>(i)))]);
    }
  }
  switch (kind % 4) {
    case 0:
      return {offOf(shape), MeshFormat::kOff};
    case 1:
      return {objOf(shape), MeshFormat::kObj};
    case 2:
      return {plyOf(shape), MeshFormat::kPly};
    default:
      return {stlOf(shape), MeshFormat::kStl};
  }
}

MeshFile fileOf(const std::vector<Vec3f>& vertices, const std::vector<std::vector<std::uint32_t>>& polygons) {
  std::string off;
  print(off, "OFF\n%zu %zu 0\n", vertices.size(), polygons.size());
  printVertices(off, vertices, "%.9g %.9g %.9g\n");
  for (const auto& corners : polygons) {
    print(off, "%zu", corners.size());
    for (const std::uint32_t v : corners) print(off, " %u", v);
    off += '\n';
  }
  return {std::move(off), MeshFormat::kOff};
}

}  // namespace haptics::eval
