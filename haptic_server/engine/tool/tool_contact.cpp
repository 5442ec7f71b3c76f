#include "haptic_server/engine/tool/tool_contact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "common/maths/rotation.h"
#include "haptic_server/engine/contact/neighborhood_watch.h"
#include "haptic_server/engine/contact/tolerances.h"
#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics {
namespace {

/// Poses that are tried in a tick. More let a fast tool come nearer to where it is to be in the same tick.
constexpr int kMaxPoseRounds = 16;
/// Times that the planes are taken anew at the pose found for them: rotation is not linear.
constexpr int kMaxTurns = 4;
/// Of the points one in so many is asked how far everything is from it, each time that the tool moves.
constexpr std::size_t kClearanceEvery = 8;
/// In a tick after one that did not come to its end, as many as take this part of the allowance.
constexpr double kForClearances = 0.4;
/// A search for a pose above planes costs this, and this for each of them; units of the allowance.
constexpr std::int64_t kStepUnits = 400, kStepUnitsOfPlane = 40;
/// Of the bend of the turn before: more is no convergence, and the planes alone are kept from there on.
constexpr double kConverging = 0.25;
/// A round turns the proxy by no more than this, rad: the planes are taken anew then.
constexpr double kMaxTurn_rad = 0.3;
/// Parts of a way that are tried where the allowance does not last for all points on the whole of it.
constexpr int kMaxHalvings = 10;
constexpr double kMinPart = 1.0 / (1 << kMaxHalvings);
/// Triangles that the search of a touching point may look at.
constexpr int kTouchBudget = 64;
/// A move that lowers the energy by less than this part of it is the last one of a tick.
constexpr double kRest = 1e-3;
/// Planes that a tick begins with: the lowest ones. Between two walls every point may have come to have planes on both, and to
/// follow them takes the whole allowance.
constexpr std::size_t kMaxPlanes = 128;
/// A pose is gone to if it lowers the energy by at least this part of that of the way to it. Over planes that do not turn it
/// falls by the whole.
constexpr double kDescent = 0.8;
/// So many skins farther from the device a pose may be than that: planes lift the points by a skin.
constexpr double kLifts = 16;

/// Twice the energy of all springs, J.
[[nodiscard]] double energy(const ToolPose& proxy, const ToolPose& device, const ToolCoupling& coupling) noexcept {
  const double opened = proxy.opening_rad - device.opening_rad;
  return coupling.stiffness_N_per_m * squaredLength(proxy.position - device.position) +
         coupling.torsion_Nm_per_rad * squaredLength(rotationVector(proxy.rotation * glm::conjugate(device.rotation))) +
         coupling.grip_Nm_per_rad * opened * opened;
}

[[nodiscard]] ToolPose between(const ToolPose& a, const ToolPose& b, double part) noexcept {
  return {interpolate(a, b, part), glm::mix(a.opening_rad, b.opening_rad, part)};
}

/// How far a rotation takes a place that is a metre from its axis at most.
[[nodiscard]] double chord(const Quat& from, const Quat& to) noexcept {
  const Quat turn = to * glm::conjugate(from);
  return 2 * glm::length(Vec3(turn.x, turn.y, turn.z));
}

/// The foot on a triangle's plane, as if it went on for ever.
[[nodiscard]] ClosestPoint onPlaneOf(const CollisionMesh& surface, std::uint32_t triangle, Vec3 at) noexcept {
  const Vec3 normal = surface.faceNormal(triangle);
  const double height = glm::dot(normal, at - surface.triangle(triangle).corner(0));
  return {triangle, Feature::kPolygon, 0, at - height * normal, height * height};
}

/// Of the triangles that meet where a point has its foot, on a line or vertex that bends away from it, the one that the point is
/// highest above. Another one is a wall to a point that comes over a flush seam.
[[nodiscard]] std::uint32_t farthestBelow(const CollisionMesh& surface, const ClosestPoint& foot, Vec3 at,
                                          int side) noexcept {
  const TriangleRecord& met = surface.triangle(foot.triangle);
  const double rounding_m = kStartOffset * surface.extent_m();
  const auto heightOver = [&](std::uint32_t t, Vec3 place) noexcept {
    return side * glm::dot(surface.faceNormal(t), place - foot.point);
  };
  std::uint32_t highest = foot.triangle;
  double height = heightOver(highest, at);
  const auto consider = [&](std::uint32_t t, int) noexcept {
    const bool bendsAway = heightOver(t, met.corner(0)) <= rounding_m && heightOver(t, met.corner(1)) <= rounding_m &&
                           heightOver(t, met.corner(2)) <= rounding_m;
    if (bendsAway && heightOver(t, at) > height) {
      highest = t;
      height = heightOver(t, at);
    }
    return true;
  };
  if (foot.feature == Feature::kVertex) {
    visitFan(surface, foot.triangle, foot.index, consider);
  } else if (met.neighbour(foot.index) != kNoTriangle) {
    consider(met.neighbour(foot.index), 0);
  }
  return highest;
}

[[nodiscard]] bool isSamePoints(std::span<const Vec3> a, std::span<const Vec3> b) noexcept {
  return a.size() == b.size() && (a.data() == b.data() || std::ranges::equal(a, b));
}

}  // namespace

