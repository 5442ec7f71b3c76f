#include "tests/eval/teleoperation/teleoperation.h"

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "haptic_server/device/presets.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/report.h"
#include "tests/eval/teleoperation/coupled_run.h"

namespace haptics::eval {
namespace {

constexpr std::array kDelays_ms{0, 50, 200, 300};
constexpr double kJitter_s = 0.01, kLost = 0.05;
constexpr const char* kDevice = "omega.3";

struct RemoteContact {
  const char* name;
  double stiffness_N_per_m;
};
constexpr std::array kContacts{RemoteContact{"free", 0}, RemoteContact{"soft", 200}, RemoteContact{"hard", 10'000}};

class Cells {
 public:
  explicit Cells(std::uint64_t seed) : seed_(seed) {}

  /// With every contact and hand.
  void run(const CouplingMethod& method, const DevicePreset& master, int delay_ms, bool keepsTrace) {
    for (const char* hand : {"light", "nominal"}) {
      for (const RemoteContact& contact : kContacts) run(method, master, delay_ms, hand, contact, keepsTrace);
    }
  }
  std::vector<Record> records;
  Record traces = Record::array();
  bool good = true;

 private:
  std::uint64_t seed_;

  void run(const CouplingMethod& method, const DevicePreset& master, int delay_ms, const char* hand,
           const RemoteContact& contact, bool keepsTrace) {
    const TeleoperationRun ran = runCell({.method = &method,
                                          .master = master,
                                          .follower = orThrow(findDevicePreset(kDevice)),
                                          .hand = orThrow(findHandPreset(hand)),
                                          .line = {1e-3 * delay_ms, kJitter_s, kLost},
                                          .remote_N_per_m = contact.stiffness_N_per_m,
                                          .seed = seed_});
    constexpr double kRounding_J = 1e-9, kLongestRest_s = 1, kMaxShare = 0.25;
    const bool pass = ran.least_J >= -kRounding_J && ran.rest_s <= kLongestRest_s && ran.packets <= kMaxShare &&
                      ran.unnoticed <= kMaxShare;
    const bool isOurs = &method == &couplingMethods().front();
    good = good && (pass || !isOurs);
    Record record{{"method", method.name},
                  {"scene", contact.name},
                  {"device", master.name},
                  {"hand", hand},
                  {"delay_ms", delay_ms},
                  {"seed", seed_},
                  {"least_energy_uJ", 1e6 * ran.least_J},
                  {"rest_s", ran.rest_s},
                  {"free_error_mm", ran.freeError_mm},
                  {"free_force_N", ran.freeForce_N},
                  {"hand_N", ran.hand_N},
                  {"contact_N", ran.contact_N},
                  {"apart_mm", ran.apart_mm}};
    if (contact.stiffness_N_per_m > 0) {
      record["felt_N_per_m"] = ran.depth_mm > 0 ? ran.hand_N / (1e-3 * ran.depth_mm) : 0;
      record["coupled_N_per_m"] = 1 / (1 / kCoupling_N_per_m + 1 / contact.stiffness_N_per_m);
    }
    record["packets_percent"] = 100 * ran.packets;
    record["unnoticed_percent"] = 100 * ran.unnoticed;
    record["pass"] = pass;
    std::printf(
        "%-17s %-8s %-7s %3d ms %s: energy %9.1f uJ, rest %.2f s, hand %5.2f N, contact %5.2f N, packets %5.1f %%%s\n",
        method.name, std::string(master.name).c_str(), hand, delay_ms, contact.name, 1e6 * ran.least_J, ran.rest_s,
        ran.hand_N, ran.contact_N, 100 * ran.packets,
        pass     ? ""
        : isOurs ? "  FAIL"
                 : "  no");
    records.push_back(record);
    if (!keepsTrace) return;
    Record samples = Record::array();
    for (const auto& s : ran.samples)
      samples.push_back({s.time_s, s.meant_mm, s.master_mm, s.follower_mm, s.felt_N, s.contact_N});
    record["title"] = method.title;
    record["samples"] = samples;
    traces.push_back(record);
  }
};

}  // namespace

bool runTeleoperation(const TeleoperationOptions& options) {
  const auto methods = couplingMethods();
  const DevicePreset usual = orThrow(findDevicePreset(kDevice));
  Cells cells(options.seed);
  for (const CouplingMethod& method : methods) {
    if (options.shortRun && &method != &methods.front()) break;
    for (const int delay_ms : kDelays_ms) {
      if (options.shortRun && delay_ms > kDelays_ms.front() && delay_ms < kDelays_ms.back()) continue;
      cells.run(method, usual, delay_ms, !options.shortRun);
    }
  }
  if (!options.shortRun) {
    Record titles = Record::array();
    for (const CouplingMethod& method : methods) titles.push_back({method.name, method.title});
    drawFigure("teleoperation", {{"methods", titles}, {"runs", cells.traces}}, options.out / "teleoperation");
  }
  if (options.full) {
    constexpr int kLines = 10;
    for (int line = 0; line < kLines; ++line) {
      Cells more(options.seed + 1 + static_cast<std::uint64_t>(line));
      for (const DevicePreset& device : devicePresets()) {
        for (const int delay_ms : kDelays_ms) more.run(methods.front(), device, delay_ms, false);
      }
      cells.records.insert(cells.records.end(), more.records.begin(), more.records.end());
      cells.good = cells.good && more.good;
    }
  }
  writeRecords(options.out, "teleoperation", cells.records);
  return cells.good;
}

}  // namespace haptics::eval
