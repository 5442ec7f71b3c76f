#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "common/telemetry/motion_state.h"
#include "haptic_server/engine/contact/body.h"
#include "haptic_server/engine/geometry/allowance.h"
#include "haptic_server/engine/tool/least_distance.h"
#include "haptic_server/engine/tool/tool_shell.h"

namespace haptics {

/// How a tool is held to its device.
struct ToolCoupling {
  static constexpr double kMin = 1e-6;  ///< Of each; a hand feels nothing of it.

  double stiffness_N_per_m = 800;
  double torsion_Nm_per_rad = 1;
  double grip_Nm_per_rad = 1;  ///< Of the opening, of one that has jaws.
};

/// Where a tool is, and how far its jaws are open: 0 of one that has none.
struct ToolPose : Pose {
  double opening_rad = 0;

  ToolPose() noexcept = default;
  ToolPose(const Quat& turned, const Vec3& at, double open_rad = 0) noexcept
      : Pose{turned, at}, opening_rad(open_rad) {}
  ToolPose(const Pose& pose, double open_rad = 0) noexcept : Pose(pose), opening_rad(open_rad) {}
  bool operator==(const ToolPose&) const = default;
  HAPTICS_FIELDS(self.rotation, self.position, self.opening_rad);
};

/// A point that a surface holds, of those that decide where the proxy is.
struct ToolPoint {
  std::size_t body = 0;        ///< Index into bodies.
  std::uint32_t triangle = 0;  ///< Of the body's mesh; kNoTriangle: a sharp point of the body, on the tool's.
  Vec3 place{0};               ///< World.
  Vec3 force_N{0};             ///< On the tool.
};

struct ToolResult {
  ToolPose proxy;       ///< Of the tool, world: it passes nothing.
  Vec3 force_N{0};      ///< On the hand.
  Vec3 torque_Nm{0};    ///< On the hand, about the proxy's origin.
  double grip_Nm = 0;   ///< On the hand: it opens the device's gripper where it is above 0.
  bool waits = false;   ///< The allowance or the rounds ended before the proxy was where it is to be.
  Allowance allowance;  ///< What is left.
  std::size_t heldCount = 0;
  std::array<ToolPoint, ToolState::kMaxPoints>
      held;  ///< Their forces add up to the force, their torques to the torque.
};

/// Bodies that a tool may meet.
inline constexpr std::size_t kMaxObstacles = 256;
/// Sharp points of all bodies together; those of further bodies are left out.
inline constexpr std::size_t kMaxSharpPoints = 16'384;

/// A point on a surface: of the tool on a body's, or a sharp one of a body on the tool's.
struct ToolTouch {
  std::uint32_t ofBody = 0;  ///< 1: of the body; 2: likewise, on the tool's lower jaw.
  std::uint16_t point = 0;
  std::uint16_t body = 0;
  std::uint32_t triangle = 0;  ///< Of the surface.
  std::int32_t side = 1;
  std::uint64_t hitIn = 0;  ///< Search: until it ends, the point stays above this triangle.
  Vec3 place{0};            ///< Of a body's point, world.
  Vec3 normal{0};           ///< Of the plane above which the point stays: world, or the tool's frame.
  double offset = 0;        ///< m

  HAPTICS_FIELDS(self.ofBody, self.point, self.body, self.triangle, self.side, self.hitIn, self.place, self.normal,
                 self.offset);

  [[nodiscard]] bool isOf(const ToolTouch& other) const noexcept {
    return ofBody == other.ofBody && point == other.point && body == other.body;
  }
};

/// A body, for a tool.
struct ToolObstacleState {
  Pose at;                   ///< When the proxy moved last.
  double travelled = 0;      ///< m, at most, of the tool against it from ToolContact::adopt() to the proxy's last move.
  Word<bool> isNew = false;  ///< It came while the tool was held: whether onto the tool, is looked for.
  Word<bool> isAround = false;  ///< It came onto the tool, and is not felt before the tool is clear of it.
  std::uint64_t next = 0;       ///< Point of the tool that is looked at next for that.
  std::uint64_t clear = 0;      ///< So many before that one, one after another, are not in it.

  HAPTICS_FIELDS(self.at, self.travelled, self.isNew, self.isAround, self.next, self.clear);
};

/// What a tool remembers from tick to tick.
struct ToolMemory {
  static constexpr double kFirstTestCost = 500;