void ToolMemory::clear() noexcept {
  cursor = wayTested = search = 0;
  waited = isOnWay = false;
  way = proxy = {};
  moved = travelled = skin = 0;
  bodiesPart = 1;
  testCost = kFirstTestCost;
  touches.count = bodies.count = clearTo.count = sharpClearTo.count = 0;
}

ToolPose ToolContact::Step::from(const ToolPose& pose, double part) const noexcept {
  return {glm::normalize(rotationBy(part * turn) * pose.rotation), pose.position + part * move,
          std::max(0.0, pose.opening_rad + part * open)};
}

Pose ToolContact::jawPose(const ToolPose& tool, std::size_t jaw) const noexcept {
  if (!scratch_.tool->jaws) return tool;
  const ToolJaws& jaws = *scratch_.tool->jaws;
  const Quat opened = rotationBy((jaw == 0 ? 0.5 : -0.5) * tool.opening_rad * jaws.axis);
  return {tool.rotation * opened, toWorld(tool, jaws.hinge_m - opened * jaws.hinge_m)};
}

ToolContact::Frames ToolContact::framesAt(const ToolPose& tool) const noexcept {
  Frames frames;
  frames.origin = tool.position;
  for (std::size_t jaw = 0; jaw < jawCount(); ++jaw) frames.jaw[jaw] = Frame(jawPose(tool, jaw));
  return frames;
}

void ToolContact::hold(const Tool& tool) noexcept {
  scratch_.tool = &tool;
  memory_.clear();
  memory_.clearTo.count = tool.shell.points.size();
}

/// @return How many of them are sharp points that are tested.
std::size_t ToolContact::listSharp(std::span<const Obstacle> obstacles) noexcept {
  std::size_t count = 0;
  for (std::size_t b = 0; b < obstacles.size(); ++b) {
    const std::span<const Vec3> sharp = obstacles[b].sharp;
    scratch_.sharp[b] = {count + sharp.size() <= kMaxSharpPoints ? sharp : std::span<const Vec3>(), count};
    count += scratch_.sharp[b].points.size();
  }
  return count;
}

bool ToolContact::connect(const Tool& tool, std::span<const Obstacle> obstacles) noexcept {
  scratch_.tool = &tool;
  return memory_.clearTo.count == tool.shell.points.size() && memory_.bodies.count == obstacles.size() &&
         memory_.sharpClearTo.count == listSharp(obstacles);
}

