#include "tests/eval/textures/resting_figures.h"

#include "tests/eval/textures/closed_loop.h"
#include "tests/eval/textures/texture_figures.h"

namespace haptics::eval {
namespace {

/// Those that stability is judged with: a firmer hand hides what a lighter one shows.
std::span<const HandPreset> hands() { return handPresets().first(2); }

bool isLight(const HandPreset& hand) { return hand.stiffness_N_per_m > 0; }

// A stroke that stops is faster than what a hand leaves behind that lets go. Nobody would bring the device back that a
// harder strike throws over the crest.
constexpr std::array kStrikes_m_per_s{0.01, 0.025, 0.05};
std::span<const double> strikes(const HandPreset& hand) {
  return std::span(kStrikes_m_per_s).first(isLight(hand) ? kStrikes_m_per_s.size() : 1);
}

/// Of all strikes.
Rest worstRestOn(const TextureCase& textureCase, const Texture& texture, RestCase of) {
  Rest worst;
  worst.steady = true;
  for (const double strike : strikes(*of.hand)) {
    of.strike_m_per_s = strike;
    const Rest rest = restOn(textureCase, texture, of);
    if (rest.cycle_um < worst.cycle_um) continue;
    worst = rest;
  }
  return worst;
}

Record recordOf(std::string_view method, std::string scene, const RestCase& of, const Rest& rest) {
  const bool judged = method == "ours" && isLight(*of.hand);
  return {{"method", method},
          {"scene", std::move(scene)},
          {"device", of.device->name},
          {"hand", of.hand->name},
          {"rate_Hz", of.rate_Hz},
          {"lateral_stiffness_unclamped_N_per_m", rest.stiffness_N_per_m},
          {"limit_cycle_um", rest.cycle_um},
          {"limit_cycle_allowed_um", rest.allowed_um},
          {"away_mm", rest.away_mm},
          {"steady", rest.steady},
          {"pass", !judged || rest.steady}};
}

/// By each method.
void restOnRelief(const std::string& scene, const TextureCase& textureCase, double height_m, RestCase of,
                  std::vector<Record>& records) {
  Texture texture = textureOf(textureCase, height_m, kGain);
  records.push_back(recordOf("ours", scene, of, worstRestOn(textureCase, texture, of)));
  of.clamped = false;
  records.push_back(recordOf(kUnclamped, scene, of, worstRestOn(textureCase, texture, of)));
  texture.law = Texture::Law::kBump;
  records.push_back(recordOf(kBumpMapping, scene, of, worstRestOn(textureCase, texture, of)));
}

}  // namespace

std::vector<Record> measureResting(const std::vector<TextureCase>& textureCases) {
  std::vector<Record> records;
  for (const DevicePreset& device : devicePresets()) {
    for (const HandPreset& hand : hands()) {
      for (const double rate_Hz : {1e3, 4e3, 1e4}) {
        const RestCase of{&device, &hand, rate_Hz, true};
        records.push_back(recordOf("ours", "rest_plain", of, restOn(textureCases.front(), std::nullopt, of)));
        for (const TextureCase& textureCase : textureCases) {
          restOnRelief("rest_" + textureCase.name, textureCase, kReliefHeight_m, of, records);
        }
      }
    }
  }
  return records;
}

std::vector<Record> mapGratings() {
  std::vector<Record> records;
  for (const double wavelength_m : kMapWavelengths_m) {
    const TextureCase grating = makeGrating(wavelength_m);
    for (const double height_m : kMapHeights_m) {
      for (const DevicePreset& device : devicePresets()) {
        for (const HandPreset& hand : hands()) {
          const std::size_t first = records.size();
          restOnRelief("map_grating", grating, height_m, {&device, &hand, 1e3, true}, records);
          for (std::size_t i = first; i < records.size(); ++i) {
            records[i]["height_mm"] = height_m * 1e3;
            records[i]["wavelength_mm"] = wavelength_m * 1e3;
          }
        }
      }
    }
  }
  return records;
}

}  // namespace haptics::eval
