#include "tests/stress/touch_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>

#include "common/clock/monotonic.h"
#include "tests/stress/run_files.h"
#include "tests/stress/statistics.h"
#include "tests/stress/touch_scene.h"

namespace haptics::stress {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

constexpr double kComesToRest_s = 60;
constexpr double kQuiet_s = 1;    // without a contact, a dent that changes or a body awake: it rests
constexpr double kArrives_s = 5;  // then all have heard of it
constexpr int kBends = 20;
constexpr double kMaxError_mm = 1;

/// What happened, as seen beside the server.
class Witness {
 public:
  void look(const MirrorView& view) {
    if (!view.sample) return;
    const TelemetrySample& sample = *view.sample;
    if (sample.tick == last_.tick) return;
    const double step_s = 1e-9 * static_cast<double>(sample.time_ns - last_.time_ns);
    if (last_.tick != 0 && sample.object != 0) {
      speeds_m_per_s_.push_back(glm::distance(sample.hip, last_.hip) / step_s);
      ++contacts_[view.scene->find(sample.object)->name];
    }
    for (const auto& [object, body] : view.bodies) {
      const auto [at, isNew] = bodies_.try_emplace(object, body.pose.position);
      way_m_[object] += glm::distance(at->second, body.pose.position);
      at->second = body.pose.position;
    }
    last_ = sample;
  }

  /// How many vertices the dents move just now.
  void countMoved(const MirrorView& view) {
    for (const SceneVersion::Object& object : view.scene->objects()) {
      const std::vector<Dent> dents = view.dentsIn(*object);
      const auto mesh = view.meshes.find(object->mesh);
      if (dents.empty() || mesh == view.meshes.end()) continue;
      const Falloff falloff = tissueOf(*object->deformation.softness).falloff;
      moved_.push_back(static_cast<double>(
          std::ranges::count_if(mesh->second->vertices, [&](Vec3f v) { return dented(v, dents, falloff) != v; })));
    }
  }

  [[nodiscard]] Json report() {
    double way_m = 0;
    for (const auto& [object, way] : way_m_) way_m += way;
    return {{"samples_in_contact", contacts_},
            {"vertices_moved_by_dents", {{"p50", percentile(moved_, 0.5)}, {"max", percentile(moved_, 1)}}},
            {"way_of_bodies_m", way_m},
            {"hand_in_contact_m_per_s",
             {{"p50", percentile(speeds_m_per_s_, 0.5)}, {"p99", percentile(speeds_m_per_s_, 0.99)}}}};
  }

 private:
  TelemetrySample last_{};
  std::vector<double> speeds_m_per_s_, moved_;
  std::map<std::string, int> contacts_;
  std::map<ObjectId, Vec3> bodies_;
  std::map<ObjectId, double> way_m_;
};

/// Nothing moves or gives, and nothing that could is touched.
bool rests(const MirrorView& view, std::uint64_t sinceRevision) {
  if (!view.sample || view.sample->deformationRevision != sinceRevision) return false;
  const auto touched = view.scene->find(view.sample->object);
  if (touched && (touched->motion || touched->deformation.softness)) return false;
  return std::ranges::none_of(view.bodies, [](const auto& b) { return b.second.condition == BodyCondition::kAwake; });
}

void touch(Cast& cast, double seconds, Witness& witness) {
  constexpr int kCountEvery = 25;
  const std::uint64_t end_ns = monotonicNow_ns() + static_cast<std::uint64_t>(seconds * 1e9);
  for (int look = 0; monotonicNow_ns() < end_ns; ++look) {
    const auto view = cast.witness().latest();
    witness.look(*view);
    if (look % kCountEvery == 0) witness.countMoved(*view);
    cast.server().checkAlive();
    std::this_thread::sleep_for(kLook);
  }
}

/// Then a lattice is bent.
void letGo(ServerLink& link) {
  link.submit(roof(), {});
  std::uint64_t revision = 0, since_ns = 0;
  waitUntil(kComesToRest_s, "the scene comes to rest", [&] {
    const auto view = link.latest();
    const std::uint64_t now_ns = monotonicNow_ns();
    if (!rests(*view, revision) || since_ns == 0) since_ns = now_ns;
    if (view->sample) revision = view->sample->deformationRevision;
    return 1e-9 * static_cast<double>(now_ns - since_ns) > kQuiet_s;
  });
  for (int k = 1; k <= kBends; ++k) {
    link.submit(bend(0.02 * k / kBends, 0.01 * std::sin(k)), {});
    std::this_thread::sleep_for(milliseconds(50));
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(kArrives_s));
}

/// What must hold of the report.
Json judged(const Json& report) {
  const Json& server = report.at("server");
  const auto unordered = [](const Json& json) { return nlohmann::json::parse(json.dump()); };
  bool shapes = true, bodies = true, scenes = true, contacts = true, seen = true;
  for (const Json& viewer : report.at("viewers")) {
    shapes &= Json(viewer.value("client_deformed_hash", "")) == server.at("deformed_hash");
    bodies &= unordered(viewer.at("client_bodies")) == unordered(server.at("bodies"));
    scenes &= viewer.at("hashes_equal").get<bool>() && viewer.at("client_scene_hash") == server.at("scene_hash");
    for (const auto& [which, errors] : viewer.at("contacts").items()) {
      if (which == "worst") continue;
      contacts &= errors.at("p99") < kMaxError_mm;
      seen &= errors.at("frames") > 0;
    }
  }
  const Json& touched = report.at("seen_at_the_server");
  Json holds;
  holds["shapes_equal_at_the_end"] = shapes;
  holds["bodies_equal_at_the_end"] = bodies;
  holds["scenes_equal_at_the_end"] = scenes;
  holds["contact_error_p99_below_1_mm"] = contacts;
  holds["contacts_were_seen"] = seen;
  holds["bodies_were_pushed"] = touched.at("way_of_bodies_m") > 0.01;
  holds["dents_moved_5000_vertices"] = touched.at("vertices_moved_by_dents").at("max") >= 5000;
  holds["server_ended_well"] = report.at("server_ended_well");
  return holds;
}

}  // namespace

Json runTouched(RunPlan plan, const CastOptions& options) {
  const auto network = makeNetwork(plan, options.relay, options.out);
  Json report = headOf(plan, *network);
  report["viewers_count"] = options.viewers;
  Cast cast(plan, options, *network, touchedSceneText());
  cast.awaitViewers([&] { return cast.witness().latest()->hashesEqual; });
  Witness witness;
  touch(cast, plan.seconds, witness);
  letGo(cast.witness());
  report["seen_at_the_server"] = witness.report();
  report.update(cast.finish({"scene_hash", "deformed_hash", "dents", "bodies", "missed_ticks", "ticks"}));
  conclude(report, *network, judged(report));
  return report;
}

}  // namespace haptics::stress
