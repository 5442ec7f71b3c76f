#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

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

struct ToolResult {
  Pose proxy;           ///< Of the tool, world: it passes nothing.
  Vec3 force_N{0};      ///< On the hand.
  Vec3 torque_Nm{0};    ///< On the hand, about the proxy's origin.
  int touching = 0;     ///< Points that surfaces hold.
  bool waits = false;   ///< The allowance or the rounds ended before the proxy was where it is to be.
  Allowance allowance;  ///< What is left.
};

/// A tool of many points: its proxy is the rigid pose nearest to the device's, measured by the coupling's energy, to which
/// it comes on a way on which no point of the shell passes a surface of a body, and no sharp point of a body the tool's
/// (Ortega, Redon & Coquillart 2007, with Gauss' least constraint over the planes of points that touch; the guard and the
/// neighborhood watch are those of the point contact). All but follow() and reset() on the builder's thread; those two
/// neither allocate nor lock.
class ToolContact {
 public:
  /// What the tool may meet.
  struct Obstacle {
    Body body;
    /// sharpPoints() at the tool's spacing, body frame: what is thin enough to come between two of its points has some.
    std::shared_ptr<const std::vector<Vec3>> sharp;
    /// The place that it had among those before, with the same surface; -1: it is new, and pushes only what comes to it from
    /// outside.
    int origin = -1;
  };

  /// @param surface  The tool's, of which the shell is.
  ToolContact(std::shared_ptr<const CollisionMesh> surface, std::shared_ptr<const ToolShell> shell);

  /// The obstacles are these from now on; at most 256.
  void adopt(std::span<const Obstacle> obstacles);
  /// The proxy is put there, and touches nothing. Bodies as for follow().
  void reset(const Pose& device, std::span<const Body> bodies) noexcept;

  /// One tick. Bodies are those of the obstacles, at their poses now; those that move push the proxy.
  [[nodiscard]] ToolResult follow(std::span<const Body> bodies, const Pose& device, const ToolCoupling& coupling,
                                  Allowance allowance = {}) noexcept;

  [[nodiscard]] const Pose& proxy() const noexcept { return proxy_; }
  [[nodiscard]] const ToolShell& shell() const noexcept { return *shell_; }
  /// Where the proxy is clear of a body: the body's own, or behind it after a tick that waited.
  [[nodiscard]] const Pose& testedAt(std::size_t body) const { return bodyAt_[body]; }
  /// Of an obstacle.
  [[nodiscard]] const std::shared_ptr<const std::vector<Vec3>>& sharp(std::size_t body) const {
    return sharp_[body].points;
  }

 private:
  static constexpr std::size_t kMaxBodies = 256;
  static constexpr std::size_t kMaxHits = 64;

  /// A point on a surface: of the tool on a body's, or a sharp one of a body on the tool's.
  struct Touch {
    bool ofBody;
    std::uint16_t point;
    std::uint16_t body;
    std::uint32_t triangle;  // of the surface
    int side;
    std::uint64_t hitIn;  // tick: until it ends, the point stays above this triangle
    Vec3 place;           // of a body's point, world
    Vec3 normal;          // of the plane above which the point stays: world, or the tool's frame
    double offset;        // m

    [[nodiscard]] bool isOf(const Touch& other) const noexcept {
      return ofBody == other.ofBody && point == other.point && body == other.body;
    }
  };
  /// Of a body.
  struct Sharp {
    std::shared_ptr<const std::vector<Vec3>> points;
    std::vector<double> clearTo;  // as the tool's
  };

  std::shared_ptr<const CollisionMesh> surface_;
  std::shared_ptr<const ToolShell> shell_;
  std::vector<Sharp> sharp_;                 // by body
  std::size_t sharpCount_ = 0, cursor_ = 0;  // of all bodies; the point whose clearance is next
  bool waited_ = false;                      // in the last tick
  Pose proxy_;
  double moved_ = 0;             // m, at most, of any body since the proxy moved last
  double travelled_ = 0;         // m, at most, of any point against any body, from adopt() to the proxy's last move
  std::vector<double> clearTo_;  // travelled_ until which a point can meet nothing
  std::vector<Vec3> place_;      // of the points at the proxy, world
  std::vector<Vec3> next_;       // and at the pose that is tried
  std::array<Pose, kMaxBodies> bodyAt_;  // when the proxy moved last
  std::vector<Body> here_;               // bodies that come a part of their way
  double bodiesPart_ = 1;                // of the way of bodies that a tick tries
  double testCost_ = 500;                // units of the allowance; follows what tests cost
  std::vector<Touch> touches_;           // of capacity kMaxHalfSpaces
  std::vector<HalfSpace6> halfSpaces_;
  std::array<Touch, kMaxHits> hits_;
  std::size_t hitCount_ = 0;
  double firstHit_ = 1;   // fraction of the way
  double lowestHit_ = 0;  // of the points that hit, above what they hit, before; m
  std::uint64_t tick_ = 0;
  double skin_ = 0;  // m

  void forgetClearances() noexcept;
  void refreshTouch(const Body& body, Touch& touch, Allowance& allowance) const noexcept;
  [[nodiscard]] double height(const Touch& touch, const Frame& tool) const noexcept;
  void testBodysPoints(std::span<const Body> bodies, const Frame& tool, double bound, Allowance& allowance) noexcept;
  void addHit(const Touch& hit, double time, double height) noexcept;
  void gather(std::span<const Body> bodies, const Pose& device) noexcept;
  void refreshTouches(std::span<const Body> bodies, double reach, Allowance& allowance) noexcept;
  [[nodiscard]] bool solve(const Pose& device, const ToolCoupling& coupling, Pose& next) noexcept;
  [[nodiscard]] double farthestMove(std::span<const Body> bodies) const noexcept;
  [[nodiscard]] std::span<const Body> takePartOfTheWay(std::span<const Body> bodies,
                                                       const Allowance& allowance) noexcept;
  [[nodiscard]] double farthestMove(const Pose& next) const noexcept;
  [[nodiscard]] bool isClear(std::span<const Body> bodies, const Pose& next, double bound,
                             Allowance& allowance) noexcept;
  void moveTo(std::span<const Body> bodies, const Pose& next, double bound, Allowance& allowance) noexcept;
  [[nodiscard]] double clearance(std::span<const Body> bodies, Vec3 place, Allowance& allowance) const noexcept;
  [[nodiscard]] bool addHits() noexcept;
  [[nodiscard]] std::int64_t testsWithin(double bound) const noexcept;
  [[nodiscard]] bool canTest(double bound, const Allowance& allowance) const noexcept;
  void learnTestCost(std::int64_t tests, std::int64_t spent, bool unfinished) noexcept;
  void renewClearances(std::span<const Body> bodies, std::size_t count, std::int64_t keep,
                       Allowance& allowance) noexcept;
};

}  // namespace haptics
