#include "tests/eval/exchange/recorder.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "tests/eval/exchange/plain_mesh.h"

namespace haptics::eval {
namespace {

/// As text that gives the same number again.
std::string exactText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string textOf(Vec3 v) { return exactText(v.x) + ',' + exactText(v.y) + ',' + exactText(v.z); }
std::string textOf(const std::optional<Vec3>& v) { return v ? textOf(*v) : ",,"; }

void writePly(const std::filesystem::path& path, const PlainMesh& mesh) {
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\ncomment metres, the body's frame\nelement vertex " << mesh.vertices.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.size()
       << "\nproperty list uchar uint vertex_indices\nend_header\n";
  file.precision(9);
  for (const Vec3f& v : mesh.vertices) file << v.x << ' ' << v.y << ' ' << v.z << '\n';
  for (const auto& t : mesh.triangles) file << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

void describeSurface(Record& load, const FeltSurface& surface) {
  const SurfaceProperties& p = surface.properties;
  if (p.friction)
    load.update({{"static_friction", p.friction->mu_static}, {"dynamic_friction", p.friction->mu_dynamic}});
  if (p.shading) load["crease_rad"] = p.shading->crease_rad;
  const bool more = p.texture || p.stiffnessOver || p.softnessOver || p.scalars != SurfaceScalars<double>{} ||
                    surface.tissue || (p.friction && (p.friction->variation != 0 || p.friction->dynamicVariation != 0));
  if (more) load["more_properties"] = true;
}

}  // namespace

Recorder::Recorder(std::unique_ptr<Renderer> method, std::filesystem::path folder)
    : method_(std::move(method)), folder_(std::move(folder)) {
  std::error_code error;
  std::filesystem::create_directories(folder_.parent_path(), error);
  if (!std::filesystem::create_directory(folder_, error))
    throw std::runtime_error(folder_.string() + ": is there already, or cannot be made");
  motion_.open(folder_ / "motion.csv");
  poses_.open(folder_ / "poses.csv");
  forces_.open(folder_ / "forces.csv");
  motion_ << "row,event,load,hip_x_m,hip_y_m,hip_z_m\n";
  poses_ << "row,body,rotation_w,rotation_x,rotation_y,rotation_z,position_x_m,position_y_m,position_z_m\n";
  forces_ << "row,touching,sliding,force_x_N,force_y_N,force_z_N,ihip_x_m,ihip_y_m,ihip_z_m,triangles,"
             "written_x_N,written_y_N,written_z_N,followed_x_m,followed_y_m,followed_z_m\n";
}

std::string Recorder::meshFileOf(const std::shared_ptr<const CollisionMesh>& surface) {
  const auto known = std::ranges::find(meshes_, surface, &decltype(meshes_)::value_type::first);
  if (known != meshes_.end()) return known->second;
  const std::string name = "mesh" + std::to_string(meshes_.size()) + ".ply";
  writePly(folder_ / name, PlainMesh(*surface));
  meshes_.emplace_back(surface, name);
  return name;
}

void Recorder::writeLoad(std::span<const std::shared_ptr<const CollisionMesh>> bodies, double spring_N_per_m) {
  Record load{{"stiffness_N_per_m", spring_N_per_m}};
  if (surface_) describeSurface(load, *surface_);
  for (const auto& body : bodies) load["bodies"].push_back({{"mesh", meshFileOf(body)}, {"closed", body->closed()}});
  loads_.push_back(std::move(load));
  lastPoses_.clear();
}

void Recorder::writeMotion(const char* event, std::span<const Pose> poses, Vec3 hip) {
  ++row_;
  motion_ << row_ << ',' << event << ',' << loads_.size() - 1 << ',' << textOf(hip) << '\n';
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i < lastPoses_.size() && lastPoses_[i] == poses[i]) continue;
    const Quat& q = poses[i].rotation;
    poses_ << row_ << ',' << i << ',' << exactText(q.w) << ',' << exactText(q.x) << ',' << exactText(q.y) << ','
           << exactText(q.z) << ',' << textOf(poses[i].position) << '\n';
  }
  if (!poses.empty()) lastPoses_.assign(poses.begin(), poses.end());
}

Felt Recorder::written(const Felt& felt) {
  forces_ << row_ << ',' << felt.touching << ',' << felt.sliding << ',' << textOf(felt.force_N) << ','
          << textOf(felt.ihip) << ',' << felt.triangles << ',' << textOf(felt.written_N) << ',' << textOf(felt.followed)
          << '\n';
  return felt;
}

void Recorder::begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
                     Vec3 hip) {
  writeLoad(bodies, surface_ ? surface_->spring_N_per_m : kSpring_N_per_m);
  writeMotion("load", poses, hip);
  method_->begin(bodies, poses, hip);
}

void Recorder::setSurfaceProperties(const FeltSurface& surface) {
  surface_ = surface;
  method_->setSurfaceProperties(surface);
}

void Recorder::place(Vec3 hip) {
  writeMotion("place", {}, hip);
  method_->place(hip);
}

void Recorder::edit(const EditedScene& scene, Vec3 hip) {
  writeLoad(scene.bodies, scene.spring_N_per_m);
  writeMotion("edit", scene.poses, hip);
  method_->edit(scene, hip);
}

Felt Recorder::tick(std::span<const Pose> poses, Vec3 hip) {
  writeMotion("tick", poses, hip);
  return written(method_->tick(poses, hip));
}

Felt Recorder::drive(std::span<const Pose> samples, bool haveCome, Vec3 hip) {
  writeMotion(haveCome ? "tick_with_sample" : "tick_without_sample", samples, hip);
  return written(method_->drive(samples, haveCome, hip));
}

std::vector<Dent> Recorder::dents(std::size_t body) const {
  std::vector<Dent> dents = method_->dents(body);
  if (dents.empty() || !dented_.emplace(row_, body).second) return dents;
  if (!dents_.is_open()) {
    dents_.open(folder_ / kDentsFile);
    dents_ << "row,body,centre_x_m,centre_y_m,centre_z_m,displacement_x_m,displacement_y_m,displacement_z_m\n";
  }
  for (const Dent& dent : dents)
    dents_ << row_ << ',' << body << ',' << textOf(Vec3(dent.centre)) << ',' << textOf(Vec3(dent.displacement)) << '\n';
  return dents;
}

double Recorder::highestBulge_m(std::size_t body) const {
  const double bulge_m = method_->highestBulge_m(body);
  if (bulge_m == 0) return 0;
  if (!bulges_.is_open()) {
    bulges_.open(folder_ / kBulgesFile);
    bulges_ << "row,body,highest_bulge_m\n";
  }
  bulges_ << row_ << ',' << body << ',' << exactText(bulge_m) << '\n';
  return bulge_m;
}

void Recorder::finish(const Record& about, const Record& verdict) {
  for (std::ofstream* file : {&motion_, &poses_, &forces_, &dents_, &bulges_}) {
    if (!file->is_open()) continue;
    file->close();
    if (!*file) throw std::runtime_error(folder_.string() + ": a file in it cannot be written");
  }
  Record scene{{"format", kExchangeFormat}};
  scene.update(about);
  scene.update({{"tick_s", kPeriod_s}, {"turns_mirrored_over", method_->turnsMirroredOver()}, {"loads", loads_}});
  writeRecord(folder_, "scene", scene);
  writeRecord(folder_, "verdict", verdict);
}

}  // namespace haptics::eval
