#include "tests/eval/stability/held_tool.h"

#include <memory>
#include <utility>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "haptic_server/device/simulated_device.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/servo/server_step_config.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

constexpr double kServo_Hz = 1000;
constexpr Vec3 kPlate_m{0.04, 0.03, 0.01};
constexpr double kSpacing_m = 0.05;  // corners only: the springs are judged, not the shell
const Vec3 kTilt_rad{0.02, 0.015, 0};

struct HeldPlate {
  DevicePreset device;
  HandPreset hand;
  double delay_s = 0;
  bool stabilised = true;
};

std::shared_ptr<const Tool> makePlate() {
  const TriMesh mesh = orThrow(makeBox(kPlate_m, 1));
  const auto surface = buildCollisionMesh(mesh.vertices, mesh.triangles);
  return std::make_shared<const Tool>(Tool{surface, orThrow(makeToolShell(*surface, kSpacing_m))});
}

ServoScene sceneOf(double stiffness_N_per_m, double torsion_Nm_per_rad) {
  static const std::shared_ptr<const Tool> plate = makePlate();
  static const auto sharp =
      std::make_shared<const std::vector<Vec3>>(sharpPoints(*pressedWall().surface, kSpacing_m, kMaxToolPoints));
  ServoScene scene;
  scene.revision = 1;
  ServoObject& wall = scene.objects.emplace_back();
  wall.id = 1;
  wall.surface = pressedWall().surface;
  wall.pose = pressedWall().pose;
  wall.sharp = sharp;
  ServoObject& tool = scene.objects.emplace_back();
  tool.id = 2;
  tool.surface = plate->surface;
  tool.stiffness_N_per_m = stiffness_N_per_m;
  tool.tool = plate;
  tool.torsion_Nm_per_rad = torsion_Nm_per_rad;
  return scene;
}

bool comesToRest(const HeldPlate& held, double stiffness_N_per_m, double torsion_Nm_per_rad) {
  class IdleHand final : public HandIntent {
   public:
    HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
  } idle;
  const DeviceInfo info = SimulatedDevice({held.device, held.hand, 1 / kServo_Hz, held.delay_s}, idle).info();
  StepConfig config = serverStepConfig(info, kServo_Hz, held.stabilised);
  config.rise_s = 0;
  std::vector<PressTrial> trials;
  for (const PressKind& kind : pressKinds()) {
    const Press press{held.device,  held.hand,        1 / kServo_Hz,        held.delay_s,
                      kind.force_N, kind.tap_m_per_s, rotationBy(kTilt_rad)};
    trials.push_back({press, std::make_unique<ProductionStep>(sceneOf(stiffness_N_per_m, torsion_Nm_per_rad), config)});
  }
  return allComeToRest(trials, pressedWall().place + Vec3(0, 0, kPlate_m.z / 2 + 1e-3));
}

Record recordOf(const HeldPlate& held, const char* spring, double critical, double preset) {
  return {{"method", held.stabilised ? kOursMethod : "nothing"},
          {"scene", "held_plate"},
          {"spring", spring},
          {"device", held.device.name},
          {"hand", held.hand.name},
          {"rate_Hz", kServo_Hz},
          {"delay_ms", held.delay_s * 1e3},
          {"K_crit", critical},
          {"K_crit_over_preset", critical / preset},
          {"pass", !held.stabilised || critical >= kRequiredMargin * preset}};
}

}  // namespace

std::vector<Record> measureHeldTool(Scope scope, const CaseChoice& isChosen) {
  std::vector<HeldPlate> all;
  for (const DevicePreset& device : devicePresets()) {
    if (!device.rotation.isSensed) continue;
    for (const HandPreset& hand : handPresets().first(2)) {
      for (const double delay_s : {0.0, 1 / kServo_Hz}) {
        all.push_back({device, hand, delay_s});
        if (scope != Scope::kShort) all.push_back({device, hand, delay_s, false});
      }
    }
  }
  std::vector<Record> records;
  std::size_t at = 0;
  for (const HeldPlate& held : all) {
    if (!isChosen(at++, all.size())) continue;
    const double stiffness = held.device.maxStiffness_N_per_m, torsion = held.device.rotation.maxTorsion_Nm_per_rad;
    const bool isDriven = held.device.rotation.maxTorque_Nm > 0;
    // How far beyond what is asked for is of interest only where there is time.
    const double most = scope == Scope::kShort ? 1.1 * kRequiredMargin : 20;
    const auto search = [&](double preset) {
      return StabilitySearch{.least = preset / 2, .most = most * preset, .climb = 1.3, .close = 1.05};
    };
    const double usual = isDriven ? torsion : 1;
    records.push_back(recordOf(held, "stiffness_N_per_m",
                               largestStable(search(stiffness), [&](double k) { return comesToRest(held, k, usual); }),
                               stiffness));
    if (!isDriven) continue;
    records.push_back(
        recordOf(held, "torsion_Nm_per_rad",
                 largestStable(search(torsion), [&](double k) { return comesToRest(held, stiffness, k); }), torsion));
  }
  return records;
}

}  // namespace haptics::eval
