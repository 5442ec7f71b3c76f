// Bodies that meet, as users of other engines reported them: P7 to P9.

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/eval/scenes/put_bodies.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

using namespace put_bodies;

struct Part {
  Vec3 size_m;
  double mass_kg;
  double gap_m = 0;  ///< To what is below.
};

struct Stood {
  double moved_m = 0;  ///< From where it stands by statics, the part that moved most.
  int awake = 0;
  int notFinite = 0;
};

/// Of several stacks, by name.
struct Stacks {
  SceneResult result{nlohmann::ordered_json::object(), true};
  int awake = 0, notFinite = 0;

  void add(const char* name, const Stood& stood) {
    constexpr double kMost_m = 2e-4;
    const std::string key = std::string(name) + "_moved_um";
    result.measures[key] = std::max(result.measures.value(key, 0.0), 1e6 * stood.moved_m);
    result.measures["awake_after_5_s"] = awake += stood.awake;
    result.measures["non_finite"] = notFinite += stood.notFinite;
    result.pass = result.pass && stood.moved_m < kMost_m && stood.notFinite == 0;
  }
};

/// Parts on one another on a table, turned together, for 5 s.
Stood stand(const Renderer& method, const std::vector<Part>& parts, Random& random) {
  constexpr int kTicks = 5'000;
  Stood stood;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  addTable(*world);
  const Quat turn = glm::angleAxis(random.between(0, 6.28), Vec3(0, 0, 1));
  const Vec3 foot(random.between(-0.1, 0.1), random.between(-0.1, 0.1), 0);
  std::vector<std::uint64_t> ids;
  std::vector<Vec3> rests;
  double begun_m = 0, top_m = 0;
  for (const Part& part : parts) {
    begun_m += part.gap_m + part.size_m.z / 2;
    rests.push_back(foot + Vec3(0, 0, top_m + part.size_m.z / 2));
    ids.push_back(add(*world, boxMesh(part.size_m), part.mass_kg, {turn, foot + Vec3(0, 0, begun_m)}, kGravity));
    begun_m += part.size_m.z / 2;
    top_m += part.size_m.z;
  }
  world->publish();
  for (int i = 0; i < kTicks; ++i) world->tick(kFarAway);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Vec3 place = world->poseOf(ids[i]).position;
    stood.notFinite += isFinite(place) ? 0 : 1;
    stood.moved_m = std::max(stood.moved_m, glm::distance(place, rests[i]));
    stood.awake += world->stateOf(ids[i]).condition == BodyCondition::kAsleep ? 0 : 1;
  }
  return stood;
}

/// A weightless board above a table, or beside it: by how much it has moved after 0.4 s, m.
double hovered_m(const Renderer& method, double gap_m, bool beside, double table_m, Random& random) {
  constexpr int kTicks = 400;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  const Vec3 board_m(0.1, 0.1, 0.01);
  const Quat all = random.rotation();
  const Vec3 begun =
      all * (beside ? Vec3(0.25 + gap_m + board_m.x / 2, 0, 0) : Vec3(0, 0, table_m / 2 + gap_m + board_m.z / 2));
  add(*world, boxMesh({0.5, 0.5, table_m}), 0, {all, Vec3(0)}, Vec3(0));
  const std::uint64_t board = add(*world, boxMesh(board_m), 0.2, {all, begun}, Vec3(0));
  world->publish();
  for (int i = 0; i < kTicks; ++i) world->tick(kFarAway);
  return glm::distance(world->poseOf(board).position, begun);
}

struct Ground {
  std::vector<std::pair<TriMesh, Vec3>> parts;
  double from_m;  ///< x at which the slab begins.
  int ticks;
};

/// Side by side, tops at z = 0.
Ground tiles(double gap_m) {
  Ground ground{{}, -0.1, 700};
  const Vec3 size_m(0.0625, 0.125, 0.03125);
  for (int i = 0; i < 5; ++i)
    ground.parts.emplace_back(boxMesh(size_m), Vec3((i - 2) * (size_m.x + gap_m), 0, -size_m.z / 2));
  return ground;
}