void ToolContact::adopt(std::span<const Obstacle> obstacles) noexcept {
  obstacles = obstacles.first(std::min(obstacles.size(), kMaxObstacles));
  const auto before = memory_.bodies;
  const auto sharpBefore = scratch_.sharp;
  bool isSame = obstacles.size() == before.count;
  memory_.isOnWay = false;
  memory_.wayTested = 0;
  memory_.bodies.count = obstacles.size();
  for (std::size_t b = 0; b < obstacles.size(); ++b) {
    const auto& [pose, sharp, origin] = obstacles[b];
    memory_.bodies[b] =
        origin < 0 ? ToolObstacleState{.at = pose, .isNew = true} : before[static_cast<std::size_t>(origin)];
    isSame = isSame && origin == static_cast<int>(b);
  }
  memory_.sharpClearTo.count = listSharp(obstacles);
  std::array<bool, kMaxObstacles> keepsSharp;  // the other bodies decide how many are tested, the narrowest tool which
  for (std::size_t b = 0; b < obstacles.size(); ++b) {
    keepsSharp[b] =
        obstacles[b].origin >= 0 &&
        isSamePoints(scratch_.sharp[b].points, sharpBefore[static_cast<std::size_t>(obstacles[b].origin)].points);
    isSame = isSame && keepsSharp[b];
  }
  if (isSame) return;
  std::size_t kept = 0;
  for (Touch touch : touches()) {
    const auto now = std::ranges::find(obstacles, static_cast<int>(touch.body), &Obstacle::origin);
    touch.body = static_cast<std::uint16_t>(now - obstacles.begin());
    if (now != obstacles.end() && (touch.ofBody == 0 || keepsSharp[touch.body])) memory_.touches[kept++] = touch;
  }
  memory_.touches.count = kept;
  memory_.cursor = 0;
  forgetClearances();
}

void ToolContact::reset(const ToolPose& device, std::span<const Body> bodies) noexcept {
  memory_.proxy = device;
  memory_.touches.count = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) memory_.bodies[b] = {.at = bodies[b].current};
  memory_.waited = memory_.isOnWay = false;
  memory_.bodiesPart = 1;
  forgetClearances();
}

void ToolContact::forgetClearances() noexcept {
  memory_.travelled = 0;
  std::ranges::fill(memory_.clearTo.all(), -1.0);
  std::ranges::fill(memory_.sharpClearTo.all(), -1.0);
  for (ToolObstacleState& body : memory_.bodies.all()) body.travelled = 0;
}

