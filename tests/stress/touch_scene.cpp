#include "tests/stress/touch_scene.h"

#include <array>

namespace haptics::stress {
namespace {

constexpr std::array kBarHalf_m{0.01, 0.01, 0.04};

}  // namespace

std::string touchedSceneText() {
  return R"(operations { add { name: "ball" mesh { sphere { radius_m: 0.05 segments: 73 } }
    pose { position { x: -0.1 z: 0.05 } }
    material { stiffness_N_per_m: 900 damping_Ns_per_m: 0.5 }
    deformation { softness { stiffness_N_per_m: 250 radius_m: 0.04 return_s: 0.3 } } } }
operations { add { name: "brick" mesh { box { size_m { x: 0.05 y: 0.04 z: 0.04 } segments: 4 } }
    pose { position { x: 0.03 z: 0.02 } }
    material { friction { mu_static: 0.6 mu_dynamic: 0.4 } }
    motion { mass_kg: 0.15 planes { normal { z: 1 } friction: 0.1 }
      spring { stiffness_N_per_m: 40 damping_Ns_per_m: 2 stiffness_Nm_per_rad: 0.05 damping_Nms_per_rad: 0.002 } } } }
operations { add { name: "knob" mesh { sphere { radius_m: 0.02 segments: 16 } }
    pose { position { x: 0.12 z: 0.06 } }
    motion { mass_kg: 0.1 gravity_m_per_s2 {}
      spring { stiffness_N_per_m: 60 damping_Ns_per_m: 1 stiffness_Nm_per_rad: 0.1 damping_Nms_per_rad: 0.0005 } } } }
operations { add { name: "bar" mesh { box { size_m { x: 0.02 y: 0.02 z: 0.08 } segments: 16 } }
    pose { position { x: 0.2 z: 0.04 } }
    deformation { softness { stiffness_N_per_m: 600 radius_m: 0.006 return_s: 0.2 } } } }
)";
}

v1::Transaction roof() {
  v1::Transaction transaction;
  v1::AddObject& add = *transaction.add_operations()->mutable_add();
  add.set_name("roof");
  v1::Vector3& size = *add.mutable_mesh()->mutable_box()->mutable_size_m();
  size.set_x(0.8);
  size.set_y(0.8);
  size.set_z(0.01);
  add.mutable_pose()->mutable_position()->set_z(0.25);
  return transaction;
}

v1::Transaction bend(double x_m, double y_m) {
  v1::Transaction transaction;
  v1::SetDeformation& set = *transaction.add_operations()->mutable_set_deformation();
  set.mutable_object()->set_name("bar");
  v1::Lattice& lattice = *set.mutable_deformation()->mutable_lattice();
  lattice.set_points_x(2);
  lattice.set_points_y(2);
  lattice.set_points_z(2);
  for (const double z : {-1, 1}) {
    for (const double y : {-1, 1}) {
      for (const double x : {-1, 1}) {
        lattice.add_control_m(static_cast<float>(x * kBarHalf_m[0] + (z > 0 ? x_m : 0)));
        lattice.add_control_m(static_cast<float>(y * kBarHalf_m[1] + (z > 0 ? y_m : 0)));
        lattice.add_control_m(static_cast<float>(z * kBarHalf_m[2]));
      }
    }
  }
  return transaction;
}

}  // namespace haptics::stress
