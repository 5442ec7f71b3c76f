#include "tests/eval/textures/sheet.h"

#include <cmath>

#include "haptic_server/device/presets.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/spectrum.h"
#include "tests/eval/textures/resting_figures.h"
#include "tests/eval/textures/traces.h"

namespace haptics::eval {
namespace {

/// Rows from the lowest y on, over 16 mm.
Record heightsOf(const TextureCase& textureCase) {
  constexpr int kSide = 152;
  constexpr double kShown_m = 0.016;
  Record rows;
  for (int j = 0; j < kSide; ++j) {
    std::vector<double> row;
    for (int i = 0; i < kSide; ++i)
      row.push_back(textureCase.field->at(kShown_m * Vec3((i + 0.5) / kSide - 0.5, (j + 0.5) / kSide - 0.5, 0)).value);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The stroke's middle, over mm.
Trace forceOf(const std::vector<double>& force_N) {
  constexpr double kShown_m = 0.012;
  Trace points;
  for (std::size_t i = 0; i < force_N.size(); i += 2) {
    const double x_m = kStroke_m * (static_cast<double>(i) / static_cast<double>(force_N.size()) - 0.5);
    if (std::abs(x_m) <= kShown_m / 2) points.emplace_back(x_m * 1e3, force_N[i]);
  }
  return points;
}

/// um over waves per mm.
Trace spectrumOf(const std::vector<double>& height_m) {
  constexpr double kMax_per_mm = 1.5;
  const std::vector<double> spectrum = powerSpectrum(height_m);
  Trace points;
  for (std::size_t i = 1; i < spectrum.size(); ++i) {
    const double per_mm = static_cast<double>(i) / (kStroke_m * 1e3);
    if (per_mm > kMax_per_mm) break;
    points.emplace_back(per_mm, std::sqrt(2 * spectrum[i]) * 1e6);
  }
  return points;
}

Record cardOf(const TextureCase& textureCase, const TextureFigures& figures) {
  const StrokeSignals& stroke = figures.stroke;
  std::vector<double> felt_m;
  for (const double force_N : stroke.normalForce_N) felt_m.push_back(force_N / Feel{}.stiffness_N_per_m);
  return {{"name", textureCase.name},
          {"title", textureCase.title},
          {"record", figures.record},
          {"heights", heightsOf(textureCase)},
          {"into", forceOf(stroke.normalForce_N)},
          {"along", forceOf(stroke.lateralForce_N)},
          {"reference", spectrumOf(stroke.reference_m)},
          {"felt", spectrumOf(felt_m)}};
}

/// In the unit of the records.
template <std::size_t kCount>
std::vector<double> inMillimetres(const std::array<double, kCount>& lengths_m) {
  std::vector<double> lengths_mm;
  for (const double length_m : lengths_m) lengths_mm.push_back(length_m * 1e3);
  return lengths_mm;
}

}  // namespace

void drawSheet(const TexturesData& data, std::uint64_t seed, const std::filesystem::path& stem) {
  Record cards, devices;
  for (std::size_t i = 0; i < data.textureCases.size(); ++i)
    cards.push_back(cardOf(data.textureCases[i], data.figures[i]));
  for (const DevicePreset& device : devicePresets())
    devices.push_back({{"name", device.name}, {"title", device.title}});
  const FrictionTraces friction = traceFriction(static_cast<std::uint32_t>(seed));
  const ShadingTraces shading = traceShading();
  drawFigure("textures",
             {{"cards", std::move(cards)},
              {"devices", std::move(devices)},
              {"wrapped", data.wrapped},
              {"resting", data.resting},
              {"map", data.map},
              {"wavelengths_mm", inMillimetres(kMapWavelengths_m)},
              {"heights_mm", inMillimetres(kMapHeights_m)},
              {"traces",
               {{"to_and_fro", friction.toAndFro},
                {"periodic", friction.periodic},
                {"fine", friction.fine},
                {"coarse", friction.coarse},
                {"unshaded", shading.unshaded},
                {"shaded", shading.shaded}}}},
             stem);
}

}  // namespace haptics::eval
