#include "common/mesh/mesh_asset.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

namespace haptics {
namespace {

static_assert(std::endian::native == std::endian::little, "canonical bytes are little-endian");
static_assert(sizeof(Vec3f) == 12 && sizeof(TriangleIndices) == 12, "vertices and triangles are copied as they lie");
static_assert(std::is_trivially_copyable_v<Vec3f> && std::is_trivially_copyable_v<TriangleIndices>);

constexpr std::string_view kMagic = "HMSH";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeaderSize = kMagic.size() + sizeof kVersion + 2 * sizeof(std::uint64_t);

std::array<std::byte, kHeaderSize> headerOf(const TriMesh& mesh) {
  const std::uint64_t vertices = mesh.vertices.size();
  const std::uint64_t triangles = mesh.triangles.size();
  std::array<std::byte, kHeaderSize> header;
  std::byte* at = header.data();
  const auto put = [&at](const void* value, std::size_t size) {
    std::memcpy(at, value, size);
    at += size;
  };
  put(kMagic.data(), kMagic.size());
  put(&kVersion, sizeof kVersion);
  put(&vertices, sizeof vertices);
  put(&triangles, sizeof triangles);
  return header;
}

template <class T>
T valueAt(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void append(std::string& bytes, const T& values) {
  const auto raw = std::as_bytes(std::span(values));
  bytes.append(reinterpret_cast<const char*>(raw.data()), raw.size());
}

}  // namespace

std::string encodeMesh(const TriMesh& mesh) {
  std::string bytes;
  bytes.reserve(kHeaderSize + sizeof(Vec3f) * mesh.vertices.size() + sizeof(TriangleIndices) * mesh.triangles.size());
  append(bytes, headerOf(mesh));
  append(bytes, mesh.vertices);
  append(bytes, mesh.triangles);
  return bytes;
}

Result<TriMesh> decodeMesh(std::string_view bytes) {
  if (bytes.size() < kHeaderSize) {
    return refused("header", "the asset has " + std::to_string(bytes.size()) + " bytes; its header alone takes " +
                                 std::to_string(kHeaderSize));
  }
  if (!bytes.starts_with(kMagic)) return refused("magic", "is not \"HMSH\": the asset is not a mesh");
  const auto version = valueAt<std::uint32_t>(bytes, kMagic.size());
  if (version != kVersion) {
    return refused("version", "is " + std::to_string(version) + "; this program reads " + std::to_string(kVersion));
  }
  const auto vertices = valueAt<std::uint64_t>(bytes, kMagic.size() + sizeof kVersion);
  const auto triangles = valueAt<std::uint64_t>(bytes, kMagic.size() + sizeof kVersion + sizeof vertices);
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
  mesh.vertices.resize(vertices);
  mesh.triangles.resize(triangles);
  const std::string_view body = bytes.substr(kHeaderSize);
  const std::size_t split = sizeof(Vec3f) * mesh.vertices.size();
  body.copy(reinterpret_cast<char*>(mesh.vertices.data()), split);
  body.substr(split).copy(reinterpret_cast<char*>(mesh.triangles.data()), body.size() - split);
  if (auto ok = checkMesh(mesh); !ok) return tl::unexpected(std::move(ok).error());
  return mesh;
}

ContentHash hashOf(const TriMesh& mesh) {
  return Hasher()
      .add(headerOf(mesh))
      .add(std::as_bytes(std::span(mesh.vertices)))
      .add(std::as_bytes(std::span(mesh.triangles)))
      .finish();
}

}  // namespace haptics
