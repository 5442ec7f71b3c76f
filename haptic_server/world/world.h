#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>

namespace haptics {

/// What a World was given and cannot take; what() names the field, what is wrong, and what would be right.
class InvalidInput : public std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Bodies, and the force on a hand that touches them: the haptic server's step (Ho, Basdogan & Srinivasan 1999, 3 to 4)
/// for a program that has a loop and a device of its own. The same positions give the same forces as the server's, bit
/// for bit. SI units, right-handed world frame. One thread at a time.
///
/// step() and run() belong into the loop: they do not allocate, lock, throw or call the system, and their time is bounded.
/// Everything else may take milliseconds, a large mesh seconds, and is felt from the next step() on: without a step of the
/// force, for which a contact that the edit would break fades for up to 0.25 s.
class World {
 public:
  using Vector = std::array<double, 3>;

  /// The device whose force this is, and the rate of its loop. With its dynamics the force is computed where the HIP will
  /// be while the force is held, and surfaces are no stiffer than the device bears; without (a mass of 0) neither is done:
  /// the force is stiffness times depth of the position as it is.
  struct Device {
    double rate_Hz = 1000;    ///< Of step().
    double maxForce_N = 3.3;  ///< No force is larger.
    double resolution_m = 0;  ///< Position quantum; 0: not known.
    double delay_s = 0;       ///< From reading a position to the motors' force.
    double mass_kg = 0;       ///< Apparent, as at a point; 0: not known.
    double viscousFriction_Ns_per_m = 0;
    double coulombFriction_N = 0;
    double maxStiffness_N_per_m = 0;  ///< As its maker says; 0: not known.
    bool predicts = true;             ///< False: positions are used as they are, whatever the mass.

    /// One of the server's presets: "omni", "touch", "premium-1.5", "desktop", "falcon", "omega.3".
    /// @throws InvalidInput a name that is none of them.
    [[nodiscard]] static Device named(std::string_view name);
  };

  /// Triangles, counter-clockwise seen from outside: metres, body frame. Vertices at one place are one; triangles without
  /// area are left out. Closed meshes have an inside, others are felt from both sides.
  struct Mesh {
    std::span<const std::array<float, 3>> vertices;
    std::span<const std::array<std::uint32_t, 3>> triangles;
  };

  /// Body frame to world: x_world = rotation * x_body + position.
  struct Pose {
    Vector position_m{};
    std::array<double, 4> rotation{1, 0, 0, 0};  ///< Unit quaternion w, x, y, z.
  };

  struct Material {
    double stiffness_N_per_m = 800;
    double damping_Ns_per_m = 0.5;
    double staticFriction = 0;   ///< Coefficient, 0 to 10, not below the dynamic one; 0: none.
    double dynamicFriction = 0;  ///< Coefficient.
    /// Lines whose faces' normals differ by less are felt rounded (4.1, force shading); 0: none, at most pi.
    double roundedBelow_rad = 0;
  };

  /// Why the force was taken away, smoothly. It comes back once the reason is gone.
  enum class Fault : std::uint8_t {
    kNone = 0,
    kNonFiniteHip = 1,  ///< Or farther than 10 km from the origin.
    kNonFiniteForce = 2,
    kMissedTicks = 3,  ///< Too many between two steps.
  };

  /// One tick.
  struct Sample {
    Vector force_N{};            ///< On the hand.
    Vector ihip_m{};             ///< Ideal haptic interface point: on the surface while it is touched, else the HIP.
    Vector normal{};             ///< Of the touched surface, unit, outward; zero when free.
    double penetration_m = 0;    ///< Of the HIP.
    std::uint64_t body = 0;      ///< The touched one; 0: none.
    std::uint32_t triangle = 0;  ///< The touched one, in the order of the mesh without what was left out.
    Fault fault = Fault::kNone;
    bool sliding = false;         ///< Friction slides; else it sticks, or there is none.
    bool allowanceSpent = false;  ///< The tick's allowance ended on the way: the next one goes on from there.
    bool depenetrated = false;    ///< Bodies left the IHIP no place between them, and it was put outside of all.
  };

  /// A tool with a shape, in place of a point. Its proxy is the pose nearest to the device's in which it has passed nothing;
  /// two springs hold the device to it. What stiffness a device bears in rotation is for its user to know.
  struct Tool {
    /// Of the points of its surface that are followed, of which at most 8,192 may come of it. So are its vertices, but for
    /// those within 5 um of one; of a mesh of more than 1,000 perhaps not all (makeToolShell() in engine/tool/tool_shell.h).
    double spacing_m = 0.002;
    double stiffness_N_per_m = 800;  ///< Against moving,
    double torsion_Nm_per_rad = 1;   ///< and against turning.
    double maxTorque_Nm = 0.2;       ///< No torque is larger.
  };

