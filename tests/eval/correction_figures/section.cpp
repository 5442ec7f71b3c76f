#include "tests/eval/correction_figures/section.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/geometry/enclosure.h"
#include "tests/eval/stage.h"

namespace haptics::eval {
namespace {

constexpr double kWidth = 440, kHeight = 330;  // of a panel, px

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

  [[nodiscard]] Record of(Vec3 local) const {
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

/// In how many bodies each pixel is; rows from the lowest on.
Record insideOf(const Moment& moment, const View& view) {
  const Trace& trace = moment.trace;
  const std::vector<Pose>& poses = trace.ticks[moment.event].poses;
  Record rows;
  for (int y = 0; y < static_cast<int>(kHeight); ++y) {
    std::vector<std::size_t> row;
    for (int x = 0; x < static_cast<int>(kWidth); ++x) {
      const Vec3 world = toWorld(poses[0], view.at(x + 0.5, y + 0.5));
      std::size_t& count = row.emplace_back(0);
      for (std::size_t b = 0; b < trace.bodies.size(); ++b) count += isInside(trace, poses, b, world) ? 1 : 0;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// As far as it is in the panel, a line for each time that it is.
Record slowOf(const Moment& moment, const View& view) {
  Record lines = Record::array();
  bool wasInPanel = false;
  for (const Vec3 place : moment.slow) {
    const Record at = view.of(place);
    const double x = at[0], y = at[1];
    const bool isInPanel = x > 0 && x < kWidth && y > 0 && y < kHeight;
    if (isInPanel && !wasInPanel) lines.push_back(Record::array());
    if (isInPanel) lines.back().push_back(at);
    wasInPanel = isInPanel;
  }
  return lines;
}

/// What one of the two methods made of the ticks.
Record panelOf(const Moment& moment, const View& view, Felt TracedTick::*felt) {
  const Trace& trace = moment.trace;
  Record ticks;
  double longest_m = 0;
  for (const TracedTick& tick : trace.ticks) {
    const Felt& f = tick.*felt;
    const bool missed = !f.touching && depthInside(trace, tick, tick.hip) > kInside_m;
    const bool entered = f.touching && depthInside(trace, tick, f.ihip) > kInside_m;
    longest_m = std::max(longest_m, f.touching ? glm::distance(f.ihip, tick.hip) : 0);
    ticks.push_back({view.of(inFirst(tick, tick.hip)), view.of(inFirst(tick, f.ihip)), f.touching, missed, entered});
  }
  return {{"ticks", std::move(ticks)}, {"longest_m", longest_m}};
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

Record describeSection(const Moment& moment, Cut cut, double offset_m) {
  constexpr double kMin_m = 1e-3;
  View view = viewOf(moment, cut, offset_m);
  std::vector<Vec3> places;
  for (const TracedTick& tick : moment.trace.ticks) {
    for (const Vec3 place : {tick.hip, tick.without.ihip, tick.with.ihip}) places.push_back(inFirst(tick, place));
  }
  view.fit(places, kMin_m);
  return {{"kind", "section"},
          {"px_per_m", view.px_per_m},
          {"inside", insideOf(moment, view)},
          {"slow", slowOf(moment, view)},
          {"panels", {panelOf(moment, view, &TracedTick::without), panelOf(moment, view, &TracedTick::with)}}};
}

Record describePlaces(const CollisionMesh& surface, std::span<const Vec3> without, std::span<const Vec3> with) {
  View view;
  view.up = {0, 1, 0};
  const Vec3 reach = glm::max(-surface.low(), surface.high());
  view.px_per_m = kHeight / (2.7 * std::max(reach.x, reach.y));
  Record edges, panels;
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    const TriangleRecord& r = surface.triangle(t);
    if (r.areaNormal().z <= 0) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t across = r.neighbour(k);
      if (across < t && surface.triangle(across).areaNormal().z > 0) continue;  // drawn already
      edges.push_back(Record::array({view.of(r.corner(k)), view.of(r.corner(nextCorner(k)))}));
    }
  }
  for (const auto places : {without, with}) {
    Record shown = Record::array();
    for (const Vec3 place : places) {
      if (place.z > 0) shown.push_back(view.of(place));
    }
    panels.push_back({{"places", std::move(shown)}, {"count", places.size()}});
  }
  return {{"kind", "places"}, {"px_per_m", view.px_per_m}, {"edges", edges}, {"panels", panels}};
}

}  // namespace haptics::eval
