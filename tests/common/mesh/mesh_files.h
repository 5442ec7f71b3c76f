#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "common/mesh/import.h"
#include "tests/common/temporary_folder.h"

namespace haptics::fixture {

/// A folder of its own for each test, removed with it.
class MeshFiles : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, std::string_view content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  /// As the asset importer does it, in this process.
  static Result<ImportedMesh> import(const std::string& name, std::string_view content,
                                     const ImportOptions& options = {}) {
    return meshFormatOf(name).and_then([&](MeshFormat format) { return importMesh(content, format, options); });
  }

  /// Why the file was refused; "loaded" if it was not.
  static std::string refusal(const std::string& name, std::string_view content) {
    const auto imported = import(name, content);
    return imported ? "loaded" : imported.error().reason;
  }

  const test::TemporaryFolder folder_;
};

/// The bytes of a value, as it lies in memory (little-endian).
template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

inline constexpr std::string_view kTetrahedronOff =
    "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

/// What the files above and below hold.
inline TriMesh tetrahedron() {
  return canonicalise({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {})
      ->mesh;
}

}  // namespace haptics::fixture
