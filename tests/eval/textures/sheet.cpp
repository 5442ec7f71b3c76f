#include "tests/eval/textures/sheet.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/device/presets.h"
#include "tests/eval/figure/contact_sheet.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/spectrum.h"
#include "tests/eval/textures/resting_figures.h"
#include "tests/eval/textures/traces.h"

namespace haptics::eval {
namespace {

// Okabe and Ito's colours, which colour-blind people tell apart.
constexpr Colour kBlue{0.0, 0.447, 0.698}, kOrange{0.902, 0.494, 0.0}, kGreen{0.0, 0.62, 0.451}, kRed{0.80, 0.24, 0.20},
    kGrey{0.62, 0.65, 0.69}, kYellow{0.95, 0.78, 0.25};

std::string text(const char* format, double a, double b = 0) {
  char words[200];
  std::snprintf(words, sizeof words, format, a, b);
  return words;
}

double number(const Record& record, const char* key) { return record.at(key).get<double>(); }

/// Light from the upper left on the relief, its colour by height, both over what is shown.
Raster reliefOf(const TextureCase& textureCase) {
  constexpr int kSide = 152;
  constexpr int kShades = 24;  // of each colour: a small file
  constexpr double kShown_m = 0.016;
  constexpr double kSteepness_m = 0.8e-3;  // height of what is lit
  const Vec3 light = glm::normalize(Vec3(-0.55, 0.6, 1.0));
  std::vector<FieldSample> samples;
  double low = textureCase.field->highest();
  double high = textureCase.field->lowest();
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      samples.push_back(textureCase.field->at(kShown_m * Vec3((i + 0.5) / kSide - 0.5, (j + 0.5) / kSide - 0.5, 0)));
      low = std::min(low, samples.back().value);
      high = std::max(high, samples.back().value);
    }
  }
  Raster picture{kSide, kSide, {}};
  for (const FieldSample& sample : samples) {
    const Vec3 slope = sample.gradient * (kSteepness_m / (high - low));
    const double lit = std::max(0.0, glm::dot(glm::normalize(Vec3(-slope.x, -slope.y, 1)), light));
    const Vec3 ground = glm::mix(Vec3(0.16, 0.30, 0.48), Vec3(0.98, 0.93, 0.82), (sample.value - low) / (high - low));
    const Vec3 shown = glm::clamp(ground * (0.25 + 0.95 * lit), 0.0, 1.0);
    for (int channel = 0; channel < 3; ++channel) {
      picture.rgb.push_back(static_cast<std::uint8_t>(std::lround(kShades * shown[channel]) * 255 / kShades));
    }
  }
  return picture;
}

/// The stroke's middle.
SheetPlot forcePlot(const StrokeSignals& stroke) {
  constexpr double kShown_m = 0.012;
  SheetPlot plot{"force, N", "mm along the stroke", {{"into", kBlue, {}, 2}, {"along", kOrange, {}, 1.6}}, false};
  const std::size_t count = stroke.normalForce_N.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double x_m = kStroke_m * (static_cast<double>(i) / static_cast<double>(count) - 0.5);
    if (std::abs(x_m) > kShown_m / 2 || i % 2 != 0) continue;
    plot.curves[0].points.emplace_back(x_m * 1e3, stroke.normalForce_N[i]);
    plot.curves[1].points.emplace_back(x_m * 1e3, stroke.lateralForce_N[i]);
  }
  return plot;
}

/// Of the normal force, and of the reference evaluation of the field.
SheetPlot spectrumPlot(const StrokeSignals& stroke, double stiffness_N_per_m) {
  constexpr double kMax_per_mm = 1.5;
  SheetPlot plot{"height, um", "waves per mm", {{"reference", kYellow, {}, 5}, {"felt", kBlue, {}, 1.6}}, true};
  std::vector<double> felt_m;
  for (const double force_N : stroke.normalForce_N) felt_m.push_back(force_N / stiffness_N_per_m);
  const std::vector<double> spectra[] = {powerSpectrum(stroke.reference_m), powerSpectrum(felt_m)};
  for (std::size_t curve = 0; curve < 2; ++curve) {
    for (std::size_t i = 1; i < spectra[curve].size(); ++i) {
      const double per_mm = static_cast<double>(i) / (kStroke_m * 1e3);
      if (per_mm > kMax_per_mm) break;
      plot.curves[curve].points.emplace_back(per_mm, std::sqrt(2 * spectra[curve][i]) * 1e6);
    }
  }
  return plot;
}

/// On how many devices the light hand rests at 1 kHz.
int restsOn(const TexturesData& data, const std::string& name, std::string_view method) {
  return static_cast<int>(std::ranges::count_if(data.resting, [&](const Record& r) {
    return r["scene"] == "rest_" + name && r["hand"] == "light" && r["method"] == method &&
           number(r, "rate_Hz") == 1e3 && r["steady"].get<bool>();
  }));
}