ToolResult ToolContact::follow(std::span<const Body> bodies, const ToolPose& device, const ToolCoupling& coupling,
                               Allowance allowance) noexcept {
  scratch_.hitCount = 0;  // those of the last tick may be of other bodies
  const ToolPose start = memory_.proxy;
  const double startEnergy = energy(start, device, coupling);
  seeWhatIsAround(bodies, allowance);
  gather(bodies, device);
  const bool bodiesRest = memory_.moved == 0;
  if (memory_.moved > 0) {
    ++memory_.search;
    memory_.isOnWay = false;
  }
  ToolResult result;
  if (memory_.waited && !memory_.isOnWay) {
    const auto left = static_cast<std::int64_t>((1 - kForClearances) * static_cast<double>(allowance.left()));
    renewClearances(bodies, pointCount(), left, allowance);
  }
  const bool arrived = memory_.moved == 0 || (memory_.bodiesPart == 1 && canTest(0, allowance));
  if (!arrived) bodies = takePartOfTheWay(bodies, allowance);
  bool settled = false, tried = memory_.isOnWay;
  if (memory_.isOnWay) continueWay(bodies, device, coupling, allowance);
  for (int round = 0; round < kMaxPoseRounds && !settled && !memory_.isOnWay && !allowance.isSpent(); ++round) {
    const double reach = farthestMove(device);
    refreshTouches(bodies, reach, allowance);
    if (round == 0) forgetHighTouches();
    ToolPose next = memory_.proxy;
    if (!solve(device, coupling, next, result, allowance)) break;
    double bound = farthestMove(next);
    const ToolPose end = next;
    double part = 1;
    bool isThere = canTest(bound, allowance);
    while (!isThere && part > kMinPart) {
      part /= 2;
      next = between(memory_.proxy, end, part);
      if (!canTest(farthestMove(next), allowance) || !keepAbovePlanes(coupling, next, allowance)) continue;
      bound = farthestMove(next);
      isThere = canTest(bound, allowance);
    }
    if (!isThere && memory_.moved == 0 && memory_.testCost == kCheapestTest) {
      // No later tick can test it at once either: this one begins, and the next ones continue.
      next = end;
      bound = farthestMove(end);
      part = 1;
      isThere = true;
    }
    if (!isThere || (part < 1 && !descends(next, device, coupling))) break;
    tried = true;
    if (isClear(bodies, next, bound, allowance)) {
      const double before = energy(memory_.proxy, device, coupling);
      moveTo(bodies, next, bound, allowance);
      settled =
          part == 1 && (memory_.touches.count == 0 || energy(memory_.proxy, device, coupling) >= (1 - kRest) * before);
    } else if (memory_.moved == 0 && scratch_.hitCount == 0) {  // the allowance is spent
      memory_.isOnWay = true;
      memory_.way = next;
      memory_.wayTested = scratch_.tested;
    } else if (!addHits()) {
      // Half of the way to the hit, unless it is there already: so near to a surface rounding would take it through.
      if (scratch_.lowestHit < memory_.skin / 2) break;
      const ToolPose before = between(memory_.proxy, next, scratch_.firstHit / 2);
      const double partly = farthestMove(before);
      if (!isClear(bodies, before, partly, allowance)) break;
      moveTo(bodies, before, partly, allowance);
    }
  }
  if (settled && bodiesRest && energy(memory_.proxy, device, coupling) > startEnergy) moveBackTo(start);
  if (!tried)
    memory_.testCost =
        std::max(kCheapestTest, memory_.testCost / 2);  // too dear to be tried: it may have become cheaper
  result.proxy = memory_.proxy;
  result.force_N = coupling.stiffness_N_per_m * (memory_.proxy.position - device.position);
  result.torque_Nm =
      coupling.torsion_Nm_per_rad * rotationVector(memory_.proxy.rotation * glm::conjugate(device.rotation));
  result.grip_Nm = coupling.grip_Nm_per_rad * (memory_.proxy.opening_rad - device.opening_rad);
  memory_.bodiesPart =
      memory_.moved == 0 ? std::min(1.0, 2 * memory_.bodiesPart) : std::max(kMinPart, memory_.bodiesPart / 2);
  result.waits = !settled || !arrived;
  memory_.waited = result.waits;
  if (!memory_.waited || memory_.proxy != start) ++memory_.search;
  result.allowance = allowance;
  return result;
}

int ToolContact::touching() const noexcept {
  const Frames tool = framesAt(memory_.proxy);
  return static_cast<int>(std::ranges::count_if(
      touches(), [&](const Touch& touch) { return height(touch, tool) < kTouchMargin * memory_.skin; }));
}

/// Continues the test of a way that the last tick did not come to the end of, if it is one that the device still pulls to.
void ToolContact::continueWay(std::span<const Body> bodies, const ToolPose& device, const ToolCoupling& coupling,
                              Allowance& allowance) noexcept {
  const double bound = farthestMove(memory_.way);
  memory_.isOnWay = descends(memory_.way, device, coupling);
  if (!memory_.isOnWay) return;
  const bool clear = isClear(bodies, memory_.way, bound, allowance, memory_.wayTested);
  if (!clear && scratch_.hitCount == 0) {
    memory_.wayTested = scratch_.tested;
    return;
  }
  memory_.isOnWay = false;
  if (clear)
    moveTo(bodies, memory_.way, bound, allowance);
  else
    static_cast<void>(addHits());
}

/// The skin by the largest coordinate in reach, and how far bodies have come since the proxy moved last.
void ToolContact::gather(std::span<const Body> bodies, const ToolPose& device) noexcept {
  double extent =
      std::max(glm::length(device.position), glm::length(memory_.proxy.position)) + scratch_.tool->shell.radius_m;
  memory_.moved = farthestMove(bodies);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (isFelt(bodies, b) && isNear(bodies[b], scratch_.bodyMoved[b])) extent = std::max(extent, bodies[b].extent_m);
  }
  memory_.skin = kSkin * extent;
}