  /// One tick of a tool.
  struct ToolSample {
    Vector force_N{};            ///< On the hand,
    Vector torque_Nm{};          ///< and about the origin of the tool's frame; world frame.
    Pose proxy;                  ///< Of the tool.
    std::uint32_t touching = 0;  ///< Points that surfaces hold.
    Fault fault = Fault::kNone;
    bool waits = false;  ///< The tick's allowance ended on the way: the next one goes on from there.
  };

  /// @throws InvalidInput a value out of range.
  explicit World(const Device& device);
  World() : World(Device{}) {}
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// @param name  Of 1 to 64 bytes, another one than that of every other body.
  /// @return The body's number, which no other one gets.
  /// @throws InvalidInput a mesh without triangles, or of more than 50 million, a vertex that is not finite or not there, a
  /// value out of range, a name that is taken, more than 256 bodies.
  std::uint64_t add(std::string_view name, const Mesh& mesh, const Material& material, const Pose& pose);
  std::uint64_t add(std::string_view name, const Mesh& mesh, const Material& material) {
    return add(name, mesh, material, Pose{});
  }
  std::uint64_t add(std::string_view name, const Mesh& mesh) { return add(name, mesh, Material{}, Pose{}); }
  /// An edit: felt without a step of the force, and not faster than 30 N/s, for which the body may pass the hand. What moves
  /// in the loop is moved by moveKinematic().
  /// @throws InvalidInput a body that is not there; a value out of range. Here and below.
  void setPose(std::uint64_t body, const Pose& pose);
  /// @throws InvalidInput also: rounded, of a body whose vertices were moved.
  void setMaterial(std::uint64_t body, const Material& material);
  void remove(std::uint64_t body);
  /// The hand holds this tool from now on, for stepTool(); the mesh in the tool's frame, in whose origin the device holds it.
  /// @return How many points are followed.
  /// @throws InvalidInput a mesh without triangles, a value out of range, a spacing that gives more than 8,192 points; a body
  /// whose vertices were moved.
  std::size_t hold(const Mesh& mesh, const Tool& tool);

  /// A motion from where the body is to this pose: it pushes the hand on its way, at any speed. In the loop: unless it
  /// throws it does not allocate, lock or call the system, and its time is bounded. Called before every step() the body is
  /// at its pose in that step; called less often it is there after as many steps as lay between the last two calls, and in
  /// between on the way. After 0.1 s without a call it begins anew, at 1 m/s or within 0.1 s. setPose() ends it.
  void moveKinematic(std::uint64_t body, const Pose& pose);

  /// A motion of the body's vertices from where they are to these places, which pushes the hand on its way, at any speed: the body
  /// frame, metres, one for each vertex of the mesh that add() got; of those at one place the first counts. In the times that
  /// moveKinematic() takes, and beside it. In the loop: but for the first call of a body, which prepares memory for it, it does
  /// not allocate, lock or call the system unless it throws; the call and the step() after it take a time that grows with the mesh,
  /// some 10 ns a triangle together. The hand stays on its side of the surface where neighbouring places of that come nearer to
  /// each other or turn about each other by less than half of their distance in a step.
  /// @throws InvalidInput also: another number of vertices, a place that is not finite or beyond 1 km; a body that is rounded
  /// (Material::roundedBelow_rad); a tool in the hand.
  void moveVerticesKinematic(std::uint64_t body, std::span<const std::array<float, 3>> vertices);

  /// The tick after the last one, with the HIP there (m, world).
  Sample step(const Vector& hip_m) noexcept;
  /// The same after `missedTicks` in which the loop was late and the device held its force.
  Sample step(const Vector& hip_m, std::uint64_t missedTicks) noexcept;
  /// A tick of the tool, with the device's pose there (world). Bodies that setPose() or moveKinematic() moves push it, the
  /// latter all the way in this tick. No force without a tool.
  ToolSample stepTool(const Pose& device) noexcept;
  /// A tick for each position or pose, as many as both hold.
  void run(std::span<const Vector> hips_m, std::span<Sample> samples) noexcept;
  void runTool(std::span<const Pose> devices, std::span<ToolSample> samples) noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// In words; "none" where there is none.
[[nodiscard]] const char* faultInWords(World::Fault fault) noexcept;

}  // namespace haptics
