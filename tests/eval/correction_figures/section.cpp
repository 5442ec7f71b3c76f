#include "tests/eval/correction_figures/section.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "haptic_server/engine/geometry/enclosure.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr Colour kHipColour{0.835, 0.369, 0.0}, kIhipColour{0.0, 0.447, 0.698}, kWrongColour{0.8, 0.05, 0.15},
    kSpringColour{0.62, 0.64, 0.67}, kSlowColour{0.0, 0.62, 0.451}, kEdgeColour{0.72, 0.75, 0.79},
    kInk{0.13, 0.15, 0.18};
constexpr double kWidth = DrawnPanel::kWidth_px, kHeight = DrawnPanel::kHeight_px;

bool isInside(const Trace& trace, const std::vector<Pose>& poses, std::size_t body, Vec3 world) {
  const CollisionMesh& surface = *trace.bodies[body];
  const Vec3 local = toLocal(poses[body], world);
  if (glm::any(glm::lessThan(local, surface.low())) || glm::any(glm::greaterThan(local, surface.high()))) return false;
  Allowance endless;
  return surface.closed() && windingNumber(surface, local, endless) > 0;
}

/// A plane in the frame of the first body, and its scale.
struct View {
  Vec3 origin{0};  // in the middle of the panel, m
  Vec3 right{1, 0, 0};
  Vec3 up{0, 0, 1};
  double px_per_m = 1;

  [[nodiscard]] Canvas::Point of(Vec3 local) const {
    return {kWidth / 2 + px_per_m * glm::dot(local - origin, right),
            kHeight / 2 + px_per_m * glm::dot(local - origin, up)};
  }
  [[nodiscard]] Vec3 at(double x, double y) const {
    return origin + right * ((x - kWidth / 2) / px_per_m) + up * ((y - kHeight / 2) / px_per_m);
  }
  /// Moves and scales to hold all of these.
  void fit(std::span<const Vec3> places, double least_m) {
    glm::dvec2 low(INFINITY), high(-INFINITY);
    for (const Vec3 p : places) {
      const glm::dvec2 at(glm::dot(p - origin, right), glm::dot(p - origin, up));
      low = glm::min(low, at);
      high = glm::max(high, at);
    }
    const glm::dvec2 middle = 0.5 * (low + high);
    origin += right * middle.x + up * middle.y;
    const glm::dvec2 size = glm::max(1.35 * (high - low), glm::dvec2(least_m));
    px_per_m = std::min(kWidth / size.x, kHeight / size.y);
  }
};

Vec3 inFirst(const TracedTick& tick, Vec3 world) { return toLocal(tick.poses[0], world); }

Vec3 across(Vec3 v, Vec3 axis) { return v - axis * glm::dot(v, axis); }

Vec3 unitOr(Vec3 v, Vec3 otherwise) { return glm::length(v) > 1e-9 ? glm::normalize(v) : otherwise; }

View viewOf(const Moment& moment, Cut cut, double offset_m) {
  const auto& ticks = moment.trace.ticks;
  const TracedTick& event = ticks[moment.event];
  const Vec3 ihip = inFirst(event, event.with.ihip);
  const Vec3 motion = inFirst(ticks.back(), ticks.back().hip) - inFirst(ticks.front(), ticks.front().hip);
  View view;
  view.origin = ihip;
  if (cut == Cut::kRadial) view.up = glm::normalize(ihip);
  if (cut == Cut::kThroughBoth) view.up = unitOr(ihip - inFirst(event, event.without.ihip), Vec3(0, 0, 1));
  const Vec3 along = cut == Cut::kThroughBoth ? inFirst(event, event.hip) - ihip
                     : cut == Cut::kAcross    ? Vec3(1, 0, 0)
                                              : motion;
  view.right = unitOr(across(along, view.up), unitOr(across(Vec3(1, 0, 0), view.up), Vec3(0, 1, 0)));
  const Vec3 normal = glm::cross(view.right, view.up);
  view.origin += normal * offset_m;
  if (cut == Cut::kFromAbove) {
    view.up = -normal;
    view.origin = ihip + Vec3(0, 0, offset_m);
  }
  return view;
}

