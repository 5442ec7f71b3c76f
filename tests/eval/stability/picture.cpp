#include "tests/eval/stability/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "haptic_server/device/presets.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/renderer.h"
#include "tests/eval/stability/limits.h"
#include "tests/eval/stability/methods.h"

namespace haptics::eval {
namespace {

constexpr Decades kStiffness{1, 6};  // N/m
constexpr Decades kDamping{-1, 2};   // N s/m; none on the left rim
constexpr double kNoDamping = 0.1;
constexpr double kNoDelay_ms = 0.1;

enum Formula : std::size_t { kColgate, kAbbott, kGil, kExact, kFormulas };

double number(const Record& r, const char* key) { return r.at(key).get<double>(); }

/// Those of one method, scene and device in the order of a measure, as K_crit over it.
template <class Wanted>
std::vector<CurvePoint> pointsOf(const std::vector<Record>& records, const char* over, double least, Wanted wanted) {
  std::vector<CurvePoint> points;
  for (const Record& r : records) {
    if (!r.contains("K_crit_N_per_m") || !wanted(r)) continue;
    points.push_back({std::max(least, number(r, over)), number(r, "K_crit_N_per_m"), ""});
  }
  std::ranges::sort(points, {}, &CurvePoint::x);
  return points;
}

/// As long as the formula gives more than nothing.
template <class Limit>
Curve formulaCurve(std::size_t style, double most, Limit limit) {
  Curve curve{style, {}};
  constexpr double kStep = 1.25;
  for (double damping = kNoDamping; damping <= most; damping *= kStep) {
    const double k = limit(damping <= kNoDamping ? 0 : damping);
    if (k >= std::pow(10, kStiffness.low)) curve.points.push_back({damping, k, ""});
  }
  return curve;
}

Panel zWidthPanel(const std::vector<Record>& records, const DevicePreset& device) {
  Panel panel{std::string(device.title), "rendered damping B, N s/m", "stiffness, N/m", kDamping, kStiffness, {}, {}};
  const std::size_t methods = stabilityMethods().size();
  const auto loop = [&](double damping) {
    return SampledLoop{device.apparentMass_kg, device.viscousFriction_Ns_per_m, damping, kPeriod_s, kPeriod_s};
  };
  constexpr double kShort = 0.2;  // of what is said of no damping only
  const double most = std::pow(10, kDamping.high);
  panel.curves.push_back(
      formulaCurve(methods + kColgate, most, [&](double b) { return passiveLimit_N_per_m(loop(b)); }));
  panel.curves.push_back(formulaCurve(methods + kAbbott, kShort, [&](double) {
    return frictionLimit_N_per_m(device.viscousFriction_Ns_per_m, device.coulombFriction_N, device.resolution_m,
                                 kPeriod_s);
  }));
  panel.curves.push_back(formulaCurve(methods + kGil, most, [&](double b) { return delayLimit_N_per_m(loop(b)); }));
  panel.curves.push_back(formulaCurve(methods + kExact, most, [&](double b) { return exactLimit_N_per_m(loop(b)); }));
  for (std::size_t i = 0; i < methods; ++i) {
    panel.curves.push_back({i, pointsOf(records, "B_Ns_per_m", kNoDamping, [&](const Record& r) {
                              return r["scene"] == "z_width" && r["device"] == device.name &&
                                     r["method"] == stabilityMethods()[i].name;
                            })});
  }
  panel.threshold = {device.maxStiffness_N_per_m, "the maker's limit"};
  return panel;
}

Panel overPanel(const std::vector<Record>& records, const DevicePreset& device, const char* over, const char* label,
                Decades decades, double least) {
  Panel panel{std::string(device.title), label, "stiffness, N/m", decades, kStiffness, {}, {}};
  const bool delays = std::string_view(over) == "delay_ms";
  for (std::size_t i = 0; i < stabilityMethods().size(); ++i) {
    panel.curves.push_back({i, pointsOf(records, over, least, [&](const Record& r) {
                              const bool same =
                                  delays ? number(r, "rate_Hz") == 1e3
                                         : std::abs(number(r, "delay_ms") - 1e3 / number(r, "rate_Hz")) < 1e-9;
                              return r["scene"] == "wall" && r["device"] == device.name && r["hand"] == "none" &&
                                     r["method"] == stabilityMethods()[i].name && same;
                            })});
  }
  panel.threshold = {device.maxStiffness_N_per_m, "the maker's limit"};
  return panel;
}

/// Where devices lie at their makers' stiffness (Diolaiti et al. 2006).
Panel regionsPanel(std::size_t lines, std::size_t points) {
  Panel panel{"At the maker's K", "b / (K T)", "f_c / (K step)", {-3, 1}, {-2, 2}, {}, {}};
  constexpr double kHalf = 0.5;
  panel.curves.push_back({lines, {{kHalf, 1e-2, ""}, {kHalf, 1e2, ""}}});
  panel.threshold = {kHalf, "rings below"};
  for (const DevicePreset& device : devicePresets()) {
    const double k = device.maxStiffness_N_per_m;
    panel.curves.push_back({points,
                            {{device.viscousFriction_Ns_per_m / (k * kPeriod_s),
                              device.coulombFriction_N / (k * device.resolution_m), std::string(device.name)}}});
  }
  return panel;
}

}  // namespace

void drawStability(const std::vector<Record>& records, const std::filesystem::path& folder) {
  constexpr std::array kColours{Colour{0.55, 0.57, 0.60}, Colour{0.80, 0.24, 0.20}, Colour{0.902, 0.494, 0.0},
                                Colour{0.0, 0.62, 0.451}, Colour{0.0, 0.447, 0.698}};
  Figure figure;
  figure.title = "How stiff a wall each device bears";
  figure.caption = {
      "Largest stiffness up to which a device in nobody's hand comes to rest after pushes of 0.5 and 1 N and taps at "
      "0.02",
      "and 0.15 m/s, against the damping rendered with it. 1 kHz, one period of delay. No damping: left rim."};
  figure.columns = 3;
  for (std::size_t i = 0; i < stabilityMethods().size(); ++i) {
    const MethodEntry& method = stabilityMethods()[i];
    figure.styles.push_back(
        {std::string(method.title), std::string(method.note), kColours[i], Marker::kDisc, method.name == kOursMethod});
  }
  constexpr Colour kInk{0.13, 0.15, 0.18}, kBrown{0.55, 0.34, 0.16}, kPurple{0.50, 0.28, 0.62}, kPink{0.86, 0.44, 0.66};
  figure.styles.push_back({"passive", "b > K T / 2 + |B| (Colgate & Schenkel)", kPurple, Marker::kNone});
  figure.styles.push_back({"passive with friction", "2 b / T, 2 f_c / step (Abbott, Okamura)", kPink, Marker::kNone});
  figure.styles.push_back({"stable with delay", "K (T / 2 + t_d) < b + B (Gil et al.)", kBrown, Marker::kNone});
  figure.styles.push_back({"stable", "eigenvalues of the sampled system", kInk, Marker::kNone});
  const DevicePreset* serial = nullptr;
  for (const DevicePreset& device : devicePresets()) {
    if (device.name == "touch") continue;  // the omni's mechanics
    if (device.name == "desktop") serial = &device;
    figure.panels.push_back(zWidthPanel(records, device));
  }
  figure.panels.push_back(
      overPanel(records, *serial, "delay_ms", "delay, ms, at 1 kHz (none: left rim)", {-1, 1}, kNoDelay_ms));
  figure.panels.push_back(overPanel(records, *serial, "rate_Hz", "servo rate, Hz, a period of delay", {3, 4}, 1));
  figure.panels.push_back(regionsPanel(stabilityMethods().size() + kExact, 0));
  figure.legendTitle = "Method";
  figure.legendNotes = {"Dashed: the literature's limits for a spring", "and a damper, without encoder; what lies",
                        "below the first two makes no energy.",         "Last panel: the regions of Diolaiti et al.",
                        "Right of the line passive, left of it only",   "locally stable; below the other, it rings."};
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawFigure(figure, folder / "stability.png", folder / "stability.svg"));
}

}  // namespace haptics::eval
