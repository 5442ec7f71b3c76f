// A box inside out, which is a room, and a hollow within a box: P3.

#include <algorithm>
#include <cmath>

#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kRightTo_m = 1e-6;

shapes::Shape insideOut(shapes::Shape shape) {
  for (auto& triangle : shape.triangles) std::swap(triangle[1], triangle[2]);
  return shape;
}

struct Rooms {
  int ticks = 0;
  int wrong = 0;
  double worst_m = 0;

  /// @param off_m  How far the HIP is beyond the wall that it is most beyond; negative: from the nearest one.
  void see(const Felt& felt, double off_m, Vec3 place) {
    const double error_m = glm::distance(felt.ihip, place);
    const bool touchesRightly = felt.touching == (off_m > 0) || std::abs(off_m) < kRightTo_m;
    ++ticks;
    worst_m = std::max(worst_m, error_m);
    wrong += isFinite(felt.ihip) && error_m < kRightTo_m && touchesRightly ? 0 : 1;
  }
};

/// A hand within four walls, floor and ceiling: each of its coordinates is held by itself.
void stayWithin(Stage& stage, Vec3 half_m, Random& random, Rooms& rooms) {
  constexpr double kStep_m = 3e-4, kBeyond_m = 0.003;
  Vec3 at(0);
  stage.place(at);
  for (int i = 0; i < 20; ++i) {
    Vec3 to;
    for (int k = 0; k < 3; ++k) to[k] = random.between(-1, 1) * (half_m[k] + kBeyond_m);
    to[random.below(3)] = random.below(2) == 0 ? -half_m.x - kBeyond_m : half_m.x + kBeyond_m;
    stage.lead(at, to, kStep_m, [&](const Felt& felt, Vec3 hip) {
      const Vec3 off_m = glm::abs(hip) - half_m;
      rooms.see(felt, std::max({off_m.x, off_m.y, off_m.z}), glm::clamp(hip, -half_m, half_m));
    });
    at = to;
  }
}

/// Pressed on each side of a box from outside and led over it, nowhere near its edges.
void strokeOutside(Stage& stage, double half_m, Random& random, Rooms& rooms) {
  constexpr double kStep_m = 3e-4;
  for (int k = 0; k < 3; ++k) {
    for (const double side : {-1.0, 1.0}) {
      const auto somewhere = [&](double height_m) {
        Vec3 place;
        for (int other = 0; other < 3; ++other) place[other] = random.between(-0.6, 0.6) * half_m;
        place[k] = side * (half_m + height_m);
        return place;
      };
      const auto check = [&](const Felt& felt, Vec3 hip) {
        const double off_m = half_m - side * hip[k];
        Vec3 place = hip;
        if (off_m > 0) place[k] = side * half_m;
        rooms.see(felt, off_m, place);
      };
      const Vec3 above = somewhere(0.005), below = somewhere(-0.002), aside = somewhere(-0.001);
      stage.place(above);
      stage.lead(above, below, kStep_m, check);
      stage.lead(below, aside, kStep_m, check);
    }
  }
}

}  // namespace

/// A mesh whose faces look inwards is felt from within alone, and a hollow is felt from within it as its body is from
/// outside: neither is to be turned over.
SceneResult feelRoomsAndHollows(Renderer& method, Random& random) {
  Rooms rooms;
  const double half_m = 0.0625;  // as a float has it
  for (const int n : {1, 3}) {
    Stage room(method, random);
    room.add(insideOut(shapes::box(Vec3(2 * half_m), n)));
    room.begin(Vec3(0));
    stayWithin(room, Vec3(half_m), random, rooms);

    shapes::Shape hollow = shapes::box(Vec3(4 * half_m), n);
    hollow.add(insideOut(shapes::box(Vec3(2 * half_m), n)));
    Stage body(method, random);
    body.add(hollow);
    body.begin(Vec3(0, 0, 3 * half_m));
    strokeOutside(body, 2 * half_m, random, rooms);
    stayWithin(body, Vec3(half_m), random, rooms);
  }
  return {{{"ticks", rooms.ticks}, {"wrong_ticks", rooms.wrong}, {"off_max_um", 1e6 * rooms.worst_m}},
          rooms.wrong == 0};
}

}  // namespace haptics::eval