/// Was the body, on a way of this length to where it is, ever within what is looked for about the tool?
bool ToolContact::isNear(const Body& body, double moved) const noexcept {
  const double reach = body.surface->radius_m() + scratch_.tool->shell.radius_m + kFarthestClearance_m + moved;
  return squaredLength(body.centre - memory_.proxy.position) < reach * reach;
}

/// Of the bodies that are near. The others leave what is known of the tool's points as it is: that is less than they are away.
double ToolContact::farthestMove(std::span<const Body> bodies) noexcept {
  double moved = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    scratch_.bodyMoved[b] = 0;
    if (body.pendingRemoval || body.current == memory_.bodies[b].at) continue;
    scratch_.bodyMoved[b] = glm::distance(body.current.position, memory_.bodies[b].at.position) +
                            chord(memory_.bodies[b].at.rotation, body.current.rotation) * body.surface->extent_m();
    if (isFelt(bodies, b) && isNear(body, scratch_.bodyMoved[b])) moved = std::max(moved, scratch_.bodyMoved[b]);
  }
  return moved;
}

/// Where the allowance does not last for where the bodies have come, or no pose was found there in the last tick, they come a
/// part of the way in this tick.
std::span<const Body> ToolContact::takePartOfTheWay(std::span<const Body> bodies, const Allowance& allowance) noexcept {
  for (double part = memory_.bodiesPart; part >= kMinPart; part /= 2) {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      scratch_.here[b] = bodies[b];
      scratch_.here[b].current = interpolate(memory_.bodies[b].at, bodies[b].current, part);
      scratch_.here[b].update();
    }
    memory_.moved = farthestMove({scratch_.here.data(), bodies.size()});
    if (canTest(memory_.moved, allowance)) break;  // the tool goes as far as they do
  }
  return {scratch_.here.data(), bodies.size()};
}

/// Follows the points that touch over the surfaces, and takes their planes. Those that are farther than the tool can come
/// are let go of.
void ToolContact::refreshTouches(std::span<const Body> bodies, double reach, Allowance& allowance) noexcept {
  const Frames tool = framesAt(memory_.proxy);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < memory_.touches.count; ++i) {
    Touch touch = memory_.touches[i];
    if (!isFelt(bodies, touch.body)) continue;
    if (!allowance.isSpent()) {
      refreshTouch(bodies[touch.body], tool, touch, allowance);
      if (touch.ofBody && bodies.size() > 1 && isFlushWithHeld(bodies, touch.body, touch.place, allowance)) continue;
      if (height(touch, tool) > reach + kTouchMargin * memory_.skin) continue;
      if (kept > 0 && memory_.touches[kept - 1].isOf(touch) && memory_.touches[kept - 1].triangle == touch.triangle)
        continue;
    }
    memory_.touches[kept++] = touch;
  }
  memory_.touches.count = kept;
}

/// Keeps no more than kMaxPlanes. A point that is forgotten hits its plane again before it passes it.
void ToolContact::forgetHighTouches() noexcept {
  if (memory_.touches.count <= kMaxPlanes) return;
  const Frames tool = framesAt(memory_.proxy);
  std::array<double, kMaxHalfSpaces> heights;
  for (std::size_t i = 0; i < memory_.touches.count; ++i) heights[i] = height(memory_.touches[i], tool);
  std::array<std::uint16_t, kMaxHalfSpaces> order;
  const auto all = std::span(order).first(memory_.touches.count);
  std::iota(all.begin(), all.end(), std::uint16_t{0});
  // Of points at one height the first ones: those of a flat side lie at one.
  std::ranges::nth_element(all, all.begin() + kMaxPlanes, {},
                           [&](std::uint16_t i) { return std::pair(heights[i], i); });
  const auto lowest = all.first(kMaxPlanes);
  std::ranges::sort(lowest);
  for (std::size_t k = 0; k < kMaxPlanes; ++k) memory_.touches[k] = memory_.touches[lowest[k]];
  memory_.touches.count = kMaxPlanes;
}