SheetCard cardOf(const TexturesData& data, std::size_t i) {
  const TextureCase& textureCase = data.textureCases[i];
  const Record& r = data.figures[i].record;
  const StrokeSignals& stroke = data.figures[i].stroke;
  SheetCard card{textureCase.title, r["pass"].get<bool>(), reliefOf(textureCase), "16 mm", {}, {}};
  card.plots = {forcePlot(stroke), spectrumPlot(stroke, Feel{}.stiffness_N_per_m)};
  card.verdict = {text("gradient within %.0e", number(r, "gradient_error_ratio")),
                  text("C1: jumps below %.0e", number(r, "gradient_jump_ratio"))};
  if (textureCase.wavelength_m > 0) {
    card.verdict.push_back(
        text("wavelength felt %.3f mm, set %.0f", number(r, "wavelength_of_force_mm"), number(r, "wavelength_set_mm")));
  } else {
    card.verdict.push_back(text("spectrum within %.0e", number(r, "force_spectrum_difference_ratio")));
  }
  card.verdict.push_back(
      text("loop %.4f mJ, derived %.4f", number(r, "loop_up_work_mJ"), number(r, "loop_up_derived_mJ")));
  card.verdict.push_back(text("side %.0f N/m, derived %.0f", number(r, "lateral_stiffness_max_N_per_m"),
                              number(r, "lateral_stiffness_derived_max_N_per_m")));
  card.verdict.push_back(text("buzz at 1 kHz %.1f mN rms", 1e3 * number(r, "false_force_above_100Hz_at_1kHz_rms_N")));
  const auto devices = static_cast<double>(devicePresets().size());
  card.verdict.push_back(text("rests on %.0f of %.0f devices;", restsOn(data, textureCase.name, "ours"), devices));
  card.verdict.push_back(text("by bump mapping on %.0f", restsOn(data, textureCase.name, kBumpMapping)));
  return card;
}

std::string wrappedText(const std::vector<Record>& wrapped) {
  double gradient = 0;
  double jump = 0;
  for (const Record& r : wrapped) {
    gradient = std::max(gradient, number(r, "gradient_error_ratio"));
    jump = std::max(jump, number(r, "gradient_jump_ratio"));
  }
  return text(
      "The last four wrapped round cube, cylinder and sphere, seams, poles and edges included: gradient within %.0e, "
      "jumps below %.0e.",
      gradient, jump);
}

/// A method that rings, those that ring less first.
Colour colourOf(bool ours, bool unclamped, bool bumpMapping) {
  if (!ours) return kRed;
  if (!unclamped) return kOrange;
  return bumpMapping ? kGreen : kYellow;
}

/// Per device what the light hand meets.
SheetGrids gridsOf(const TexturesData& data) {
  SheetGrids grids;
  grids.title = "A grating under a device and the light hand at 1 kHz: does it rest?";
  grids.key = {{kGreen, "rests by every method"},
               {kYellow, "rings by bump mapping"},
               {kOrange, "rings by Eq. (4) where K is not clamped"},
               {kRed, "rings"}};
  for (const double wavelength_m : kMapWavelengths_m) grids.columnNames.push_back(text("%g", wavelength_m * 1e3));
  for (const double height_m : kMapHeights_m) grids.rowNames.push_back(text("%g", height_m * 1e3));
  grids.columnLabel = "wavelength, mm";
  grids.rowLabel = "height, mm";
  for (const DevicePreset& device : devicePresets()) {
    SheetGrid grid{std::string(device.title), {}};
    for (const double height_m : kMapHeights_m) {
      std::vector<Colour>& row = grid.rows.emplace_back();
      for (const double wavelength_m : kMapWavelengths_m) {
        const auto rests = [&](std::string_view method) {
          return std::ranges::any_of(data.map, [&](const Record& r) {
            return r["method"] == method && r["device"] == device.name && r["hand"] == "light" &&
                   number(r, "height_mm") == height_m * 1e3 && number(r, "wavelength_mm") == wavelength_m * 1e3 &&
                   r["steady"].get<bool>();
          });
        };
        row.push_back(colourOf(rests("ours"), rests(kUnclamped), rests(kBumpMapping)));
      }
    }
    grids.grids.push_back(std::move(grid));
  }
  return grids;
}

SheetCurve curveOf(std::string name, Colour colour, const Trace& trace, double width) {
  return {std::move(name), colour, trace, width};
}

}  // namespace

void drawSheet(const TexturesData& data, std::uint64_t seed, const std::filesystem::path& png) {
  ContactSheet sheet;
  sheet.title = "Textures, friction and force shading as they are felt";
  sheet.caption = {
      "Ho, Basdogan & Srinivasan (1999), section 4, by the production step. Relief 0.5 mm on a board of 500 N/m, "
      "stroked "
      "0.8 mm deep, Eq. (4) with K = 1.5; green disc: within every limit.",
      "Loop: work that a press in the valley, slide to the crest and lift give the hand. Side: largest lateral "
      "stiffness. Buzz: false force above 100 Hz, positions rounded to 30 um, 50 mm/s. Rests: light hand, 1 kHz.",
      wrappedText(data.wrapped)};
  for (std::size_t i = 0; i < data.textureCases.size(); ++i) sheet.cards.push_back(cardOf(data, i));
  sheet.grids = gridsOf(data);
  sheet.plotsTitle = "Friction and force shading";
  const FrictionTraces friction = traceFriction(static_cast<std::uint32_t>(seed));
  sheet.plots.push_back(
      {"pull over pressing force: to and fro, 0.6 / 0.4", "mm", {curveOf("", kBlue, friction.toAndFro, 2)}});
  sheet.plots.push_back({"periodic friction, 4 mm", "mm", {curveOf("", kBlue, friction.periodic, 2)}, true});
  sheet.plots.push_back({"sandpaper, two grades",
                         "mm",
                         {curveOf("fine", kOrange, friction.fine, 1.4), curveOf("coarse", kBlue, friction.coarse, 2)},
                         true});
  const ShadingTraces shading = traceShading();
  sheet.plots.push_back(
      {"turn of the force on a sphere, deg",
       "mm",
       {curveOf("1,728 flat", kGrey, shading.unshaded, 1.4), curveOf("shaded", kBlue, shading.shaded, 2)}});
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawContactSheet(sheet, png));
}

}  // namespace haptics::eval