  std::uint64_t cursor = 0;     ///< The point whose clearance is next.
  Word<bool> waited = false;    ///< In the last tick.
  Word<bool> isOnWay = false;   ///< A way was not tested to its end in the last tick: it is continued.
  std::uint64_t wayTested = 0;  ///< From this point on, of the tool's, then of the bodies'.
  ToolPose way;                 ///< Where it leads.
  ToolPose proxy;
  double moved = 0;                  ///< m, at most, of any body that is near since the proxy moved last.
  double travelled = 0;              ///< m, at most, of any point against bodies that are near, as ToolObstacleState's.
  double bodiesPart = 1;             ///< Of the way of bodies that a tick tries.
  double testCost = kFirstTestCost;  ///< Units of the allowance; follows what tests cost.
  std::uint64_t search = 0;          ///< Counts; goes on through ticks in which neither the proxy nor a body moves.
  double skin = 0;                   ///< m
  Sequence<ToolTouch, kMaxHalfSpaces> touches;
  Sequence<ToolObstacleState, kMaxObstacles> bodies;
  Sequence<double, kMaxToolPoints> clearTo;        ///< `travelled` until which a point can meet nothing.
  Sequence<double, kMaxSharpPoints> sharpClearTo;  ///< Of a body likewise.

  HAPTICS_FIELDS(self.cursor, self.waited, self.isOnWay, self.wayTested, self.way, self.proxy, self.moved,
                 self.travelled, self.bodiesPart, self.testCost, self.search, self.skin, self.touches, self.bodies,
                 self.clearTo, self.sharpClearTo);

  /// No tool is held.
  void clear() noexcept;
};

/// What a tool works with: it follows from the scene, or is of a tick.
struct ToolScratch {
  /// Of a body.
  struct Sharp {
    std::span<const Vec3> points;
    std::size_t first = 0;  ///< Of them, in ToolMemory::sharpClearTo.
  };
  static constexpr std::size_t kMaxHits = 64;

  const Tool* tool = nullptr;
  std::array<Sharp, kMaxObstacles> sharp;

  std::size_t tested = 0;  ///< Points of a way, those that need no test too.
  std::size_t hitCount = 0;
  double firstHit = 1;   ///< Fraction of the way.
  double lowestHit = 0;  ///< Of the points that hit, above what they hit, before; m.
  std::array<ToolTouch, kMaxHits> hits;
  std::array<double, kMaxObstacles> bodyMoved;  ///< m, at most, since the proxy moved last.
  std::array<Body, kMaxObstacles> here;         ///< Bodies that come a part of their way.
  std::array<HalfSpace, kMaxHalfSpaces> halfSpaces;
};

/// A tool of many points: its proxy is the pose nearest to the device's, with the opening of its jaws, measured by the
/// coupling's energy, to which it comes on a way on which no point of the shell passes a surface of a body, and no sharp point of
/// a body the tool's
/// (Ortega, Redon & Coquillart 2007, with Gauss' least constraint over the planes of points that touch; the guard and the
/// neighborhood watch are those of the point contact). All that lasts is in its memory: a copy of that goes on exactly like the
/// original. Nothing here allocates or locks.
class ToolContact {
 public:
  /// What the tool may meet.
  struct Obstacle {
    Pose pose;
    /// sharpPoints() at the tool's spacing, body frame: what is thin enough to come between two of its points has some.
    std::span<const Vec3> sharp;
    /// The place that it had among those before, with the same surface; -1: it is new, and pushes only what comes to it from
    /// outside; where it came onto the tool, nothing before the tool is clear of it.
    int origin = -1;
  };

  ToolContact(ToolMemory& memory, ToolScratch& scratch) noexcept : memory_(memory), scratch_(scratch) {}

  /// The hand holds this tool from now on, which has to live as long; reset() comes next.
  void hold(const Tool& tool) noexcept;
  /// The tool and its obstacles' sharp points, as hold() and adopt() have them: for a memory that goes on from a copy.
  /// @return False: they are not as many as those of the memory.
  [[nodiscard]] bool connect(const Tool& tool, std::span<const Obstacle> obstacles) noexcept;
  /// The obstacles are these from now on, at most kMaxObstacles, whose sharp points have to live as long.
  void adopt(std::span<const Obstacle> obstacles) noexcept;
  /// The proxy is put there, and touches nothing. Bodies as for follow().
  void reset(const ToolPose& device, std::span<const Body> bodies) noexcept;

