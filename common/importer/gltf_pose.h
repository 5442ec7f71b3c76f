#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/importer/gltf_values.h"

namespace haptics {

/// Poses the meshes of a glTF's nodes: by the weights that a node, or else its mesh, gives the targets, and by the joints of its
/// skin as the file's nodes place them. Source: glTF 2.0, 3.7.2.2 and 3.7.3.3.
class GltfPose {
 public:
  /// @param most  Points that are made in all.
  GltfPose(const nlohmann::json& root, GltfValues& values, std::uint64_t most);

  /// The points of each primitive, in float32, in the mesh's frame; where there is a skin in the scene's, in which the node itself
  /// does not place it. Of a primitive without points: nothing. Refused: numbers that are not there, a joint that is no node.
  [[nodiscard]] Result<std::vector<std::string>> of(const nlohmann::json& node);

 private:
  const nlohmann::json& root_;
  GltfValues& values_;
  std::uint64_t left_;
  std::vector<std::uint64_t> parents_;  ///< Of each node; kNoIndex: none.

  [[nodiscard]] glm::dmat4 placed(std::uint64_t node) const;
  /// How each joint moves a point that is stored.
  [[nodiscard]] Result<std::vector<glm::dmat4>> jointsOf(std::uint64_t skin);
  [[nodiscard]] Result<std::vector<double>> morphed(const nlohmann::json& primitive,
                                                    const std::vector<double>& weights);
  [[nodiscard]] Result<void> skin(const nlohmann::json& attributes, const std::vector<glm::dmat4>& joints,
                                  std::vector<double>& points);
};

/// Whether a node has a skin, or weights of which one is not 0.
[[nodiscard]] bool isPosed(const nlohmann::json& root, const nlohmann::json& node);

}  // namespace haptics