Raster sectionOf(const Moment& moment, const View& view) {
  constexpr std::array<std::uint8_t, 4> kShade{255, 222, 196, 172};
  const Trace& trace = moment.trace;
  const std::vector<Pose>& poses = trace.ticks[moment.event].poses;
  Raster raster{static_cast<int>(kWidth), static_cast<int>(kHeight), {}};
  for (int y = 0; y < raster.height; ++y) {
    for (int x = 0; x < raster.width; ++x) {
      const Vec3 world = toWorld(poses[0], view.at(x + 0.5, y + 0.5));
      std::size_t count = 0;
      for (std::size_t b = 0; b < trace.bodies.size(); ++b) count += isInside(trace, poses, b, world) ? 1 : 0;
      const std::uint8_t shade = kShade[std::min(count, kShade.size() - 1)];
      for (const int blue : {0, 0, 1}) raster.rgb.push_back(static_cast<std::uint8_t>(std::min(255, shade + 4 * blue)));
    }
  }
  return raster;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value >= 1000 ? "%.0f" : "%.3g", value);
  return text;
}

std::string lengthText(double metres) {
  if (metres >= 1e-3) return number(metres * 1e3) + " mm";
  return metres >= 1e-6 ? number(metres * 1e6) + " um" : number(metres * 1e9) + " nm";
}

void addScale(DrawnPanel& panel, double px_per_m) {
  constexpr double kRight = kWidth - 12;
  double length = std::pow(10, std::floor(std::log10(kWidth / px_per_m / 4)));
  for (const double more : {5.0, 2.0}) {
    if (more * length * px_per_m > kWidth / 3) continue;
    length *= more;
    break;
  }
  const double left = kRight - length * px_per_m;
  panel.strokes.push_back({{{left, 12}, {kRight, 12}}, kInk, 2});
  panel.words.push_back({{(left + kRight) / 2, 15}, lengthText(length), Align::kCentre});
}

/// As far as it is in the panel.
void addSlow(DrawnPanel& panel, const Moment& moment, const View& view) {
  DrawnPanel::Stroke run{{}, kSlowColour, 2};
  for (const Vec3 place : moment.slow) {
    const Canvas::Point at = view.of(place);
    const bool isInPanel = at.x > 0 && at.x < kWidth && at.y > 0 && at.y < kHeight;
    if (isInPanel) run.points.push_back(at);
    if (isInPanel || run.points.empty()) continue;
    panel.strokes.push_back(run);
    run.points.clear();
  }
  panel.strokes.push_back(run);
}

/// What one of the two methods made of the ticks.
DrawnPanel panelOf(const Moment& moment, const View& view, Felt TracedTick::*felt, Raster background) {
  constexpr double kDot_px = 2.5;
  constexpr double kApart_px = 9;
  const Trace& trace = moment.trace;
  DrawnPanel panel;
  panel.background = std::move(background);
  std::vector<Canvas::Point> hips, ihips;
  addSlow(panel, moment, view);
  int without = 0;
  int inside = 0;
  double longest_m = 0;
  Canvas::Point last{-1e9, -1e9};
  for (const TracedTick& tick : trace.ticks) {
    const Felt& f = tick.*felt;
    hips.push_back(view.of(inFirst(tick, tick.hip)));
    ihips.push_back(view.of(inFirst(tick, f.ihip)));
    const bool missed = !f.touching && depthInside(trace, tick, tick.hip) > kInside_m;
    const bool entered = f.touching && depthInside(trace, tick, f.ihip) > kInside_m;
    without += missed ? 1 : 0;
    inside += entered ? 1 : 0;
    longest_m = std::max(longest_m, f.touching ? glm::distance(f.ihip, tick.hip) : 0);
    const double apart = std::hypot(hips.back().x - last.x, hips.back().y - last.y);
    if (f.touching && apart >= kApart_px) {
      panel.strokes.push_back({{hips.back(), ihips.back()}, kSpringColour, 1});
      last = hips.back();
    }
    panel.dots.push_back({hips.back(), kDot_px, missed ? kWrongColour : kHipColour});
    if (f.touching) panel.dots.push_back({ihips.back(), kDot_px, entered ? kWrongColour : kIhipColour});
  }
  panel.strokes.push_back({hips, kHipColour, 1});
  addScale(panel, view.px_per_m);
  panel.verdict = "longest spring " + lengthText(longest_m) + "; inside without force " + std::to_string(without) +
                  " ticks, IHIP inside " + std::to_string(inside);
  return panel;
}

