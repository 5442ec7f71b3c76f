#include "tests/eval/advise/candidate.h"

#include <algorithm>

#include "common/mesh/decimation.h"
#include "common/mesh/import.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/simplification/fit.h"
#include "tests/eval/advise/felt_forces.h"
#include "tests/eval/advise/ply_file.h"
#include "tests/eval/timing.h"

namespace haptics::eval {
namespace {

constexpr double kJudged_Hz = 1000;  // as the strokes are sampled

/// The contact core over the scene, one object's surface exchanged.
class SceneContact {
 public:
  SceneContact(const std::vector<LoadedObject>& scene, std::size_t object, const CollisionMesh& surface)
      : scene_(scene), bodies_(scene.size()) {
    for (std::size_t i = 0; i < scene.size(); ++i) {
      bodies_[i].surface = i == object ? &surface : scene[i].surface.get();
      bodies_[i].previous = bodies_[i].current = scene[i].pose;
      bodies_[i].update();
    }
  }
  void place(Vec3 hip) { haptics::resetContact(state_, hip); }
  /// The spring's force, N.
  Vec3 tick(Vec3 hip) {
    const ContactResult contact = followContact(bodies_, state_, hip, cache_);
    if (!contact.touching) return Vec3(0);
    return scene_[static_cast<std::size_t>(contact.body)].material.stiffness_N_per_m * (contact.ihip - hip);
  }

 private:
  const std::vector<LoadedObject>& scene_;
  std::vector<Body> bodies_;
  ContactState state_;
  ContactCache cache_;
};

/// The stroke to and fro, as often as `ticks` takes.
std::vector<Vec3> toAndFro(const std::vector<Vec3>& stroke, std::size_t ticks) {
  std::vector<Vec3> places;
  while (places.size() < ticks) {
    places.insert(places.end(), stroke.begin(), stroke.end());
    places.insert(places.end(), stroke.rbegin(), stroke.rend());
  }
  return places;
}

void price(SceneContact contact, const HandStroke& hand, Candidate& candidate) {
  constexpr std::size_t kBatch = 16;  // a single tick is no longer than reading the clock
  constexpr std::size_t kHotTicks = 4096;
  constexpr std::size_t kColdTicks = 5;
  contact.place(hand.down.front());
  for (const Vec3 hip : hand.down) (void)contact.tick(hip);
  Stopwatch hot;
  const std::vector<Vec3> places = toAndFro(hand.stroke, kHotTicks);
  for (std::size_t i = 0; i + kBatch <= places.size(); i += kBatch) {
    hot.time([&] {
      for (std::size_t k = i; k < i + kBatch; ++k) (void)contact.tick(places[k]);
    });
  }
  candidate.hot_ns = hot.durations_ns().quantile(0.5) / kBatch;
  Stopwatch cold;
  const std::size_t apart = std::max<std::size_t>(1, hand.stroke.size() / kColdTicks);
  for (std::size_t i = 0; i < hand.stroke.size(); ++i) {
    if (i % apart != 0) {
      (void)contact.tick(hand.stroke[i]);
      continue;
    }
    sweepCaches();
    cold.time([&] { (void)contact.tick(hand.stroke[i]); });
  }
  candidate.cold_ns = cold.durations_ns().quantile(0.5);
}

double longestSide(const CollisionMesh& surface) {
  const Vec3 size = surface.high() - surface.low();
  return std::max({size.x, size.y, size.z});
}

}  // namespace

std::vector<Candidate> candidatesFor(const std::vector<LoadedObject>& scene, std::size_t object,
                                     const std::vector<HandStroke>& strokes, double tolerance) {
  const LoadedObject& own = scene[object];
  ServoScene felt = servoSceneOf(scene);
  const std::vector<Forces> truth = forcesIn(felt, strokes, kJudged_Hz);

  std::vector<Candidate> candidates;
  const auto judge = [&](std::shared_ptr<const TriMesh> mesh, std::shared_ptr<const CollisionMesh> surface) {
    Candidate candidate;
    candidate.mesh = std::move(mesh);
    candidate.surface = std::move(surface);
    candidate.triangles = candidate.surface->triangleCount();
    candidate.memory_MB = static_cast<double>(candidate.surface->memory_bytes()) * 1e-6;
    candidate.opened = own.surface->closed() && !candidate.surface->closed();
    const double deviation_m = deviationOf(own.mesh->vertices, *candidate.surface);
    candidate.deviation_mm = deviation_m * 1e3;
    candidate.strayed = deviation_m > tolerance * longestSide(*own.surface);
    candidate.exact = deviation_m <= Decimation::kExact_of_longest * longestSide(*own.surface);
    felt.objects[object].surface = candidate.surface;
    felt.objects[object].detail = shadingOf(own.material, *candidate.surface);
    candidate.difference = differenceOf(forcesIn(felt, strokes, kJudged_Hz), truth);
    price({scene, object, *candidate.surface}, strokes.front(), candidate);
    candidates.push_back(std::move(candidate));
  };
  const auto judgeCopy = [&](const TriMesh& copy) {
    // As import takes it from its file: what is judged is what a server gets.
    auto imported = importMesh(plyOf(copy), MeshFormat::kPly, {});
    if (!imported || imported->mesh.triangles.size() >= candidates.back().triangles) return;
    auto mesh = std::make_shared<const TriMesh>(std::move(imported->mesh));
    auto surface = buildCollisionMesh(mesh->vertices, mesh->triangles);
    judge(std::move(mesh), std::move(surface));
  };
  judge(own.mesh, own.surface);
  const Decimation decimation(*own.mesh);
  judgeCopy(decimation.copyOf(decimation.exact()));
  if (!candidates.back().exact || !candidates.back().good()) candidates.resize(1);
  constexpr double kStep = 0.7071;  // two steps are a half
  constexpr double kFewest = 4;
  for (double wanted = kStep * static_cast<double>(candidates.back().triangles); wanted >= kFewest; wanted *= kStep) {
    judgeCopy(fitted(decimation.copyOf(static_cast<std::size_t>(wanted)), own.mesh->vertices));
    const std::size_t count = candidates.size();
    if (count > 2 && !candidates[count - 1].good() && !candidates[count - 2].good()) break;
  }
  return candidates;
}

}  // namespace haptics::eval
