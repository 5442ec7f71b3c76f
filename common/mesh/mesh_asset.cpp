#include "common/mesh/mesh_asset.h"

#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "common/interruption/grow.h"

namespace haptics {
namespace {

static_assert(sizeof(Vec3f) == 12 && sizeof(TriangleIndices) == 12, "vertices and triangles are copied as they lie");
static_assert(std::is_trivially_copyable_v<Vec3f> && std::is_trivially_copyable_v<TriangleIndices>);

constexpr std::string_view kMeshMagic = "HMSH";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderSize = kMeshMagic.size() + sizeof kVersion + 2 * sizeof(std::uint64_t);

template <class T>
T valueAt(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

CanonicalBytes canonicalBytes(const TriMesh& mesh) {
  std::string header(kMeshMagic);
  append(header, kVersion);
  append(header, std::uint64_t{mesh.vertices.size()});
  append(header, std::uint64_t{mesh.triangles.size()});
  return {std::move(header), {std::as_bytes(std::span(mesh.vertices)), std::as_bytes(std::span(mesh.triangles))}};
}

std::string encodeMesh(const TriMesh& mesh) { return canonicalBytes(mesh).copy(); }

Result<TriMesh> decodeMesh(std::string_view bytes) {
  if (bytes.size() < kHeaderSize) {
    return refused("header", "the asset has " + std::to_string(bytes.size()) + " bytes; its header alone takes " +
                                 std::to_string(kHeaderSize));
  }
  if (!bytes.starts_with(kMeshMagic)) return refused("magic", "is not \"HMSH\": the asset is not a mesh");
  const auto version = valueAt<std::uint32_t>(bytes, kMeshMagic.size());
  if (version != kVersion) {
    return refused("version", "is " + std::to_string(version) + "; this program reads " + std::to_string(kVersion));
  }
  const auto vertices = valueAt<std::uint64_t>(bytes, kMeshMagic.size() + sizeof kVersion);
  const auto triangles = valueAt<std::uint64_t>(bytes, kMeshMagic.size() + sizeof kVersion + sizeof vertices);
  if (vertices > kMaxVertices) {
    return refused("vertex count",
                   std::to_string(vertices) + " is too many; at most " + std::to_string(kMaxVertices) + " are taken");
  }
  if (triangles > kMaxTriangles) {
    return refused("triangle count",
                   std::to_string(triangles) + " is too many; at most " + std::to_string(kMaxTriangles) + " are taken");
  }
  const std::uint64_t size = kHeaderSize + sizeof(Vec3f) * vertices + sizeof(TriangleIndices) * triangles;
  if (bytes.size() != size) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; " + std::to_string(vertices) +
                               " vertices and " + std::to_string(triangles) + " triangles take " +
                               std::to_string(size));
  }

  TriMesh mesh;
  growTo(mesh.vertices, vertices);
  growTo(mesh.triangles, triangles);
  const std::string_view body = bytes.substr(kHeaderSize);
  const std::size_t split = sizeof(Vec3f) * mesh.vertices.size();
  body.copy(reinterpret_cast<char*>(mesh.vertices.data()), split);
  body.substr(split).copy(reinterpret_cast<char*>(mesh.triangles.data()), body.size() - split);
  if (auto ok = checkMesh(mesh); !ok) return tl::unexpected(std::move(ok).error());
  return mesh;
}

ContentHash hashOf(const TriMesh& mesh) { return canonicalBytes(mesh).hash(); }

}  // namespace haptics
