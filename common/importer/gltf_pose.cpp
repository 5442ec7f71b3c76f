#include "common/importer/gltf_pose.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "common/importer/xml_text.h"
#include "common/maths/vec.h"

namespace haptics {
namespace {

using nlohmann::json;
using Matrix = glm::dmat4;

std::vector<double> numbersIn(const json& object, const char* key) {
  std::vector<double> numbers;
  for (const json& each : memberIn(object, key)) numbers.push_back(each.is_number() ? each.get<double>() : 0);
  return numbers;
}

Matrix matrixOf(const double* columns) {
  Matrix matrix;
  for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = columns[i];
  return matrix;
}

Matrix placeOf(const json& node) {
  if (const auto own = numbersIn(node, "matrix"); own.size() == 16) return matrixOf(own.data());
  Matrix place(1);
  const auto moved = numbersIn(node, "translation"), turned = numbersIn(node, "rotation");
  const auto scaled = numbersIn(node, "scale");
  if (turned.size() == 4)
    place = glm::mat4_cast(glm::normalize(glm::dquat(turned[3], turned[0], turned[1], turned[2])));
  for (int i = 0; i < 3 && scaled.size() == 3; ++i) place[i] *= scaled[static_cast<std::size_t>(i)];
  for (int i = 0; i < 3 && moved.size() == 3; ++i) place[3][i] = moved[static_cast<std::size_t>(i)];
  return place;
}

/// The node's, or else the mesh's.
std::vector<double> weightsOf(const json& root, const json& node) {
  const auto own = numbersIn(node, "weights");
  return own.empty() ? numbersIn(itemIn(root, "meshes", numberIn(node, "mesh", kNoIndex)), "weights") : own;
}

}  // namespace

bool isPosed(const json& root, const json& node) {
  const auto weights = weightsOf(root, node);
  return !memberIn(node, "skin").is_null() || std::ranges::any_of(weights, [](double weight) { return weight != 0; });
}

GltfPose::GltfPose(const json& root, GltfValues& values, std::uint64_t most)
    : root_(root), values_(values), left_(most), parents_(memberIn(root, "nodes").size(), kNoIndex) {
  const json& nodes = memberIn(root, "nodes");
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const json& child : memberIn(nodes[i], "children")) {
      const std::uint64_t own = child.is_number_unsigned() ? child.get<std::uint64_t>() : kNoIndex;
      if (own < parents_.size()) parents_[own] = i;
    }
  }
}

Matrix GltfPose::placed(std::uint64_t index) const {
  Matrix place(1);
  for (int depth = 0; index < parents_.size() && depth <= kDeepestNesting; ++depth, index = parents_[index])
    place = placeOf(itemIn(root_, "nodes", index)) * place;
  return place;
}

Result<std::vector<Matrix>> GltfPose::jointsOf(std::uint64_t skinIndex) {
  constexpr std::uint64_t kMax = 1'000'000;
  const json& skin = itemIn(root_, "skins", skinIndex);
  const std::string path = "skins[" + std::to_string(skinIndex) + "]";
  std::vector<Matrix> joints;
  for (const json& joint : memberIn(skin, "joints")) {
    const std::uint64_t own = joint.is_number_unsigned() ? joint.get<std::uint64_t>() : kNoIndex;
    if (own >= parents_.size() || joints.size() >= kMax)
      return refused("", path + ".joints has " + joint.dump().substr(0, 20) + ", which is no node");
    joints.push_back(placed(own));
  }
  if (joints.empty()) return refused("", path + ".joints is missing or empty; it is a list of nodes");
  const std::uint64_t bound = numberIn(skin, "inverseBindMatrices", kNoIndex);
  if (bound == kNoIndex) return joints;
  const auto matrices = values_.of(bound, "MAT4", kMax);
  if (!matrices) return tl::unexpected(matrices.error());
  if (matrices->size() < 16 * joints.size()) {
    return refused("", path + ".inverseBindMatrices has " + std::to_string(matrices->size() / 16) + " matrices for " +
                           std::to_string(joints.size()) + " joints");
  }
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i] = joints[i] * matrixOf(matrices->data() + 16 * i);
  return joints;
}