Ground one(int segments) {
  const Vec3 size_m(0.1, 0.1, 0.005);
  return {{{makeBox(size_m, segments).value(), Vec3(0, 0, -size_m.z / 2)}}, -0.035, 500};
}

/// How far from Newton's law (m) a slab without friction has come that is drawn along by 0.5 m/s^2.
double behind_m(const Renderer& method, const Ground& ground, Random& random) {
  constexpr double kPull_m_per_s2 = 0.5;
  const std::unique_ptr<BodyWorld> world = method.makeBodyWorld();
  for (const auto& [mesh, place] : ground.parts) add(*world, mesh, 0, at(place), Vec3(0), true);
  const Vec3 begun(ground.from_m, random.between(-0.005, 0.005), 0.01);
  const std::uint64_t slab =
      add(*world, boxMesh(Vec3(0.02)), 0.05, at(begun), kGravity + Vec3(kPull_m_per_s2, 0, 0), true);
  world->publish();
  for (int i = 0; i < ground.ticks; ++i) world->tick(kFarAway);
  const double time_s = ground.ticks * kPeriod_s;
  return glm::distance(world->poseOf(slab).position, begun + Vec3(kPull_m_per_s2 / 2 * time_s * time_s, 0, 0));
}

}  // namespace

/// Stacks stand where they were put: bricks, tall ones, what is heavy on what is light, thin plates.
SceneResult standAsReported(Renderer& method, Random& random) {
  Stacks stacks;
  const auto alike = [&](const char* name, int count, Part part) {
    stacks.add(name, stand(method, std::vector<Part>(static_cast<std::size_t>(count), part), random));
  };
  alike("bricks_3", 3, {{0.03, 0.03, 0.03}, 0.1});
  alike("bricks_10", 10, {{0.03, 0.03, 0.02}, 0.1});
  alike("tall_3", 3, {{0.005, 0.005, 0.06}, 0.02});
  alike("thin_2", 2, {{0.08, 0.05, 0.001}, 0.02});
  alike("thin_6", 6, {{0.08, 0.05, 0.003}, 0.06});
  for (const double ratio : {10.0, 30.0, 100.0, 300.0})
    stacks.add("heavy_on_light", stand(method, {{Vec3(0.03), 0.05}, {Vec3(0.03), 0.05 * ratio}}, random));
  return stacks.result;
}

/// A board lies on a block narrower than itself, and what is weightless stays where it was put.
SceneResult putBoardsAsReported(Renderer& method, Random& random) {
  Stacks stacks;
  for (const double side_m : {0.032, 0.05, 0.1, 0.2}) {
    for (const double gap_m : {0.0, 0.001})
      stacks.add("board", stand(method, {{Vec3(0.03), 0.2}, {{side_m, side_m, 0.01}, 0.2, gap_m}}, random));
  }
  for (const double thickness_m : {0.002, 0.02, 0.03})
    stacks.add("board", stand(method, {{Vec3(0.03), 0.2}, {{0.1, 0.1, thickness_m}, 0.2}}, random));
  double hovering_m = 0;
  for (const double gap_m : {0.001, 0.01, 0.03, 0.05}) {
    for (const bool beside : {false, true})
      hovering_m = std::max(hovering_m, hovered_m(method, gap_m, beside, beside ? 0.1 : 0.02, random));
  }
  hovering_m = std::max(hovering_m, hovered_m(method, 0.003, false, 0.003, random));
  SceneResult result = stacks.result;
  result.measures["hovering_moved_um"] = 1e6 * hovering_m;
  result.pass = result.pass && hovering_m < 1e-9;
  return result;
}

/// Seams and triangles of a flat ground are not felt by what slides over it.
SceneResult slideAsReported(Renderer& method, Random& random) {
  double off_m = 0;
  for (const double gap_m : {0.0, 1e-6}) off_m = std::max(off_m, behind_m(method, tiles(gap_m), random));
  SceneResult result{{{"behind_on_tiles_um", 1e6 * off_m}}, false};
  for (const int segments : {1, 5, 10, 20, 40}) off_m = std::max(off_m, behind_m(method, one(segments), random));
  result.measures["behind_um"] = 1e6 * off_m;
  result.pass = off_m < 3e-4;
  return result;
}

}  // namespace haptics::eval
