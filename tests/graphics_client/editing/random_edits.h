#pragma once

#include <random>
#include <string>
#include <vector>

#include "common/assets/asset_content.h"
#include "common/scene/scene.h"
#include "haptics/v1/scene.pb.h"

namespace haptics::test {

struct RandomEdit {
  v1::Transaction transaction;
  std::vector<AssetContent> uploads;
};

/// Edits of every kind, of one to three operations each. A server refuses some: values of a mesh's vertices beside
/// another mesh, an object that an earlier operation has removed.
class RandomEdits {
 public:
  explicit RandomEdits(unsigned seed) : random_(seed) {}

  [[nodiscard]] RandomEdit next(const SceneVersion& scene);

 private:
  std::mt19937 random_;
  unsigned added_ = 0;

  double number(double least, double most) { return std::uniform_real_distribution(least, most)(random_); }
  unsigned below(unsigned count) { return std::uniform_int_distribution(0U, count - 1)(random_); }
  std::string unit();
  std::string rotation();
  std::string vector(double most);
  std::string mesh();
  std::string field(RandomEdit& edit);
  std::string texture(RandomEdit& edit);
  std::string friction(RandomEdit& edit);
  std::string scalars();
  std::string material(RandomEdit& edit);
  std::string motion();
  std::string deformation();
  std::string effects();
  std::string operation(const std::string& name, RandomEdit& edit);
};

}  // namespace haptics::test