void ToolContact::refreshTouch(const Body& body, const Frames& tool, Touch& touch,
                               Allowance& allowance) const noexcept {
  const std::size_t jaw = jawOf(touch);
  const CollisionMesh& surface = touch.ofBody ? jawSurface(jaw) : *body.surface;
  if (touch.ofBody) touch.place = body.frame.toWorld(scratch_.sharp[touch.body].points[touch.point]);
  const Vec3 at = touch.ofBody ? toLocal(jawPose(memory_.proxy, jaw), touch.place)
                               : body.frame.toLocal(tool.jaw[jaw].toWorld(point(touch.point)));
  const std::int64_t affordable = 1 + allowance.left() / Allowance::kNearTriangle;
  SearchRun run{.budget = static_cast<int>(std::min<std::int64_t>(kTouchBudget, affordable))};
  const ClosestPoint foot = touch.hitIn == memory_.search ? onPlaneOf(surface, touch.triangle, at)
                                                          : neighborhoodWatch(surface, touch.triangle, at, run).foot;
  allowance.spend(Allowance::kNearTriangle * (run.looked + 1));
  touch.triangle = foot.triangle;
  const double distance = std::sqrt(foot.squaredDistance);
  if (foot.feature != Feature::kPolygon && touch.hitIn != memory_.search)
    touch.triangle = farthestBelow(surface, foot, at, touch.side);
  touch.normal = surface.faceNormal(touch.triangle) * static_cast<double>(touch.side);
  if (foot.feature != Feature::kPolygon && distance > kTouchMargin * memory_.skin &&
      surface.isOutside(foot, at, touch.side))
    touch.normal = (at - foot.point) / distance;
  touch.offset = glm::dot(touch.normal, foot.point);
  if (touch.ofBody) return;
  touch.normal = body.frame.rotate(touch.normal);
  touch.offset = glm::dot(touch.normal, body.frame.toWorld(foot.point));
}

/// Of the point above its plane, with the tool there; m.
double ToolContact::height(const Touch& touch, const Frames& tool) const noexcept {
  const Frame& jaw = tool.jaw[jawOf(touch)];
  const Vec3 at = touch.ofBody ? jaw.toLocal(touch.place) : jaw.toWorld(point(touch.point));
  return glm::dot(touch.normal, at) - touch.offset;
}

/// The pose nearest to the device's in which all that touch are a skin above their planes, or one on the way to it, and the
/// points that hold it there. False: there is none, or it was not found.
bool ToolContact::solve(const ToolPose& device, const ToolCoupling& coupling, ToolPose& next, ToolResult& result,
                        Allowance& allowance) noexcept {
  LeastDistance held;
  bool lifts = true;
  ToolPose first = memory_.proxy;
  double lastBend = std::numeric_limits<double>::infinity();
  for (int turn = 0;; ++turn) {
    Step step = stepTowards(device, coupling, next, lifts, allowance);
    if (!step.nearest.exists && lifts) {  // jammed, in less room than a skin on every side
      lifts = false;
      step = stepTowards(device, coupling, next, lifts, allowance);
    }
    if (!step.nearest.exists) return false;
    const double angle = step.angle_rad();
    const double part = std::min(1.0, kMaxTurn_rad / angle);
    const double bend = bendOf(part * angle);
    const bool converges = bend <= kConverging * lastBend;
    bool ends = false;
    if (converges) {
      held = step.nearest;
      next = step.from(next, part);
      if (turn == 0) first = next;
      ends = bend < kConstraintTolerance * memory_.skin;
    }
    if (ends && descends(next, device, coupling)) break;
    lastBend = bend;
    if (!ends && converges && part == 1 && turn + 1 < kMaxTurns) continue;
    double whole = 1;
    while (!keepAbovePlanes(coupling, next, allowance) || !descends(next, device, coupling)) {
      next = whole < kMinPart ? memory_.proxy : between(memory_.proxy, first, whole);
      if (whole < kMinPart) {
        if (memory_.moved > 0) return false;
        break;  // it is where it can be
      }
      whole /= 4;
    }
    break;
  }
  describeHeld(held, next, result);
  return true;
}

