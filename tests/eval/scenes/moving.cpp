// Bodies that move through a still HIP: S4.

#include "tests/eval/scenes/scenes.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

struct Count {
  int inside = 0;
  int undetected = 0;
  int ticks = 0;
};

Pose at(Vec3 position) { return {{1, 0, 0, 0}, position}; }

/// A flat-topped body comes up from below the HIP, `thickness` thick, until its top is `rise` metres above it.
void rise(Renderer& method, Random& random, double thickness, double speed_m_per_s, double rise, Count& count) {
  Stage stage(method, random);
  const double step = speed_m_per_s * kPeriod_s;
  double top = -0.002 - random.between(0, step);
  const int body = stage.add(shapes::box({0.04, 0.04, thickness}, 3), {0, 0, top - thickness / 2});
  const Vec3 hip{random.between(-0.015, 0.015), random.between(-0.015, 0.015), 0};
  stage.begin(hip);
  while (top + step < rise) {
    top += step;
    stage.move(body, at({0, 0, top - thickness / 2}));
    const Felt felt = stage.tick(hip);
    if (top < kInside_m) continue;
    ++count.inside;
    count.undetected += felt.touching ? 0 : 1;
  }
  count.ticks += stage.ticks();
}

void turn(Renderer& method, Random& random, double speed_rad_per_s, Count& count) {
  Stage stage(method, random);
  const int cube = stage.add(shapes::box(Vec3(0.1), 2));
  const Vec3 hip{random.between(0.052, 0.065), random.between(-0.001, 0.001), random.between(-0.04, 0.04)};
  stage.begin(hip);
  const double way = random.sign();
  for (double angle = 0; angle < 1.6; angle += speed_rad_per_s * kPeriod_s) {
    stage.move(cube, {glm::angleAxis(way * angle, Vec3(0, 0, 1)), Vec3(0)});
    const Felt felt = stage.tick(hip);
    if (stage.depthIn(cube, hip) <= kInside_m) continue;
    ++count.inside;
    count.undetected += felt.touching ? 0 : 1;
  }
  count.ticks += stage.ticks();
}

}  // namespace

SceneResult moveThroughStillHip(Renderer& method, Random& random) {
  Count box;
  Count cube;
  Count plate;
  for (const double speed_m_per_s : {0.01, 0.1, 1.0, 5.0}) rise(method, random, 0.04, speed_m_per_s, 0.03, box);
  for (const double speed_rad_per_s : {0.5, 2.0, 10.0}) turn(method, random, speed_rad_per_s, cube);
  // The HIP comes out below the plate and is still pushed.
  for (const double speed_m_per_s : {0.05, 0.3, 2.0, 3.0}) rise(method, random, 0.0005, speed_m_per_s, 0.01, plate);
  return {{{"ticks", box.ticks + cube.ticks + plate.ticks},
           {"inside_ticks", box.inside + cube.inside + plate.inside},
           {"box_undetected_ticks", box.undetected},
           {"cube_undetected_ticks", cube.undetected},
           {"plate_undetected_ticks", plate.undetected}},
          box.undetected + cube.undetected + plate.undetected == 0 && box.inside > 0 && cube.inside > 0 &&
              plate.inside > 0};
}

}  // namespace haptics::eval
