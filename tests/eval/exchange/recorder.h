#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <utility>

#include "tests/eval/renderer.h"
#include "tests/eval/report.h"

namespace haptics::eval {

inline constexpr std::string_view kExchangeFormat = "haptics scene 1";
inline constexpr const char* kDentsFile = "dents.csv";
inline constexpr const char* kBulgesFile = "bulges.csv";

/// Scenes of these are led through what a Renderer is asked, and through nothing beside it.
[[nodiscard]] constexpr bool isExchanged(Concern concern) {
  return concern == Concern::kContact || concern == Concern::kEdits || concern == Concern::kSurfaces ||
         concern == Concern::kStreams;
}

/// Writes down what a method is asked in a scene and what it answers, as files that README.md describes.
class Recorder final : public Renderer {
 public:
  /// Makes the folder. Throws std::runtime_error when it cannot, or when one is there.
  Recorder(std::unique_ptr<Renderer> method, std::filesystem::path folder);

  /// Writes scene.json, with what `about` says of the run first, and verdict.json. Throws std::runtime_error naming the file
  /// that cannot be written.
  void finish(const Record& about, const Record& verdict);

  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override;
  void setSurfaceProperties(const FeltSurface& surface) override;
  void place(Vec3 hip) override;
  void contactOnly() override { method_->contactOnly(); }
  void edit(const EditedScene& scene, Vec3 hip) override;
  Felt tick(std::span<const Pose> poses, Vec3 hip) override;
  Felt drive(std::span<const Pose> samples, bool haveCome, Vec3 hip) override;
  [[nodiscard]] std::vector<Dent> dents(std::size_t body) const override;
  [[nodiscard]] double highestBulge_m(std::size_t body) const override;
  [[nodiscard]] bool turnsMirroredOver() const override { return method_->turnsMirroredOver(); }

 private:
  void writeLoad(std::span<const std::shared_ptr<const CollisionMesh>> bodies, double spring_N_per_m);
  void writeMotion(const char* event, std::span<const Pose> poses, Vec3 hip);
  [[nodiscard]] std::string meshFileOf(const std::shared_ptr<const CollisionMesh>& surface);
  Felt written(const Felt& felt);

  std::unique_ptr<Renderer> method_;
  std::filesystem::path folder_;
  std::ofstream motion_, poses_, forces_;
  std::vector<std::pair<std::shared_ptr<const CollisionMesh>, std::string>> meshes_;
  Record loads_ = Record::array();
  std::optional<FeltSurface> surface_;
  std::vector<Pose> lastPoses_;
  std::int64_t row_ = 0;
  mutable std::ofstream dents_, bulges_;                           // made with their first row
  mutable std::set<std::pair<std::int64_t, std::size_t>> dented_;  // row and body of what is written
};

}  // namespace haptics::eval