/// Is the pose nearer to the device's than the proxy, by the energy, and no farther away than it has to be? Only bodies that
/// move push the tool away from where the device pulls it. Far from the device the first order may, or take it across a flat
/// valley of the energy.
bool ToolContact::descends(const ToolPose& next, const ToolPose& device, const ToolCoupling& coupling) const noexcept {
  if (memory_.moved > 0) return true;
  const double most = std::sqrt(energy(memory_.proxy, device, coupling)) +
                      kLifts * memory_.skin * std::sqrt(coupling.stiffness_N_per_m);
  return energy(next, device, coupling) + kDescent * energy(next, memory_.proxy, coupling) <= most * most;
}

/// Moves a pose as little as brings all that touch a skin above their planes, or as high as they are now. False: that was not
/// found.
bool ToolContact::keepAbovePlanes(const ToolCoupling& coupling, ToolPose& pose, Allowance& allowance) noexcept {
  const ToolPose target = pose;
  double lastBend = std::numeric_limits<double>::infinity();
  for (int turn = 0; turn < kMaxTurns; ++turn) {
    const Step step = stepTowards(target, coupling, pose, false, allowance);
    const double bend = bendOf(step.angle_rad());
    if (!step.nearest.exists || bend > kConverging * lastBend) return false;
    pose = step.from(pose);
    if (bend < kConstraintTolerance * memory_.skin) return true;
    lastBend = bend;
  }
  return false;
}

/// From a pose to the one nearest to the target's, by the coupling's energy, that is above all planes: to first order.
/// @param lifts  By a skin; else by no more than the proxy is.
/// @return None, too, where the allowance does not last for it.
ToolContact::Step ToolContact::stepTowards(const ToolPose& target, const ToolCoupling& coupling, const ToolPose& pose,
                                           bool lifts, Allowance& allowance) noexcept {
  const std::int64_t units = kStepUnits + kStepUnitsOfPlane * static_cast<std::int64_t>(memory_.touches.count);
  if (units > allowance.left()) return {{.exists = false}, Vec3(0), Vec3(0)};
  allowance.spend(units);
  const double perMove = 1 / std::sqrt(coupling.stiffness_N_per_m);
  const double perTurn = 1 / std::sqrt(coupling.torsion_Nm_per_rad);
  const Vec3 move = target.position - pose.position;
  const Vec3 turn = rotationVector(target.rotation * glm::conjugate(pose.rotation));
  const Frames frames = framesAt(pose), now = framesAt(memory_.proxy);
  for (std::size_t i = 0; i < memory_.touches.count; ++i) {
    const Touch& touch = memory_.touches[i];
    const Frame& frame = frames.jaw[jawOf(touch)];
    const Vec3 arm =
        touch.ofBody ? touch.place - frames.origin : frame.rotate(point(touch.point)) + (frame.origin - frames.origin);
    const Vec3 push = touch.ofBody ? -frame.rotate(touch.normal) : touch.normal;  // on the tool
    const Vec3 lever = glm::cross(arm, push);
    const Vec3 a = push * perMove, b = lever * perTurn;
    const double least = lifts ? memory_.skin : std::min(memory_.skin, height(touch, now));
    scratch_.halfSpaces[i] = {{a.x, a.y, a.z, b.x, b.y, b.z, 0},
                              least - height(touch, frames) - glm::dot(push, move) - glm::dot(lever, turn)};
  }
  const std::span planes = std::span(scratch_.halfSpaces).first(memory_.touches.count);
  Step step{scratch_.tool->jaws ? nearestOpened(target, coupling, pose) : leastDistance(planes), move, turn};
  step.move += perMove * Vec3(step.nearest.x[0], step.nearest.x[1], step.nearest.x[2]);
  step.turn += perTurn * Vec3(step.nearest.x[3], step.nearest.x[4], step.nearest.x[5]);
  if (scratch_.tool->jaws)
    step.open = target.opening_rad - pose.opening_rad + step.nearest.x[6] / std::sqrt(coupling.grip_Nm_per_rad);
  return step;
}

