#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/error/error.h"

namespace haptics {

/// Looks whether the fields of a glTF 2.0 that Assimp reads are as the format has them: it stops at some that are not, and passes
/// over others. Each refusal has the field's path ("nodes[3].mesh"), what it is and what it would have to be.
class GltfFields {
 public:
  /// @param isBinary  The first buffer needs no name.
  GltfFields(const nlohmann::json& root, bool isBinary) : root_(root), isBinary_(isBinary) {}

  /// The lists, the version, and the scene that is shown.
  [[nodiscard]] Result<void> root() const;
  /// Its mesh, children and place.
  [[nodiscard]] Result<void> node(std::uint64_t index) const;
  /// Its primitives, and the accessors, views and buffers of their points and corners.
  [[nodiscard]] Result<void> mesh(std::uint64_t index);

 private:
  const nlohmann::json& root_;
  const bool isBinary_;
  std::set<std::uint64_t> buffers_;  ///< That are right.

  [[nodiscard]] Result<void> reference(const nlohmann::json& in, const std::string& path, const char* key,
                                       const char* list) const;
  [[nodiscard]] Result<void> accessor(std::uint64_t index, bool isOfPositions);
  [[nodiscard]] Result<void> view(std::uint64_t index, std::uint64_t element_bytes);
  [[nodiscard]] Result<void> buffer(std::uint64_t index);
};

/// Writes whole numbers that are written as "4.0" as integers, and leaves members out that are null.
void plainGltf(nlohmann::json& value);

}  // namespace haptics