DrawnPanel curvePanel(const std::vector<double>& values, double highest, const std::string& unit) {
  constexpr double kLeft = 56, kBelow = 26, kTop = 14;
  DrawnPanel panel;
  std::vector<Canvas::Point> points;
  const double width = kWidth - kLeft - 12;
  const double height = kHeight - kBelow - kTop;
  const auto y = [&](double value) { return kBelow + height * value / highest; };
  for (std::size_t i = 0; i < values.size(); ++i) {
    points.push_back({kLeft + width * static_cast<double>(i) / static_cast<double>(values.size()), y(values[i])});
  }
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double at = y(share * highest);
    panel.strokes.push_back({{{kLeft, at}, {kLeft + width, at}}, kEdgeColour, 1});
    panel.words.push_back({{kLeft - 5, at - 7}, number(share * highest), Align::kRight});
  }
  panel.strokes.push_back({points, kIhipColour, 2});
  panel.words.push_back({{kLeft, 4}, "tick 0"});
  panel.words.push_back({{kLeft + width, 4}, std::to_string(values.size()), Align::kRight});
  panel.verdict = "largest value " + number(*std::ranges::max_element(values)) + " " + unit;
  return panel;
}

}  // namespace

double depthInside(const Trace& trace, const TracedTick& tick, Vec3 world) {
  double depth = 0;
  for (std::size_t b = 0; b < trace.bodies.size(); ++b) {
    if (!isInside(trace, tick.poses, b, world)) continue;
    const CollisionMesh& surface = *trace.bodies[b];
    int spent = 0;
    const ClosestPoint foot =
        surface.closestFoot(toLocal(tick.poses[b], world), static_cast<int>(surface.triangleCount()) + 1, spent);
    depth = std::max(depth, std::sqrt(foot.squaredDistance));
  }
  return depth;
}

PanelPair drawSection(const Moment& moment, Cut cut, double offset_m) {
  constexpr double kMin_m = 1e-3;
  View view = viewOf(moment, cut, offset_m);
  std::vector<Vec3> places;
  for (const TracedTick& tick : moment.trace.ticks) {
    for (const Vec3 place : {tick.hip, tick.without.ihip, tick.with.ihip}) places.push_back(inFirst(tick, place));
  }
  view.fit(places, kMin_m);
  PanelPair pair;
  const Raster background = sectionOf(moment, view);
  pair.panels = {panelOf(moment, view, &TracedTick::without, background),
                 panelOf(moment, view, &TracedTick::with, background)};
  pair.key = {{"HIP, each tick", kHipColour},
              {"IHIP", kIhipColour},
              {"spring", kSpringColour, true},
              {"HIP without force, or IHIP, inside a body", kWrongColour}};
  if (!moment.slow.empty()) pair.key.push_back({"IHIP of a slow hand", kSlowColour, true});
  return pair;
}

PanelPair drawCurves(const CurveOf& curves) {
  const double highest =
      std::max({*std::ranges::max_element(curves.without), *std::ranges::max_element(curves.with), 1e-30});
  PanelPair pair;
  pair.panels = {curvePanel(curves.without, highest, curves.unit), curvePanel(curves.with, highest, curves.unit)};
  pair.key = {{curves.meaning + (curves.unit.empty() ? "" : ", " + curves.unit), kIhipColour, true}};
  return pair;
}

PanelPair drawPlaces(const CollisionMesh& surface, std::span<const Vec3> without, std::span<const Vec3> with) {
  View view;
  view.up = {0, 1, 0};
  const Vec3 reach = glm::max(-surface.low(), surface.high());
  view.px_per_m = kHeight / (2.7 * std::max(reach.x, reach.y));
  PanelPair pair;
  for (std::size_t i = 0; i < 2; ++i) {
    DrawnPanel& panel = pair.panels[i];
    for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
      const TriangleRecord& r = surface.triangle(t);
      if (r.areaNormal().z <= 0) continue;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t across = r.neighbour(k);
        if (across < t && surface.triangle(across).areaNormal().z > 0) continue;  // drawn already
        panel.strokes.push_back({{view.of(r.corner(k)), view.of(r.corner(nextCorner(k)))}, kEdgeColour, 1});
      }
    }
    const auto places = i == 0 ? without : with;
    for (const Vec3 place : places) {
      if (place.z > 0) panel.dots.push_back({view.of(place), 2.5, kWrongColour});
    }
    panel.verdict = std::to_string(places.size()) + " segments pass without a contact";
    addScale(panel, view.px_per_m);
  }
  pair.key = {{"place of a lost segment (those on this side of the mesh)", kWrongColour},
              {"edges of the mesh", kEdgeColour, true}};
  return pair;
}

}  // namespace haptics::eval
