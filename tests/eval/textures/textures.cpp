#include "tests/eval/textures/textures.h"

#include <algorithm>
#include <cstdio>

#include "haptic_server/device/presets.h"
#include "tests/eval/report.h"
#include "tests/eval/textures/friction_figures.h"
#include "tests/eval/textures/resting_figures.h"
#include "tests/eval/textures/shading_figures.h"
#include "tests/eval/textures/sheet.h"

namespace haptics::eval {
namespace {

const char* verdict(const Record& r) { return r["pass"].get<bool>() ? "" : "  FAIL"; }
double number(const Record& r, const char* key) { return r.at(key).get<double>(); }
std::string words(const Record& r, const char* key) { return r.at(key).get<std::string>(); }

void printTextures(const std::vector<TextureFigures>& figures) {
  std::printf("\n%-16s %9s %9s %9s  %8s %8s  %8s %8s  %8s %8s  %7s\n", "texture", "gradient", "jump of", "spectrum",
              "wave mm", "set mm", "loop mJ", "derived", "N/m side", "derived", "buzz mN");
  for (const TextureFigures& f : figures) {
    const Record& r = f.record;
    std::printf("%-16s %9.1e %9.1e %9.1e  ", words(r, "scene").c_str(), number(r, "gradient_error_ratio"),
                number(r, "gradient_jump_ratio"), number(r, "force_spectrum_difference_ratio"));
    if (r.contains("wavelength_set_mm")) {
      std::printf("%8.3f %8.3f", number(r, "wavelength_of_force_mm"), number(r, "wavelength_set_mm"));
    } else {
      std::printf("%8s %8s", "", "");
    }
    std::printf("  %8.4f %8.4f  %8.1f %8.1f  %7.2f%s\n", number(r, "loop_up_work_mJ"), number(r, "loop_up_derived_mJ"),
                number(r, "lateral_stiffness_max_N_per_m"), number(r, "lateral_stiffness_derived_max_N_per_m"),
                1e3 * number(r, "false_force_above_100Hz_at_1kHz_rms_N"), verdict(r));
  }
}

struct Worst {
  double cycle_um = 0;
  bool steady = true;
};
/// Of all rates.
Worst worstOf(const std::vector<Record>& records, std::string_view method, const std::string& scene,
              const DevicePreset& device, const HandPreset& hand) {
  Worst worst;
  for (const Record& r : records) {
    if (r["method"] != method || r["scene"] != scene || r["device"] != device.name || r["hand"] != hand.name) continue;
    worst.cycle_um = std::max(worst.cycle_um, number(r, "limit_cycle_um"));
    worst.steady = worst.steady && r["steady"].get<bool>();
  }
  return worst;
}

/// Limit cycles, a line for each device, hand and method.
void printResting(const std::vector<Record>& records, const std::vector<TextureCase>& textureCases) {
  std::printf(
      "\nlimit cycle, um, worst of 1, 4 and 10 kHz, with the stabiliser, as the server has it by default; ! is beyond "
      "what is allowed, >mm has slid away\n%-12s %-6s %-24s "
      "%8s",
      "device", "hand", "method", "allowed");
  for (const TextureCase& e : textureCases) std::printf(" %9.9s", e.name.c_str());
  for (const DevicePreset& device : devicePresets()) {
    for (const HandPreset& hand : handPresets().first(2)) {
      for (const std::string_view method : {std::string_view("ours"), kUnclamped, kBumpMapping}) {
        std::printf("\n%-12s %-6s %-24s %8.0f", device.name.data(), hand.name.data(), method.data(),
                    std::max(2 * device.resolution_m * 1e6, 20.0));
        for (const TextureCase& e : textureCases) {
          const Worst worst = worstOf(records, method, "rest_" + e.name, device, hand);
          constexpr double kSlid_um = 2000;
          if (worst.cycle_um > kSlid_um) {
            std::printf(" %9s", ">mm");
          } else {
            std::printf(" %8.1f%s", worst.cycle_um, worst.steady ? " " : "!");
          }
        }
      }
    }
  }
  std::printf("\n");
}

void printMeasures(const char* title, const std::vector<Record>& records) {
  std::printf("\n%s\n", title);
  for (const Record& r : records) {
    Record measures = r;
    for (const char* key : {"method", "scene", "pass"}) measures.erase(key);
    const bool ours = r["method"] == "ours";
    std::printf("  %-26s %s%s%s\n", words(r, "scene").c_str(), ours ? "" : (words(r, "method") + ": ").c_str(),
                measuresText(measures).c_str(), verdict(r));
  }
}

std::vector<Record> all(const TexturesData& data) {
  std::vector<Record> records;
  for (const TextureFigures& f : data.figures) records.push_back(f.record);
  for (const auto* part : {&data.wrapped, &data.laws, &data.resting, &data.map, &data.friction, &data.shading}) {
    records.insert(records.end(), part->begin(), part->end());
  }
  return records;
}

}  // namespace

bool runTextures(const TexturesOptions& options) {
  TexturesData data;
  data.textureCases = makeTextureCases(static_cast<std::uint32_t>(options.seed));
  for (const TextureCase& textureCase : data.textureCases)
    data.figures.push_back(measureTexture(textureCase, options.seed));
  printTextures(data.figures);
  for (const TextureCase& textureCase : wrapped(data.textureCases))
    data.wrapped.push_back(measureWrapped(textureCase, options.seed));
  printMeasures("round intermediate surfaces", data.wrapped);
  data.laws = measureLaws(options.seed);
  printMeasures("laws", data.laws);
  data.resting = measureResting(data.textureCases);
  printResting(data.resting, data.textureCases);
  data.map = mapGratings();
  data.friction = measureFriction(options.seed);
  printMeasures("friction", data.friction);
  data.shading = measureShading(options.seed);
  printMeasures("force shading", data.shading);

  const std::vector<Record> records = all(data);
  writeRecords(options.out, "textures", records);
  drawSheet(data, options.seed, options.out / "textures");
  const auto failed = std::ranges::count_if(records, [](const Record& r) { return !r["pass"].get<bool>(); });
  std::printf("\n%zu records, %td beyond a limit; written to %s: textures.json, textures.png\n", records.size(), failed,
              options.out.c_str());
  return failed == 0;
}

}  // namespace haptics::eval
