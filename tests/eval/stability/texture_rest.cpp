#include "tests/eval/stability/texture_rest.h"

#include "tests/eval/textures/closed_loop.h"
#include "tests/eval/textures/texture_figures.h"

namespace haptics::eval {
namespace {

constexpr double kServo_Hz = 1000;
constexpr std::uint32_t kSeed = 1;

/// The worst of several strikes.
Rest restOnTextureCase(const TextureCase& textureCase, const Texture& texture, const DevicePreset& device) {
  Rest worst;
  worst.steady = true;
  for (const double strike_m_per_s : {0.01, 0.05}) {
    RestCase of{&device, &handPresets()[1], kServo_Hz, true};
    of.strike_m_per_s = strike_m_per_s;
    const Rest rest = restOn(textureCase, texture, of);
    if (rest.cycle_um >= worst.cycle_um) worst = rest;
  }
  return worst;
}

}  // namespace

std::vector<Record> measureTextureRest(Scope scope, const CaseChoice& isChosen) {
  if (scope == Scope::kShort) return {};
  const std::vector<TextureCase> textureCases = makeTextureCases(kSeed);
  std::vector<Record> records;
  std::size_t at = 0;
  for (const TextureCase& textureCase : textureCases) {
    const Texture texture = textureOf(textureCase, kReliefHeight_m, kGain);
    for (const DevicePreset& device : devicePresets()) {
      if (!isChosen(at++, textureCases.size() * devicePresets().size())) continue;
      const Rest rest = restOnTextureCase(textureCase, texture, device);
      records.push_back({{"method", kOursMethod},
                         {"scene", "texture_" + textureCase.name},
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
