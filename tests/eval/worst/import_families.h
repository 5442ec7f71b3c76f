#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/mesh/import.h"

namespace haptics::eval {

struct MeshFile {
  std::string bytes;
  MeshFormat format = MeshFormat::kOff;
};

/// Files of one kind, of any size. Genes are numbers in [0, 1): the same ones make the same file.
struct ImportFamily {
  static constexpr std::size_t kGenes = 4;

  std::string_view name;
  std::string_view about;
  /// Of some `triangles`, once polygons are cut. The last gene is the format and whether the triangles are shuffled.
  MeshFile (*make)(std::span<const double, kGenes> genes, int triangles);
};

/// For the slowest import: meshes in which some part of it has much to do.
[[nodiscard]] std::span<const ImportFamily> importFamilies();

/// Throws std::invalid_argument, listing the names, when there is none called so.
[[nodiscard]] const ImportFamily& findImportFamily(std::string_view name);

}  // namespace haptics::eval