/// With the opening as a seventh freedom of the planes that stepTowards() has taken at the pose, and closed jaws as a stop.
LeastDistance ToolContact::nearestOpened(const ToolPose& target, const ToolCoupling& coupling,
                                         const ToolPose& pose) noexcept {
  const ToolJaws& jaws = *scratch_.tool->jaws;
  const double perOpen = 1 / std::sqrt(coupling.grip_Nm_per_rad), perTurn = 1 / std::sqrt(coupling.torsion_Nm_per_rad),
               perMove = 1 / std::sqrt(coupling.stiffness_N_per_m);
  const double open = target.opening_rad - pose.opening_rad;
  const Vec3 hinge = pose.rotation * jaws.hinge_m, axis = pose.rotation * jaws.axis;
  std::size_t count = memory_.touches.count;
  for (std::size_t i = 0; i < count; ++i) {
    auto& [normal, offset] = scratch_.halfSpaces[i];
    const Vec3 push = Vec3(normal[0], normal[1], normal[2]) / perMove;
    const Vec3 lever = Vec3(normal[3], normal[4], normal[5]) / perTurn - glm::cross(hinge, push);
    const double grip = (jawOf(memory_.touches[i]) == 0 ? 0.5 : -0.5) * glm::dot(axis, lever);
    normal[6] = grip * perOpen;
    offset -= grip * open;
  }
  if (count < scratch_.halfSpaces.size())
    scratch_.halfSpaces[count++] = {{0, 0, 0, 0, 0, 0, perOpen}, -pose.opening_rad - open};
  return leastDistance<7>(std::span(scratch_.halfSpaces).first(count));
}

/// In the coordinates of solve() a multiplier is the force along its normal: K_t (p - p_d) = sum of m_i n_i.
void ToolContact::describeHeld(const LeastDistance& nearest, const ToolPose& next, ToolResult& result) const noexcept {
  const Frames frames = framesAt(next);
  result.heldCount = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(nearest.tightCount); ++i) {
    if (nearest.tight[i] >= memory_.touches.count || result.heldCount == result.held.size()) continue;  // the stop
    const Touch& touch = memory_.touches[nearest.tight[i]];
    const Frame& frame = frames.jaw[jawOf(touch)];
    const Vec3 push = touch.ofBody ? -frame.rotate(touch.normal) : touch.normal;
    result.held[result.heldCount++] = {touch.body, touch.ofBody ? kNoTriangle : touch.triangle,
                                       touch.ofBody ? touch.place : frame.toWorld(point(touch.point)),
                                       nearest.multiplier[i] * push};
  }
}

double ToolContact::farthestMove(const ToolPose& next) const noexcept {
  const double turned =
      chord(memory_.proxy.rotation, next.rotation) + std::abs(next.opening_rad - memory_.proxy.opening_rad) / 2;
  return glm::distance(memory_.proxy.position, next.position) + turned * scratch_.tool->shell.radius_m;
}

void ToolContact::moveTo(std::span<const Body> bodies, const ToolPose& next, double bound,
                         Allowance& allowance) noexcept {
  memory_.proxy = next;
  memory_.travelled += memory_.moved + bound;
  memory_.moved = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    memory_.bodies[b].at = bodies[b].current;
    memory_.bodies[b].travelled += scratch_.bodyMoved[b] + bound;
    scratch_.bodyMoved[b] = 0;
  }
  const std::size_t all = pointCount();
  renewClearances(bodies, (all + kClearanceEvery - 1) / kClearanceEvery, 0, allowance);
}

/// To where it has come from in this tick, on the same way: planes lift the points by a skin, and without this a tool between
/// two edges would be lifted by the one and the other for ever. While the device rests the energy falls, until the tool does.
void ToolContact::moveBackTo(const ToolPose& start) noexcept {
  const double bound = farthestMove(start);
  memory_.travelled += bound;
  for (std::size_t b = 0; b < memory_.bodies.count; ++b) memory_.bodies[b].travelled += bound;
  memory_.proxy = start;
}

}  // namespace haptics
