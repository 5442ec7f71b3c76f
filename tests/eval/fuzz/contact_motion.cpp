#include "tests/eval/fuzz/contact_motion.h"

#include <chrono>

namespace haptics::eval {

ContactDrive::ContactDrive(const std::vector<FuzzMesh>& meshes, const ContactFrame& first) : bodies_(meshes.size()) {
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    surfaces_.push_back(meshes[i].build());
    bodies_[i].surface = surfaces_.back().get();
    bodies_[i].previous = bodies_[i].current = first.poses[i];
    bodies_[i].update();
  }
  resetContact(state_, first.hip);
}

const ContactResult& ContactDrive::tick(const ContactFrame& frame) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i].previous = bodies_[i].current;
    bodies_[i].current = frame.poses[i];
    bodies_[i].update();
  }
  result_ = {};
  const auto begin = std::chrono::steady_clock::now();
  followContact(bodies_, state_, frame.hip, result_, cache_);
  duration_ns_ = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
  if (!result_.touching) result_.ihip = frame.hip;
  return result_;
}

}  // namespace haptics::eval
