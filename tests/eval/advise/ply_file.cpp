#include "tests/eval/advise/ply_file.h"

#include "common/mesh/canonical_bytes.h"

namespace haptics::eval {

std::string plyOf(const TriMesh& mesh) {
  constexpr std::uint8_t kCorners = 3;
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex " +
                      std::to_string(mesh.vertices.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                      std::to_string(mesh.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (const Vec3f v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) append(bytes, v[k]);
  }
  for (const TriangleIndices& triangle : mesh.triangles) {
    append(bytes, kCorners);
    for (const std::uint32_t corner : triangle) append(bytes, corner);
  }
  return bytes;
}

}  // namespace haptics::eval
