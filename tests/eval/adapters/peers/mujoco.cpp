// MuJoCo: a body in the hand, a small sphere on a spring and a damper, among meshes. It takes a mesh for its convex hull.

#include <mujoco/mujoco.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "tests/eval/adapters/peers/peer_scene.h"

namespace haptics::eval::peers {
namespace {

constexpr double kTick_s = 1e-3;
constexpr int kSteps = 4;  // of a tick
constexpr double kMass_kg = 0.02;

std::string modelOf(const haptics_scene& scene) {
  std::ostringstream xml;
  xml.precision(9);
  xml << "<mujoco><compiler angle='radian'/><option timestep='" << kTick_s / kSteps
      << "' gravity='0 0 0'/><size njmax='2000' nconmax='500'/><default><geom condim='1' solref='0.001 "
         "1'/></default><asset>";
  for (std::uint32_t i = 0; i < scene.body_count; ++i) {
    const haptics_body& body = scene.bodies[i];
    xml << "<mesh name='m" << i << "' vertex='";
    for (std::uint32_t k = 0; k < 3 * body.vertex_count; ++k) xml << body.vertices[k] << ' ';
    xml << "' face='";
    for (std::uint32_t k = 0; k < 3 * body.triangle_count; ++k) xml << body.triangles[k] << ' ';
    xml << "'/>";
  }
  xml << "</asset><worldbody>";
  for (std::uint32_t i = 0; i < scene.body_count; ++i) {
    xml << "<body mocap='true'><geom type='mesh' mesh='m" << i << "' contype='1' conaffinity='2'/></body>";
  }
  xml << "<body><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/><joint type='slide' axis='0 0 1'/>"
         "<geom type='sphere' size='"
      << kProxyRadius_m << "' mass='" << kMass_kg << "' contype='2' conaffinity='1'/></body></worldbody></mujoco>";
  return xml.str();
}

class World {
 public:
  explicit World(const haptics_scene& scene) {
    const std::string xml = modelOf(scene);
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    if (mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size())) != 0)
      throw std::runtime_error("the scene is too large");
    std::memcpy(files->filedata[0], xml.data(), xml.size());
    char error[500] = "";
    model_.reset(mj_loadXML("scene.xml", files.get(), error, sizeof error));
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(error);
    data_.reset(mj_makeData(model_.get()));
    stiffness_N_per_m_ = scene.body_count > 0 ? scene.bodies[0].stiffness_N_per_m : 0;
    for (std::uint32_t i = 0; i < scene.body_count; ++i) setPose(i, scene.bodies[i].pose);
    place(toVec3(scene.hip_m));
  }

  void place(Vec3 hip) {
    for (int k = 0; k < 3; ++k) {
      data_->qpos[k] = hip[k];
      data_->qvel[k] = 0;
    }
    mj_forward(model_.get(), data_.get());
    lastHip_ = hip;
  }

  void tick(const haptics_pose* poses, Vec3 hip, haptics_answer& answer) {
    const double damping = 2 * std::sqrt(stiffness_N_per_m_ * kMass_kg);  // critical
    for (int i = 0; i < model_->nmocap; ++i) setPose(static_cast<std::uint32_t>(i), poses[i]);
    const Vec3 velocity = (hip - lastHip_) / kTick_s;
    lastHip_ = hip;
    for (int step = 0; step < kSteps; ++step) {
      for (int k = 0; k < 3; ++k)
        data_->qfrc_applied[k] =
            stiffness_N_per_m_ * (hip[k] - data_->qpos[k]) + damping * (velocity[k] - data_->qvel[k]);
      mj_step(model_.get(), data_.get());
    }
    if (data_->ncon > 0) {
      answerSphere(answer, toVec3(data_->qpos), hip, stiffness_N_per_m_);
    } else {
      answerPlace(answer, hip);
    }
  }

 private:
  void setPose(std::uint32_t body, const haptics_pose& pose) {
    std::memcpy(data_->mocap_pos + 3 * body, pose.position, sizeof pose.position);
    std::memcpy(data_->mocap_quat + 4 * body, pose.rotation, sizeof pose.rotation);
  }

  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
  Vec3 lastHip_{0};
  double stiffness_N_per_m_ = 0;
};

}  // namespace
}  // namespace haptics::eval::peers

const haptics_method_functions* haptics_method() {
  using namespace haptics::eval::peers;
  static const std::string version =
      std::string("MuJoCo ") + mj_versionString() + ", sphere of 1 mm and 20 g on a spring, 4 kHz, convex hulls";
  return functionsOf<World>(HAPTICS_MOVING_BODIES | HAPTICS_EDITS, "mujoco", version.c_str());
}
