#pragma once

#include "tests/eval/fuzz/edit_judge.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// A scene drawn from a seed under a HIP that presses an object, rests, and feels edits come, again and again.
class EditScene {
 public:
  static constexpr int kEdits = 12;

  explicit EditScene(std::uint64_t seed);
  EditScene(const EditScene&) = delete;
  EditScene& operator=(const EditScene&) = delete;

  /// The next edit, or two, from the approach to the end of its window.
  EditVerdict next();
  [[nodiscard]] const EditRun& run() const noexcept { return run_; }
  [[nodiscard]] bool inContact() const noexcept { return inContact_; }  ///< When the last edit came.

 private:
  /// What this scene has.
  struct Features {
    bool damping, soft, moving, friction, texture, shading;
  };
  [[nodiscard]] std::uint64_t ticks(double seconds) const;
  [[nodiscard]] const EditRun& chosenRun();
  void step(Vec3 hip);
  void publish();
  void press();
  void watch(double seconds);

  [[nodiscard]] std::size_t someObject();
  [[nodiscard]] std::size_t touchedOrSome();
  [[nodiscard]] std::size_t addMesh(MeshKind kind);
  [[nodiscard]] std::size_t someMesh(bool mayMove);
  [[nodiscard]] Pose somePose();
  [[nodiscard]] SoftTissue someTissue();
  void add(const Pose& pose);
  void setPose(FuzzObject& object, const Pose& pose);
  void setMesh(FuzzObject& object, std::size_t mesh);
  void pullLattice(FuzzObject& object);
  [[nodiscard]] std::string edit();
  [[nodiscard]] bool tryEdit(int kind);

  Random random_;
  Features features_{};
  EditRun run_;
  std::vector<bool> canMove_;  ///< Of the meshes.
  EditDrive drive_;
  EditJudge judge_;
  std::vector<FuzzObject> objects_;  ///< As of the newest revision, with those that leave.
  std::uint64_t revision_ = 0;
  std::uint64_t lastId_ = 0;
  Vec3 hip_{0.15, 0.15, 0.15};
  bool inContact_ = false;
};

}  // namespace haptics::eval