  /// One tick. Bodies are those of the obstacles, at their poses now; those that move push the proxy. Those that are pending
  /// removal are not there.
  /// @param device  Its opening is not negative.
  [[nodiscard]] ToolResult follow(std::span<const Body> bodies, const ToolPose& device, const ToolCoupling& coupling,
                                  Allowance allowance = {}) noexcept;
  [[nodiscard]] int touching() const noexcept;  ///< Points that surfaces hold after the last tick.

 private:
  using Touch = ToolTouch;

  static constexpr double kFarthestClearance_m = 0.05;  // nothing is looked for farther away
  static constexpr double kCheapestTest = 100;  // what a point's test is taken to cost at least; units of the allowance

  /// A move of the tool.
  struct Step {
    LeastDistance nearest;
    Vec3 move, turn;
    double open = 0;

    /// At most, of any part, rad.
    [[nodiscard]] double angle_rad() const noexcept { return glm::length(turn) + std::abs(open) / 2; }
    /// A part of it, from a pose on.
    [[nodiscard]] ToolPose from(const ToolPose& pose, double part = 1) const noexcept;
  };

  /// Where the tool's jaws are; of one that has none the first alone, which is all of it.
  struct Frames {
    std::array<Frame, 2> jaw;
    Vec3 origin;  // of the tool
  };

  ToolMemory& memory_;
  ToolScratch& scratch_;

