#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "common/telemetry/motion_state.h"
#include "haptic_server/contact/body.h"
#include "haptic_server/geometry/allowance.h"
#include "haptic_server/tool/least_distance.h"
#include "haptic_server/tool/tool_shell.h"

namespace haptics {

/// How a tool is held to its device; both positive.
struct ToolCoupling {
  double stiffness_N_per_m = 800;
  double torsion_Nm_per_rad = 1;
};

/// A point that a surface holds, of those that decide where the proxy is.
struct ToolPoint {
  std::size_t body = 0;        ///< Index into bodies.
  std::uint32_t triangle = 0;  ///< Of the body's mesh; kNoTriangle: a sharp point of the body, on the tool's.
  Vec3 place{0};               ///< World.
  Vec3 force_N{0};             ///< On the tool.
};

struct ToolResult {
  Pose proxy;           ///< Of the tool, world: it passes nothing.
  Vec3 force_N{0};      ///< On the hand.
  Vec3 torque_Nm{0};    ///< On the hand, about the proxy's origin.
  int touching = 0;     ///< Points that surfaces hold.
  bool waits = false;   ///< The allowance or the rounds ended before the proxy was where it is to be.
  Allowance allowance;  ///< What is left.
  std::size_t heldCount = 0;
  std::array<ToolPoint, ToolState::kMaxPoints>
      held;  ///< Their forces add up to the force, their torques to the torque.
};

/// Sharp points of all bodies together; those of further bodies are left out.
inline constexpr std::size_t kMaxSharpPoints = 16'384;

/// A tool of many points: its proxy is the rigid pose nearest to the device's, measured by the coupling's energy, to which
/// it comes on a way on which no point of the shell passes a surface of a body, and no sharp point of a body the tool's
/// (Ortega, Redon & Coquillart 2007, with Gauss' least constraint over the planes of points that touch; the guard and the
/// neighborhood watch are those of the point contact). Everything that it remembers is in it: a copy goes on exactly like
/// the original. Nothing here allocates or locks.
class ToolContact {
 public:
  /// What the tool may meet.
  struct Obstacle {
    Pose pose;
    /// sharpPoints() at the tool's spacing, body frame: what is thin enough to come between two of its points has some.
    std::span<const Vec3> sharp;
    /// The place that it had among those before, with the same surface; -1: it is new, and pushes only what comes to it from
    /// outside.
    int origin = -1;
  };

  ToolContact() noexcept = default;

  /// The hand holds this tool from now on, which has to live as long; reset() comes next.
  void hold(const Tool& tool) noexcept;
  /// The obstacles are these from now on, at most 256, whose sharp points have to live as long.
  void adopt(std::span<const Obstacle> obstacles) noexcept;
  /// The proxy is put there, and touches nothing. Bodies as for follow().
  void reset(const Pose& device, std::span<const Body> bodies) noexcept;

  /// One tick. Bodies are those of the obstacles, at their poses now; those that move push the proxy. Those that are pending
  /// removal are not there.
  [[nodiscard]] ToolResult follow(std::span<const Body> bodies, const Pose& device, const ToolCoupling& coupling,
                                  Allowance allowance = {}) noexcept;

  [[nodiscard]] const Pose& proxy() const noexcept { return proxy_; }
  [[nodiscard]] const Tool* tool() const noexcept { return tool_; }
  /// Where the proxy is clear of a body: the body's own, or behind it after a tick that waited.
  [[nodiscard]] const Pose& testedAt(std::size_t body) const { return bodyAt_[body]; }
  /// Of an obstacle.
  [[nodiscard]] std::span<const Vec3> sharp(std::size_t body) const { return sharp_[body].points; }

  /// Becomes a copy of another, without the places beyond its counts.
  void copyInUse(const ToolContact& other) noexcept;

 private:
  friend class ToolContactImage;

  static constexpr std::size_t kMaxBodies = 256;
  static constexpr std::size_t kMaxHits = 64;
  static constexpr double kFarthestClearance_m = 0.05;  // nothing is looked for farther away
  static constexpr double kCheapestTest = 100;  // what a point's test is taken to cost at least; units of the allowance

  /// A point on a surface: of the tool on a body's, or a sharp one of a body on the tool's.
  struct Touch {
    bool ofBody = false;
    std::uint16_t point = 0;
    std::uint16_t body = 0;
    std::uint32_t triangle = 0;  // of the surface
    int side = 1;
    std::uint64_t hitIn = 0;  // search: until it ends, the point stays above this triangle
    Vec3 place{0};            // of a body's point, world
    Vec3 normal{0};           // of the plane above which the point stays: world, or the tool's frame
    double offset = 0;        // m

    [[nodiscard]] bool isOf(const Touch& other) const noexcept {
      return ofBody == other.ofBody && point == other.point && body == other.body;
    }
  };
  /// Of a body.
  struct Sharp {
    std::span<const Vec3> points;
    std::size_t first = 0;  // of them, in sharpClearTo_
  };

  struct Step {
    LeastDistance nearest;
    Vec3 move, turn;
  };

