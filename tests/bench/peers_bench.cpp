#include <cmath>
#include <string>

#include "tests/bench/benches.h"
#include "tests/bench/peers/god_object.h"
#include "tests/bench/peers/peers.h"
#include "tests/bench/scenes.h"

namespace haptics::bench {
namespace {

/// CGAL's tree of doubles would take 3 GB, and a minute to build, for a mesh of more.
constexpr std::uint32_t kMaxForCgal = 2'000'000;  // triangles

template <class Answer>
double meanOf(std::size_t count, Answer answer) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += answer(i);
  return sum / static_cast<double>(count);
}

void add(Contestants& all, Contestants more) { all.insert(all.end(), more.begin(), more.end()); }

/// In contact: where is the closest point of the surface? Ours is the whole tick, force's point, normal and primitive
/// included; beside it the search alone, which is what the peers' queries answer.
Course holdContact(const Trajectory& trajectory, std::uint32_t segments) {
  const auto replay = std::make_shared<Replay>(trajectory.make(segments));
  const auto search = std::make_shared<Search>(trajectory.make(segments));
  const std::span<const Vec3> path = replay->scene().path;
  const auto god = std::make_shared<GodObject>(*sphere(segments), replay->scene().approach.front());
  for (const Vec3 hip : replay->scene().approach) god->tick(hip);

  Course course;
  course.questions = path.size();
  // A facet more or less is a local minimum of its own; a god-object follows a tick behind across an edge.
  course.tolerance = 0.02;
  course.contestants = {
      {"tick", [=] { return meanOf(path.size(), [&](std::size_t) { return replay->tick().penetration_m; }); }},
      {"search", [=] { return meanOf(path.size(), [&](std::size_t) { return search->tick(); }); }},
      {"god_object",
       [=] { return meanOf(path.size(), [&](std::size_t i) { return glm::distance(god->tick(path[i]), path[i]); }); }}};
  const TriMesh mesh = sphereMesh(segments);
  add(course.contestants, Embree(mesh).closest(path));
  if (triangleCount(segments) <= kMaxForCgal) add(course.contestants, Cgal(mesh).closest(path));
  return course;
}

/// Free: does anything lie on the HIP's way? Ours is the segment test alone, and the whole tick.
Course passFree(std::uint32_t segments) {
  const auto replay = std::make_shared<Replay>(freeSpace(segments));
  const std::vector<Vec3>& path = replay->scene().path;
  const auto ways = std::make_shared<std::vector<Way>>();
  for (std::size_t i = 0; i < path.size(); ++i) ways->push_back({path[i], path[(i + 1) % path.size()]});

  Course course;
  course.questions = path.size();
  const auto answer = [surface = sphere(segments), ways](std::size_t i) {
    return surface->firstCrossing((*ways)[i].from, (*ways)[i].to) ? 1.0 : 0.0;
  };
  course.contestants = {
      {"segment", [=] { return meanOf(ways->size(), answer); }},
      {"tick", [=] { return meanOf(ways->size(), [&](std::size_t) { return replay->tick().touching ? 1.0 : 0.0; }); }}};
  for (Contestant& peer : Embree(sphereMesh(segments)).occluded(*ways)) {
    course.contestants.push_back({peer.name, [ways, lap = peer.lap] { return lap(); }});
  }
  return course;
}

/// First contact: which triangle does the HIP's way enter first, and where? Ways of a tick each, that end as far below
/// the surface as they begin above.
Course firstContact(std::uint32_t segments) {
  const auto ways = std::make_shared<std::vector<Way>>();
  for (const Vec3 place : freeSpace(segments).path) {
    const Vec3 up = glm::normalize(place);
    const Vec3 surface = up * kRadius_m;
    const Crossing met = sphere(segments)->firstCrossing(up * (1.1 * kRadius_m), Vec3(0));
    const Vec3 at = met ? glm::mix(up * (1.1 * kRadius_m), Vec3(0), met.time) : surface;
    ways->push_back({at + up * (kStep_m / 2), at - up * (kStep_m / 2)});
  }
  Course course;
  course.questions = ways->size();
  course.tolerance = 1e-2;  // of floats: 3e-9 m in a way of 1e-4 m
  const auto answer = [surface = sphere(segments), ways](std::size_t i) {
    return surface->firstCrossing((*ways)[i].from, (*ways)[i].to).time;
  };
  course.contestants = {{"segment", [=] { return meanOf(ways->size(), answer); }}};
  for (Contestant& peer : Embree(sphereMesh(segments)).first(*ways)) {
    course.contestants.push_back({peer.name, [ways, lap = peer.lap] { return lap(); }});
  }
  return course;
}

}  // namespace

void registerPeers(std::span<const std::uint32_t> sizes) {
  for (const std::uint32_t n : sizes) {
    const std::string size = "/triangles:" + std::to_string(triangleCount(n));
    for (const Trajectory& t : {kRubbing, kSlide}) {
      registerContest(std::string("peers/contact/") + t.name + size, [t, n] { return holdContact(t, n); });
    }
    registerContest("peers/free_segment/" + std::string(kFreeSpace.name) + size, [n] { return passFree(n); });
    registerContest("peers/first_contact/0.1mm_segments" + size, [n] { return firstContact(n); });
  }
}

}  // namespace haptics::bench
