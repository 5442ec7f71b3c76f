#include "tests/stress/stress_scene.h"

namespace haptics::stress {
namespace {

constexpr double kCounterHeight_m = 2, kMarkHeight_m = 2.1;

void place(v1::Transaction& transaction, const std::string& name, double x, double y, double z) {
  v1::SetPose& set = *transaction.add_operations()->mutable_set_pose();
  set.mutable_object()->set_name(name);
  v1::Vector3& position = *set.mutable_pose()->mutable_position();
  position.set_x(x);
  position.set_y(y);
  position.set_z(z);
}

std::string smallBall(const std::string& name, double z) {
  return "operations { add { name: \"" + name +
         "\" mesh { sphere { radius_m: 0.001 segments: 1 } } pose { position { z: " + std::to_string(z) + " } } } }\n";
}

}  // namespace

std::string sceneText(int clients) {
  std::string text = R"(operations { add { name: "torus" mesh { torus { major_radius_m: 0.042 minor_radius_m: 0.018 } }
                   pose { position { x: -0.06 z: 0.018 } } } }
operations { add { name: "box" mesh { box { size_m { x: 0.07 y: 0.07 z: 0.05 } segments: 4 } }
                   pose { position { x: 0.06 z: 0.025 } } } }
)";
  text += smallBall(kCounter, kCounterHeight_m);
  for (int client = 0; client < clients; ++client) text += smallBall(markName(client), kMarkHeight_m);
  return text;
}

v1::Transaction makeEdit(int client, EditName name, const ObjectRecord* counter) {
  v1::Transaction transaction;
  place(transaction, markName(client), static_cast<double>(name.life) * kMetresPerCount,
        static_cast<double>(name.number) * kMetresPerCount, kMarkHeight_m);
  if (counter != nullptr) {
    v1::Precondition& unchanged = *transaction.add_preconditions();
    unchanged.mutable_object()->set_id(counter->id);
    unchanged.set_expected_revision(counter->revision);
    place(transaction, kCounter, static_cast<double>(countOf(*counter) + 1) * kMetresPerCount, 0, kCounterHeight_m);
  }
  return transaction;
}

}  // namespace haptics::stress
