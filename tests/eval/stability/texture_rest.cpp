#include "tests/eval/stability/texture_rest.h"

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/server_step_config.h"
#include "tests/eval/textures/closed_loop.h"
#include "tests/eval/textures/texture_figures.h"

namespace haptics::eval {
namespace {

constexpr double kServo_Hz = 1000;
constexpr std::uint32_t kSeed = 1;

class IdleHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
};

StepConfig serverConfigFor(const DevicePreset& device) {
  IdleHand idle;
  const SimulatedDevice simulated({device, HandPreset{}, 1 / kServo_Hz, 0}, idle);
  StepConfig config = serverStepConfig(simulated.info(), kServo_Hz);
  config.rise_s = 0;
  return config;
}

/// The worst of several strikes.
Rest restOnExhibit(const Exhibit& exhibit, const Texture& texture, const DevicePreset& device) {
  Rest worst;
  worst.steady = true;
  for (const double strike_m_per_s : {0.01, 0.05}) {
    SurfaceProperties properties;
    properties.texture = texture;
    Feel feel;
    feel.stiffness_N_per_m = kRestStiffness_N_per_m;
    feel.config = serverConfigFor(device);
    Specimen specimen(boardSurface(), boardDetail(properties, &exhibit), feel);
    RestCase of{&device, &handPresets()[1], kServo_Hz, true};
    of.strike_m_per_s = strike_m_per_s;
    const Rest rest =
        restOn({[&](Vec3 hip) { return specimen.tick(hip).force.written; }, [&](Vec3 hip) { specimen.place(hip); }},
               exhibit, texture, of);
    if (rest.cycle_um >= worst.cycle_um) worst = rest;
  }
  return worst;
}

}  // namespace

std::vector<Record> measureTextureRest(Scope scope, const Progress& progress) {
  if (scope == Scope::kShort) return {};
  const std::vector<Exhibit> exhibits = makeExhibits(kSeed);
  std::vector<Record> records;
  for (const Exhibit& exhibit : exhibits) {
    const Texture texture = textureOf(exhibit, kReliefHeight_m, kGain);
    for (const DevicePreset& device : devicePresets()) {
      progress("textures", records.size(), exhibits.size() * devicePresets().size());
      const Rest rest = restOnExhibit(exhibit, texture, device);
      records.push_back({{"method", kOursMethod},
                         {"scene", "texture_" + exhibit.name},
                         {"device", device.name},
                         {"hand", "light"},
                         {"limit_cycle_um", rest.cycle_um},
                         {"limit_cycle_allowed_um", rest.allowed_um},
                         {"away_mm", rest.away_mm},
                         {"pass", rest.steady}});
    }
  }
  return records;
}

}  // namespace haptics::eval