Result<std::vector<double>> GltfPose::morphed(const json& primitive, const std::vector<double>& weights) {
  auto points = values_.of(numberIn(memberIn(primitive, "attributes"), "POSITION", kNoIndex), "VEC3", left_);
  if (!points) return points;
  const std::size_t count = points->size() / 3;
  left_ -= count;
  const json& targets = memberIn(primitive, "targets");
  for (std::size_t i = 0; i < std::min(weights.size(), targets.size()); ++i) {
    const std::uint64_t moved = numberIn(targets[i], "POSITION", kNoIndex);
    if (weights[i] == 0 || moved == kNoIndex) continue;
    const auto by = values_.of(moved, "VEC3", count);
    if (!by) return by;
    for (std::size_t k = 0; k < by->size(); ++k) (*points)[k] += weights[i] * (*by)[k];
  }
  return points;
}

Result<void> GltfPose::skin(const json& attributes, const std::vector<Matrix>& joints, std::vector<double>& points) {
  const std::size_t count = points.size() / 3;
  const auto byJoint = [&](std::size_t joint, std::size_t point) {
    const double* const at = points.data() + 3 * point;
    return Vec3(joints[joint] * glm::dvec4(at[0], at[1], at[2], 1));
  };
  std::vector<Vec3> sums(count, Vec3(0));
  std::vector<double> shares(count, 0);
  for (int set = 0;; ++set) {
    const auto indexOf = [&](const char* what) {
      return numberIn(attributes, (what + std::to_string(set)).c_str(), kNoIndex);
    };
    const std::uint64_t ofJoints = indexOf("JOINTS_"), ofWeights = indexOf("WEIGHTS_");
    if (ofJoints == kNoIndex || ofWeights == kNoIndex) break;
    const auto numbers = values_.of(ofJoints, "VEC4", count), own = values_.of(ofWeights, "VEC4", count);
    if (!numbers) return tl::unexpected(numbers.error());
    if (!own) return tl::unexpected(own.error());
    for (std::size_t k = 0; k < std::min(numbers->size(), own->size()); ++k) {
      const double joint = (*numbers)[k], share = (*own)[k];
      if (share == 0) continue;
      if (!(joint >= 0 && joint < static_cast<double>(joints.size()))) {
        return refused("", "accessors[" + std::to_string(ofJoints) + "] names joint " +
                               std::to_string(static_cast<std::int64_t>(joint)) + ", from 0, of " +
                               std::to_string(joints.size()));
      }
      sums[k / 4] += share * byJoint(static_cast<std::size_t>(joint), k / 4);
      shares[k / 4] += share;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 place = shares[i] != 0 ? sums[i] / shares[i] : byJoint(0, i);
    for (int axis = 0; axis < 3; ++axis) points[3 * i + static_cast<std::size_t>(axis)] = place[axis];
  }
  return {};
}

Result<std::vector<std::string>> GltfPose::of(const json& node) {
  std::vector<Matrix> joints;
  if (const std::uint64_t skin = numberIn(node, "skin", kNoIndex); skin != kNoIndex) {
    auto own = jointsOf(skin);
    if (!own) return tl::unexpected(own.error());
    joints = *std::move(own);
  }
  std::vector<std::string> posed;
  const auto weights = weightsOf(root_, node);
  for (const json& primitive : memberIn(itemIn(root_, "meshes", numberIn(node, "mesh", kNoIndex)), "primitives")) {
    posed.emplace_back();
    const json& attributes = memberIn(primitive, "attributes");
    if (memberIn(attributes, "POSITION").is_null()) continue;
    auto points = morphed(primitive, weights);
    if (!points) return tl::unexpected(points.error());
    if (!joints.empty()) {
      if (auto ok = skin(attributes, joints, *points); !ok) return tl::unexpected(std::move(ok).error());
    }
    for (const double coordinate : *points) {
      const auto value = static_cast<float>(coordinate);
      posed.back().append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  return posed;
}

}  // namespace haptics