  // What is remembered from tick to tick.
  const Tool* tool_ = nullptr;
  std::size_t pointCount_ = 0, bodyCount_ = 0, sharpCount_ = 0;  // sharp ones of all bodies
  std::size_t touchCount_ = 0;
  std::size_t cursor_ = 0;     // the point whose clearance is next
  bool waited_ = false;        // in the last tick
  bool isOnWay_ = false;       // a way was not tested to its end in the last tick: it is continued
  std::size_t wayTested_ = 0;  // from this point on, of the tool's, then of the bodies'
  Pose way_;                   // where it leads
  Pose proxy_;
  double moved_ = 0;  // m, at most, of any body that is near since the proxy moved last
  double travelled_ =
      0;  // m, at most, of any point against bodies that are near, from adopt() to the proxy's last move
  double bodiesPart_ = 1;     // of the way of bodies that a tick tries
  double testCost_ = 500;     // units of the allowance; follows what tests cost
  std::uint64_t search_ = 0;  // counts; goes on through ticks in which neither the proxy nor a body moves
  double skin_ = 0;           // m
  std::array<Sharp, kMaxBodies> sharp_;
  std::array<Pose, kMaxBodies> bodyAt_;           // when the proxy moved last
  std::array<double, kMaxBodies> bodyTravelled_;  // likewise, of the tool against that body
  std::array<Touch, kMaxHalfSpaces> touches_;
  std::array<double, kMaxToolPoints> clearTo_;        // travelled_ until which a point can meet nothing
  std::array<double, kMaxSharpPoints> sharpClearTo_;  // bodyTravelled_ likewise

  // Of a tick.
  std::size_t tested_ = 0;  // points of a way, those that need no test too
  std::size_t hitCount_ = 0;
  double firstHit_ = 1;   // fraction of the way
  double lowestHit_ = 0;  // of the points that hit, above what they hit, before; m
  std::array<Touch, kMaxHits> hits_;
  std::array<double, kMaxBodies> bodyMoved_;  // m, at most, since the proxy moved last
  std::array<Body, kMaxBodies> here_;         // bodies that come a part of their way
  std::array<HalfSpace6, kMaxHalfSpaces> halfSpaces_;

  [[nodiscard]] std::span<Touch> touches() noexcept { return std::span(touches_).first(touchCount_); }
  [[nodiscard]] std::span<const Touch> touches() const noexcept { return std::span(touches_).first(touchCount_); }
  [[nodiscard]] Vec3 point(std::size_t i) const noexcept { return tool_->shell.points[i]; }
  void forgetClearances() noexcept;
  void refreshTouch(const Body& body, const Frame& tool, Touch& touch, Allowance& allowance) const noexcept;
  void forgetHighTouches() noexcept;
  [[nodiscard]] double height(const Touch& touch, const Frame& tool) const noexcept;
  [[nodiscard]] std::int64_t testPoints(std::span<const Body> bodies, const Frame& tool, double bound,
                                        Allowance& allowance) noexcept;
  [[nodiscard]] std::int64_t testBodysPoints(std::span<const Body> bodies, const Frame& tool, double bound,
                                             Allowance& allowance) noexcept;
  void addHit(const Touch& hit, double time, double height) noexcept;
  void gather(std::span<const Body> bodies, const Pose& device) noexcept;
  void refreshTouches(std::span<const Body> bodies, double reach, Allowance& allowance) noexcept;
  [[nodiscard]] bool solve(const Pose& device, const ToolCoupling& coupling, Pose& next, ToolResult& result,
                           Allowance& allowance) noexcept;
  [[nodiscard]] bool descends(const Pose& next, const Pose& device, const ToolCoupling& coupling) const noexcept;
  [[nodiscard]] bool keepAbovePlanes(const ToolCoupling& coupling, Pose& pose, Allowance& allowance) noexcept;
  [[nodiscard]] Step stepTowards(const Pose& target, const ToolCoupling& coupling, const Pose& pose, bool lifts,
                                 Allowance& allowance) noexcept;
  [[nodiscard]] double bendOf(double angle_rad) const noexcept { return angle_rad * angle_rad * tool_->shell.radius_m; }
  void describeHeld(const LeastDistance& nearest, const Pose& next, ToolResult& result) const noexcept;
  [[nodiscard]] bool isNear(const Body& body, double moved) const noexcept;
  [[nodiscard]] double farthestMove(std::span<const Body> bodies) noexcept;
  [[nodiscard]] std::span<const Body> takePartOfTheWay(std::span<const Body> bodies,
                                                       const Allowance& allowance) noexcept;
  [[nodiscard]] double farthestMove(const Pose& next) const noexcept;
  [[nodiscard]] bool isClear(std::span<const Body> bodies, const Pose& next, double bound, Allowance& allowance,
                             std::size_t from = 0) noexcept;
  void continueWay(std::span<const Body> bodies, const Pose& device, const ToolCoupling& coupling,
                   Allowance& allowance) noexcept;
  void moveTo(std::span<const Body> bodies, const Pose& next, double bound, Allowance& allowance) noexcept;
  void moveBackTo(const Pose& start) noexcept;
  [[nodiscard]] double clearance(std::span<const Body> bodies, Vec3 place, Allowance& allowance) const noexcept;
  [[nodiscard]] bool addHits() noexcept;
  [[nodiscard]] std::int64_t testsWithin(double bound) const noexcept;
  [[nodiscard]] bool canTest(double bound, const Allowance& allowance) const noexcept;
  void learnTestCost(std::int64_t tests, std::int64_t spent) noexcept;
  void renewClearances(std::span<const Body> bodies, std::size_t count, std::int64_t keep,
                       Allowance& allowance) noexcept;
};

static_assert(std::is_trivially_copyable_v<ToolContact>, "kept, copied and replayed as a value");

}  // namespace haptics
