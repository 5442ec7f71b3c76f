// The smallest haptic program: a sphere, a hand that moves into it, and the force on that hand at 1 kHz, in virtual time.
#include <cstdint>
#include <cstdio>
#include <memory>

#include "common/mesh/generators.h"
#include "haptic_server/engine/step/haptic_step.h"

using namespace haptics;

int main() {
  // A mesh: a sphere of radius 50 mm in 12 * 32^2 triangles, centred at the origin. Lengths are metres.
  const Result<TriMesh> mesh = makeSphere(0.05, 32);
  if (!mesh) {
    std::fprintf(stderr, "hello_haptics: %s\n", mesh.error().text().c_str());
    return 1;
  }

  // A scene of one object. It does not change once it is adopted: an edit is another scene with a higher revision.
  ServoScene scene;
  scene.revision = 1;
  ServoObject& sphere = scene.objects.emplace_back();
  sphere.id = 1;
  sphere.surface = buildCollisionMesh(mesh->vertices, mesh->triangles);
  sphere.stiffness_N_per_m = 500;
  sphere.damping_Ns_per_m = 0.5;

  // What the step remembers from tick to tick. It is large, so not on the stack.
  const StepConfig config;  // a tick is 1 ms, the force at most 3.3 N
  const auto state = std::make_unique<HapticState>(config);
  if (!adoptScene(scene, *state, 0)) return 1;  // only a contact that is still held can delay it

  // The hand comes down from 55 mm above the centre at 20 mm/s for 0.5 s, then rests. A device would give its position.
  for (std::uint64_t tick = 0; tick <= 1000; ++tick) {
    const double moved_s = static_cast<double>(tick < 500 ? tick : 500) * config.period_s;
    StepInput input;
    input.tick = tick;
    input.device.position = {0, 0, 0.055 - 0.02 * moved_s};
    input.device.state = DeviceState::kReady;

    const TelemetrySample sample = hapticStep(scene, *state, config, input);

    const Vec3 force_N = sample.force.written;  // what a device would be sent
    if (tick % 100 == 0) {
      std::printf("t = %.1f s: hand at z = %.1f mm, depth %.2f mm, force (%.2f, %.2f, %.2f) N\n",
                  static_cast<double>(tick) * config.period_s, input.device.position.z * 1e3,
                  sample.penetration_m * 1e3, force_N.x, force_N.y, force_N.z);
    }
  }
}
