#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "haptics/v1/scene.pb.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// Edits as clients send them, with every property that a scene can have, at usual and at outermost values. Objects are of
/// some centimetres, about the world's origin. The server refuses some: two properties that do not go together.
class RandomEdits {
 public:
  explicit RandomEdits(std::uint64_t seed) : random_(seed) {}

  /// @param scene  In which it is to be carried out.
  [[nodiscard]] v1::Transaction next(const SceneVersion& scene);
  /// The next edits are samples of a stream of poses.
  [[nodiscard]] bool streams() const noexcept { return samplesLeft_ > 0; }

 private:
  [[nodiscard]] bool chance(double share) { return random_.chance(share); }
  template <class T>
  [[nodiscard]] T one(std::initializer_list<T> of) {
    return of.begin()[random_.below(static_cast<int>(of.size()))];
  }
  /// Between both, each order of magnitude alike.
  [[nodiscard]] double spread(double low, double high);
  void set(v1::Vector3& to, Vec3 from);
  void setWithin(v1::Vector3& to, double most);
  void setDirection(v1::Vector3& to);

  void addMesh(v1::MeshSource& mesh);
  void addPose(v1::Pose& pose);
  void addMaterial(v1::Material& material);
  void addFriction(v1::Friction& friction);
  void addMap(v1::SurfaceMap& map);
  void addField(v1::ScalarField& field, bool layered);
  void addMapped(v1::MappedField& mapped);
  void addMotion(v1::Motion& motion);
  void addJoint(v1::Joint& joint);
  void addDeformation(v1::Deformation& deformation, const ObjectRecord* object);
  void setTexture(v1::Effect& effect);
  void addEffect(v1::Effect& effect);
  void addObject(v1::AddObject& add);
  void addOperation(v1::Operation& operation, const SceneVersion& scene);
  void addBends(v1::Lattice& lattice);
  void addSample(v1::Operation& operation);

  Random random_;
  std::uint64_t named_ = 0;
  // Of the stream: samples, whose object, where it is and how it goes on.
  int samplesLeft_ = 0;
  ObjectId streamed_ = 0;
  bool streamsShape_ = false;
  Vec3 place_m_{0}, step_m_{0};
};

}  // namespace haptics::eval
