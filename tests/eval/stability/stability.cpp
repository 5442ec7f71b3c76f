#include "tests/eval/stability/stability.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "tests/eval/stability/held_tool.h"
#include "tests/eval/stability/linear_loop.h"
#include "tests/eval/stability/picture.h"
#include "tests/eval/stability/strokes.h"
#include "tests/eval/stability/support.h"
#include "tests/eval/stability/tables.h"
#include "tests/eval/stability/texture_rest.h"

namespace haptics::eval {
namespace {

double number(const Record& r, const char* key) { return r.at(key).get<double>(); }

bool is(const Record& r, const char* key, std::string_view value) {
  return r.at(key).get_ref<const std::string&>() == value;
}

/// On a terminal one line that is written over.
void showProgress(std::string_view table, std::size_t done, std::size_t of) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "\r%-24.*s %zu of %zu   ", static_cast<int>(table.size()), table.data(), done + 1, of);
  if (done + 1 == of) std::fprintf(stderr, "\r%60s\r", "");
}

void printCritical(const std::vector<Record>& records) {
  std::printf("K_crit of the wall, N/m, at 1 kHz, without delay / with a period of it\n%-24s %-8s", "", "hand");
  for (const DevicePreset& device : devicePresets()) std::printf(" %15s", device.name.data());
  for (const MethodEntry& method : stabilityMethods()) {
    for (const HandPreset& hand : handPresets()) {
      std::string line;
      for (const DevicePreset& device : devicePresets()) {
        double at[2] = {-1, -1};
        for (const Record& r : records) {
          if (!is(r, "method", method.name) || !is(r, "device", device.name) || !is(r, "hand", hand.name)) continue;
          if (number(r, "rate_Hz") != 1e3 || number(r, "delay_ms") > 1) continue;
          at[number(r, "delay_ms") > 0 ? 1 : 0] = number(r, "K_crit_N_per_m");
        }
        char cell[32];
        std::snprintf(cell, sizeof cell, " %7.0f/%-7.0f", at[0], at[1]);
        line += at[0] < 0 ? std::string(16, ' ') : cell;
      }
      if (line.find('/') != std::string::npos) {
        std::printf("\n%-24s %-8s%s", method.title.data(), hand.name.data(), line.c_str());
      }
    }
  }
  std::printf("\n");
}

/// Of each scene and method the record that is worst by this measure; those beyond a limit all.
void printWorst(const char* title, const std::vector<Record>& records, const char* measure, bool leastIsWorst) {
  std::printf("\n%s\n", title);
  std::vector<const Record*> worst;
  for (const Record& r : records) {
    const auto same = [&](const Record* w) { return (*w)["scene"] == r["scene"] && (*w)["method"] == r["method"]; };
    const auto at = std::ranges::find_if(worst, same);
    if (at == worst.end()) {
      worst.push_back(&r);
    } else if (leastIsWorst ? number(r, measure) < number(**at, measure) : number(r, measure) > number(**at, measure)) {
      *at = &r;
    }
  }
  for (const Record* r : worst) std::printf("  worst: %s\n", measuresText(*r).c_str());
  for (const Record& r : records) {
    if (!r["pass"].get<bool>()) std::printf("  BEYOND ITS LIMIT: %s\n", measuresText(r).c_str());
  }
}

}  // namespace

bool runStability(const StabilityOptions& options) {
  if (!options.from.empty()) {
    drawStability(readRecords(options.from), options.out);
    return true;
  }
  const Scope scope = options.shortRun ? Scope::kShort : options.full ? Scope::kFull : Scope::kCoarse;
  std::vector<Record> all;
  const auto keep = [&](std::vector<Record> records) {
    all.insert(all.end(), records.begin(), records.end());
    return records;
  };
  const auto magnitude = [](std::vector<Record> records) {
    for (Record& r : records) r["off_ratio"] = std::abs(number(r, "difference_ratio"));
    return records;
  };
  printCritical(keep(measureCritical(scope, showProgress)));
  printWorst("Theory: what the simulated plant bears against what it should", magnitude(keep(compareWithTheory())),
             "off_ratio", false);
  printWorst("Theory: on a body that moves, on tissue", magnitude(keep(compareFootings())), "off_ratio", false);
  printWorst("Other grounds, ours", keep(measureGrounds(scope, showProgress)), "K_crit_over_preset", true);
  printWorst("A plate that is held, ours", keep(measureHeldTool(scope, showProgress)), "K_crit_over_preset", true);
  printWorst("Mass, friction and delay not as told, ours", keep(measureRobustness(scope, showProgress)),
             "K_crit_over_preset", true);
  printWorst("Press, stroke, lift at the maker's stiffness", keep(measureFidelity(scope, showProgress)),
             "force_error_rms_ratio", false);
  printWorst("Energy taken from the hand, least at any time", keep(measureEnergy(scope, showProgress)),
             "least_energy_taken_uJ", true);
  printWorst("Textures in the light hand, ours", keep(measureTextureRest(scope, showProgress)), "limit_cycle_um",
             false);
  keep(measureZWidth(scope, showProgress));
  writeRecords(options.out, "stability", all);
  if (scope != Scope::kShort) drawStability(all, options.out);
  const auto failed = std::ranges::count_if(all, [](const Record& r) { return !r["pass"].get<bool>(); });
  std::printf("\n%zu records, %td beyond a limit; written to %s: stability.json%s\n", all.size(), failed,
              options.out.c_str(), scope == Scope::kShort ? "" : ", stability.png, stability.svg");
  return failed == 0;
}

}  // namespace haptics::eval
