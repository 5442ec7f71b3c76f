#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/importer/include_reader.h"

namespace haptics {

inline constexpr std::uint64_t kNoIndex = ~std::uint64_t{0};

/// A whole number from 0; else `instead`.
[[nodiscard]] std::uint64_t numberIn(const nlohmann::json& object, const char* key, std::uint64_t instead);
/// Element of a list that is a member; null where it is not there.
[[nodiscard]] const nlohmann::json& itemIn(const nlohmann::json& object, const char* key, std::uint64_t index);
/// Null where it is not there.
[[nodiscard]] const nlohmann::json& memberIn(const nlohmann::json& object, const char* key);

/// Component types of accessors.
namespace gltf {
inline constexpr std::uint64_t kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125,
                               kFloat32 = 5126;
/// Bytes of one; 0: there is none of this number.
[[nodiscard]] std::uint64_t bytesOf(std::uint64_t componentType);
/// 1 for "SCALAR", 3 for "VEC3"; 0: there is none of this name.
[[nodiscard]] std::uint64_t componentsOf(const nlohmann::json& accessor);
}  // namespace gltf

/// The numbers of a glTF's accessors.
class GltfValues {
 public:
  /// @param binary  Of a binary file: the buffer without a name.
  GltfValues(const nlohmann::json& root, std::optional<std::string_view> binary, const IncludeReader& readIncluded)
      : root_(root), binary_(binary), readIncluded_(readIncluded) {}

  /// All components of an accessor, one element after the other. Refused: another type than `type`, bytes that are not there.
  /// @param most  Elements.
  [[nodiscard]] Result<std::vector<double>> of(std::uint64_t accessor, const char* type, std::uint64_t most);

 private:
  const nlohmann::json& root_;
  const std::optional<std::string_view> binary_;
  const IncludeReader& readIncluded_;
  std::map<std::string, std::string, std::less<>> read_;  ///< By URI.

  struct Layout {
    std::uint64_t view = 0, offset = 0, type = 0, components = 0, count = 0;
    bool isNormalized = false;
  };
  [[nodiscard]] Result<std::vector<double>> numbers(const Layout& layout, const std::string& name);
  [[nodiscard]] Result<std::string_view> bytesIn(std::uint64_t buffer);
};

/// What the text of a "data:" URI stands for; nothing: it is not base64, as of RFC 4648, section 4 or 5.
[[nodiscard]] std::optional<std::string> fromDataUri(std::string_view uri);

}  // namespace haptics