  [[nodiscard]] std::span<Touch> touches() const noexcept { return memory_.touches.all(); }
  [[nodiscard]] Vec3 point(std::size_t i) const noexcept { return scratch_.tool->shell.points[i]; }
  [[nodiscard]] std::size_t jawCount() const noexcept { return scratch_.tool->jaws ? 2 : 1; }
  [[nodiscard]] const CollisionMesh& jawSurface(std::size_t jaw) const noexcept {
    return jaw == 0 ? *scratch_.tool->surface : *scratch_.tool->jaws->lower;
  }
  /// Of which a point of the shell is.
  [[nodiscard]] std::size_t jawOf(std::size_t point) const noexcept {
    return scratch_.tool->jaws && point >= scratch_.tool->jaws->firstOfLower ? 1 : 0;
  }
  [[nodiscard]] std::size_t jawOf(const Touch& touch) const noexcept {
    return touch.ofBody != 0 ? touch.ofBody - 1 : jawOf(std::size_t{touch.point});
  }
  [[nodiscard]] Pose jawPose(const ToolPose& tool, std::size_t jaw) const noexcept;
  [[nodiscard]] Frames framesAt(const ToolPose& tool) const noexcept;
  [[nodiscard]] std::size_t pointCount() const noexcept { return memory_.clearTo.count + memory_.sharpClearTo.count; }
  std::size_t listSharp(std::span<const Obstacle> obstacles) noexcept;
  void forgetClearances() noexcept;
  void refreshTouch(const Body& body, const Frames& tool, Touch& touch, Allowance& allowance) const noexcept;
  void forgetHighTouches() noexcept;
  [[nodiscard]] double height(const Touch& touch, const Frames& tool) const noexcept;
  [[nodiscard]] std::int64_t testPoints(std::span<const Body> bodies, const Frames& tool, double bound,
                                        Allowance& allowance) noexcept;
  [[nodiscard]] Crossing crossingBesideGaps(std::span<const Body> bodies, std::size_t index, Vec3 from, Vec3 to,
                                            Allowance& allowance) const noexcept;
  [[nodiscard]] std::int64_t testBodysPoints(std::span<const Body> bodies, const Frames& tool, double bound,
                                             Allowance& allowance) noexcept;
  void testOnLowerJaw(std::span<const Body> bodies, std::size_t b, std::size_t j, const Frames& tool,
                      Allowance& allowance) noexcept;
  [[nodiscard]] bool isFlushWithHeld(std::span<const Body> bodies, std::size_t index, const Vec3& place,
                                     Allowance& allowance) const noexcept;
  void addHit(const Touch& hit, double time, double height) noexcept;
  [[nodiscard]] bool isFelt(std::span<const Body> bodies, std::size_t b) const noexcept {
    return !bodies[b].pendingRemoval && !memory_.bodies[b].isAround;
  }
  void seeWhatIsAround(std::span<const Body> bodies, Allowance& allowance) noexcept;
  [[nodiscard]] std::optional<bool> isIn(const Body& body, ToolObstacleState& state, std::int64_t keep,
                                         Allowance& allowance) const noexcept;
  void gather(std::span<const Body> bodies, const ToolPose& device) noexcept;
  void refreshTouches(std::span<const Body> bodies, double reach, Allowance& allowance) noexcept;
  [[nodiscard]] bool solve(const ToolPose& device, const ToolCoupling& coupling, ToolPose& next, ToolResult& result,
                           Allowance& allowance) noexcept;
  [[nodiscard]] bool descends(const ToolPose& next, const ToolPose& device,
                              const ToolCoupling& coupling) const noexcept;
  [[nodiscard]] bool keepAbovePlanes(const ToolCoupling& coupling, ToolPose& pose, Allowance& allowance) noexcept;
  [[nodiscard]] Step stepTowards(const ToolPose& target, const ToolCoupling& coupling, const ToolPose& pose, bool lifts,
                                 Allowance& allowance) noexcept;
  [[nodiscard]] LeastDistance nearestOpened(const ToolPose& target, const ToolCoupling& coupling,
                                            const ToolPose& pose) noexcept;
  [[nodiscard]] double bendOf(double angle_rad) const noexcept {
    return angle_rad * angle_rad * scratch_.tool->shell.radius_m;
  }
  void describeHeld(const LeastDistance& nearest, const ToolPose& next, ToolResult& result) const noexcept;
  [[nodiscard]] bool isNear(const Body& body, double moved) const noexcept;
  [[nodiscard]] double farthestMove(std::span<const Body> bodies) noexcept;
  [[nodiscard]] std::span<const Body> takePartOfTheWay(std::span<const Body> bodies,
                                                       const Allowance& allowance) noexcept;
  [[nodiscard]] double farthestMove(const ToolPose& next) const noexcept;
  [[nodiscard]] bool isClear(std::span<const Body> bodies, const ToolPose& next, double bound, Allowance& allowance,
                             std::size_t from = 0) noexcept;
  void continueWay(std::span<const Body> bodies, const ToolPose& device, const ToolCoupling& coupling,
                   Allowance& allowance) noexcept;
  void moveTo(std::span<const Body> bodies, const ToolPose& next, double bound, Allowance& allowance) noexcept;
  void moveBackTo(const ToolPose& start) noexcept;
  [[nodiscard]] double clearance(std::span<const Body> bodies, Vec3 place, Allowance& allowance) const noexcept;
  [[nodiscard]] bool addHits() noexcept;
  [[nodiscard]] std::int64_t testsWithin(double bound) const noexcept;
  [[nodiscard]] bool canTest(double bound, const Allowance& allowance) const noexcept;
  void learnTestCost(std::int64_t tests, std::int64_t spent) noexcept;
  void renewClearances(std::span<const Body> bodies, std::size_t count, std::int64_t keep,
                       Allowance& allowance) noexcept;
};

static_assert(std::is_trivially_copyable_v<ToolMemory> && fields::isListed<ToolMemory>());

struct ToolStorage {
  ToolMemory memory;
  ToolScratch scratch;
};

/// With a memory of its own.
class StandaloneTool : private ToolStorage, public ToolContact {
 public:
  StandaloneTool() noexcept : ToolContact(memory, scratch) {}
  StandaloneTool(const StandaloneTool& other) noexcept : ToolStorage(other), ToolContact(memory, scratch) {}
  StandaloneTool& operator=(const StandaloneTool& other) noexcept {
    ToolStorage::operator=(other);
    return *this;
  }

  /// Goes on from there, without what is beyond its counts.
  void copyInUse(const ToolMemory& from, const ToolScratch& with) noexcept {
    haptics::copyInUse(memory, from);
    scratch.tool = with.tool;
    scratch.sharp = with.sharp;
  }
  [[nodiscard]] const ToolPose& proxy() const noexcept { return memory.proxy; }
  /// Where the proxy is clear of a body: the body's own, or behind it after a tick that waited.
  [[nodiscard]] const Pose& testedAt(std::size_t body) const { return memory.bodies[body].at; }
};

}  // namespace haptics
