#include "tests/eval/fuzz/reshaped_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/deform/free_form.h"
#include "common/mesh/generators.h"
#include "common/scene/deformation_properties.h"
#include "haptic_server/world/scene_world.h"
#include "haptic_server/world/stepped_scene.h"
#include "tests/eval/fuzz/streamed_path.h"
#include "tests/eval/random.h"

namespace haptics::eval {
namespace {

constexpr std::array kPeriods{1, 1, 8, 16, 33};        // ticks
constexpr std::array kScenePeriods{5, 8, 16, 33, 50};  // the same of a scene's objects
constexpr double kDeepest_m = 0.006;                   // the HIP is drawn back where it is farther from the IHIP

using Corners = std::array<Vec3, 3>;

/// Signed, of the unit sphere around the origin (Van Oosterom & Strackee 1983).
[[nodiscard]] double solidAngle(const Corners& t, Vec3 from) {
  const Vec3 a = t[0] - from, b = t[1] - from, c = t[2] - from;
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  return 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                        la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
}

[[nodiscard]] Vec3 nearestOnEdge(Vec3 a, Vec3 b, Vec3 to) {
  const Vec3 ab = b - a;
  const double length2 = glm::dot(ab, ab);
  return length2 > 0 ? a + ab * std::clamp(glm::dot(to - a, ab) / length2, 0.0, 1.0) : a;
}

[[nodiscard]] Vec3 nearestOn(const Corners& t, Vec3 to) {
  const Vec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double area2 = glm::dot(normal, normal);
  bool within = area2 > 0;
  for (std::size_t k = 0; k < 3; ++k)
    within = within && glm::dot(glm::cross(t[(k + 1) % 3] - t[k], to - t[k]), normal) >= 0;
  if (within) return to - normal * (glm::dot(to - t[0], normal) / area2);
  Vec3 nearest = nearestOnEdge(t[0], t[1], to);
  for (std::size_t k = 1; k < 3; ++k) {
    const Vec3 other = nearestOnEdge(t[k], t[(k + 1) % 3], to);
    if (glm::distance(other, to) < glm::distance(nearest, to)) nearest = other;
  }
  return nearest;
}

/// A body as it is in a tick: a closed mesh, or a sheet with a far box below it that has it as its lid.
class Shape {
 public:
  /// @param recipe  Of a scene file; empty: there is none.
  Shape(TriMesh mesh, std::size_t lid, std::string recipe = {})
      : mesh_(std::move(mesh)), lid_(lid), recipe_(std::move(recipe)), at_(mesh_.vertices.size()) {}

  [[nodiscard]] const std::string& recipe() const noexcept { return recipe_; }
  [[nodiscard]] const TriMesh& mesh() const noexcept { return mesh_; }
  [[nodiscard]] bool isSheet() const noexcept { return lid_ < mesh_.triangles.size(); }
  /// Those that can be felt.
  [[nodiscard]] std::span<const TriangleIndices> felt() const noexcept {
    return std::span(mesh_.triangles).first(lid_);
  }
  /// Vertices that move: all but the apex of a sheet's back.
  [[nodiscard]] std::vector<Vec3f> moved() const {
    return {mesh_.vertices.begin(), mesh_.vertices.end() - (isSheet() ? 1 : 0)};
  }
  [[nodiscard]] std::vector<Vec3f> withApex(std::vector<Vec3f> moved) const {
    if (isSheet()) moved.push_back(mesh_.vertices.back());
    return moved;
  }
  void put(std::vector<Vec3> vertices) { at_ = std::move(vertices); }

  [[nodiscard]] Corners corners(const TriangleIndices& t) const { return {at_[t[0]], at_[t[1]], at_[t[2]]}; }
  [[nodiscard]] bool isWithin(Vec3 place) const {
    double sum = 0;
    for (const TriangleIndices& t : mesh_.triangles) sum += solidAngle(corners(t), place);
    return sum > 2 * std::numbers::pi;
  }
  [[nodiscard]] double distance_m(Vec3 place) const { return glm::distance(nearestOnSurface(place), place); }
  /// Do steps over the surface, from the IHIP on it, each of them nearer to the HIP, lead more than `off_m` nearer? Long ones that
  /// do may have passed an edge that is near: the first few nanometres are to lead down as well.
  [[nodiscard]] bool leadsAway(Vec3 ihip, Vec3 hip, double off_m) const {
    constexpr double kShort_m = 2e-9, kSlope = 1e-3;
    return nearerBySteps_m(20e-6, 200, ihip, hip) > off_m && nearerBySteps_m(0.5e-6, 4000, ihip, hip) > off_m &&
           nearerBySteps_m(kShort_m, 1, ihip, hip) > kSlope * kShort_m;
  }

 private:
  [[nodiscard]] double nearerBySteps_m(double step_m, int steps, Vec3 ihip, Vec3 hip) const {
    Vec3 at = ihip;
    double left = glm::distance(at, hip);
    for (int i = 0; i < steps && left > step_m; ++i) {
      const Vec3 next = nearestOnSurface(at + (hip - at) * (step_m / left));
      if (glm::distance(next, hip) >= left) break;
      at = next;
      left = glm::distance(at, hip);
    }
    return glm::distance(ihip, hip) - left;
  }
  [[nodiscard]] Vec3 nearestOnSurface(Vec3 place) const {
    Vec3 nearest(0);
    double least = std::numeric_limits<double>::infinity();
    for (const TriangleIndices& t : felt()) {
      const Vec3 on = nearestOn(corners(t), place);
      if (glm::distance(on, place) < least) least = glm::distance(on, place), nearest = on;
    }
    return nearest;
  }

  TriMesh mesh_;
  std::size_t lid_;  // of the triangles, those before
  std::string recipe_;
  std::vector<Vec3> at_;
};

/// n x n squares of a side, at z = 0, its back closed by a box far below.
[[nodiscard]] Shape makeSheet(double side_m, std::uint32_t n) {
  TriMesh mesh;
  const auto number = [n](std::uint32_t i, std::uint32_t j) { return j * (n + 1) + i; };
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      mesh.vertices.emplace_back(static_cast<float>(side_m * (double(i) / n - 0.5)),
                                 static_cast<float>(side_m * (double(j) / n - 0.5)), 0.0F);
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
      mesh.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
    }
  }
  const std::size_t lid = mesh.triangles.size();
  std::vector<std::uint32_t> rim;  // counter-clockwise seen from above
  for (std::uint32_t i = 0; i < n; ++i) rim.push_back(number(i, 0));
  for (std::uint32_t j = 0; j < n; ++j) rim.push_back(number(n, j));
  for (std::uint32_t i = n; i > 0; --i) rim.push_back(number(i, n));
  for (std::uint32_t j = n; j > 0; --j) rim.push_back(number(0, j));
  const auto apex = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.0F, 0.0F, static_cast<float>(-20 * side_m));
  for (std::size_t k = 0; k < rim.size(); ++k) mesh.triangles.push_back({rim[(k + 1) % rim.size()], rim[k], apex});
  return {std::move(mesh), lid};
}

[[nodiscard]] Shape closed(TriMesh mesh, std::string recipe) {
  const std::size_t all = mesh.triangles.size();
  return {std::move(mesh), all, std::move(recipe)};
}

/// For a scene file, to the last bit.
[[nodiscard]] std::string text(double number) {
  std::array<char, 40> digits{};
  std::snprintf(digits.data(), digits.size(), "%.17g", number);
  return digits.data();
}
[[nodiscard]] std::string text(Vec3 v) { return "x: " + text(v.x) + " y: " + text(v.y) + " z: " + text(v.z); }
[[nodiscard]] std::string text(const Pose& pose) {
  const Quat& q = pose.rotation;
  return "pose { position { " + text(pose.position) + " } rotation { w: " + text(q.w) + " " +
         text(Vec3(q.x, q.y, q.z)) + " } }";
}

[[nodiscard]] Shape someBox(Vec3 size_m, std::uint32_t segments) {
  return closed(makeBox(size_m, segments).value(),
                "box { size_m { " + text(size_m) + " } segments: " + std::to_string(segments) + " }");
}

[[nodiscard]] Shape someShape(Random& random, bool inScene) {
  switch (random.below(inScene ? 4 : 5)) {
    case 0: {
      const double radius_m = random.between(0.02, 0.05);
      return closed(makeSphere(radius_m, 5).value(), "sphere { radius_m: " + text(radius_m) + " segments: 5 }");
    }
    case 1: {
      const double side_m = random.between(0.03, 0.08);
      return someBox(Vec3(side_m, random.between(0.03, 0.08), 0.05), 4);
    }
    case 2:  // a thin plate
      return someBox(Vec3(0.1, 0.1, std::pow(10, random.between(-4, -2.5))), 5);
    case 3:
      return closed(makeTorus(0.04, 0.015, 18, 10).value(),
                    "torus { major_radius_m: 0.04 minor_radius_m: 0.015 major_segments: 18 minor_segments: 10 }");
    default:
      return makeSheet(0.12, 9);
  }
}

/// Where vertices go by time: growth, a shift, and waves that bend by less than half, or a lattice whose control points swing.
class Motion {
 public:
  Motion(Random& random, std::vector<Vec3f> rest, double speed_m_per_s, bool inScene)
      : rest_(std::move(rest)),
        byLattice_(inScene || random.chance(0.4)),
        points_(inScene ? 2 + static_cast<std::uint32_t>(random.below(7)) : 3),
        swings_(std::size_t{points_} * points_ * points_) {
    rate_ = 1;
    growth_ = random.chance(0.5) ? random.between(0, 0.3) : 0;
    shift_m_ = random.direction() * (random.chance(0.4) ? random.between(0, 0.05) : 0);
    for (Wave& wave : waves_) {
      wave.number_per_m = random.direction() * (2 * std::numbers::pi / random.between(0.05, 0.3));
      wave.phase = random.between(0, 2 * std::numbers::pi);
      wave.rate = random.between(0.5, 1) * random.sign();
      wave.way_m =
          random.direction() * (random.between(0, 0.4) / double(waves_.size()) / glm::length(wave.number_per_m));
    }
    low_ = high_ = Vec3(rest_.front());
    for (const Vec3f& v : rest_) low_ = glm::min(low_, Vec3(v)), high_ = glm::max(high_, Vec3(v));
    const Vec3 margin(std::max(0.1 * glm::length(high_ - low_), 1e-3));
    low_ -= margin, high_ += margin;
    for (Vec3& swing : swings_) swing = random.direction() * random.between(0, 0.12);  // of the lattice's cells
    // as fast as asked for
    double fastest = 1e-9;
    constexpr double kStep = 0.01;
    for (double time = 0; time < 8; time += 0.13) {
      const auto before = at(time), after = at(time + kStep);
      for (std::size_t v = 0; v < before.size(); ++v)
        fastest = std::max(fastest, glm::distance(Vec3(before[v]), Vec3(after[v])) / kStep);
    }
    rate_ = speed_m_per_s * std::pow(10, random.between(-2.5, 0)) / fastest;
  }

  [[nodiscard]] std::vector<Vec3f> at(double time_s) const {
    const double time = rate_ * time_s;
    const double scale = 1 + growth_ * (1 - std::cos(time)) / 2;
    if (byLattice_) return shapedBy(latticeAt(time_s), rest_);
    std::vector<Vec3f> places;
    for (const Vec3f& v : rest_) {
      Vec3 place(v);
      for (const Wave& w : waves_) {
        const double angle = glm::dot(w.number_per_m, Vec3(v)) + w.phase;
        place += w.way_m * (std::sin(angle + w.rate * time) - std::sin(angle));
      }
      places.emplace_back(place * scale + shift_m_ * std::sin(time));
    }
    return places;
  }
  [[nodiscard]] Lattice latticeAt(double time_s) const {
    const double time = rate_ * time_s;
    const double scale = 1 + growth_ * (1 - std::cos(time)) / 2;
    Lattice lattice{.low_m = low_, .size_m = high_ - low_, .points = {points_, points_, points_}, .control_m = {}};
    const Vec3 cell_m = lattice.size_m / (points_ - 1.0);
    for (std::size_t i = 0; i < swings_.size(); ++i) {
      const Vec3 cell(double(i % points_), double(i / points_ % points_), double(i / points_ / points_));
      const Vec3 swing = swings_[i] * (std::sin(time + double(i)) - std::sin(double(i)));
      lattice.control_m.emplace_back((low_ + cell_m * (cell + swing)) * scale + shift_m_ * std::sin(time));
    }
    return lattice;
  }

 private:
  struct Wave {
    Vec3 number_per_m{0}, way_m{0};
    double phase = 0, rate = 0;
  };
  std::vector<Vec3f> rest_;
  bool byLattice_;
  std::uint32_t points_;  // of the lattice's sides
  double rate_, growth_ = 0;
  Vec3 shift_m_{0}, low_{0}, high_{0};
  std::array<Wave, 3> waves_;
  std::vector<Vec3> swings_;
};

/// What world.h says of the vertices: evenly over the samples to the newest one, in as many ticks as lay between the last two.
class ShapePath {
 public:
  explicit ShapePath(const std::vector<Vec3f>& rest) : samples_{rest, rest, rest} {}

  void sample(std::vector<Vec3f> to, int ticks) {
    samples_ = {std::move(samples_[1]), std::move(samples_[2]), std::move(to)};
    along_ = std::max(along_ - 1, 0.0);
    left_ = ticks;
  }
  void tick() {
    if (left_ == 0) return;
    along_ = left_ == 1 ? 2 : along_ + (2 - along_) / left_;
    --left_;
  }
  [[nodiscard]] std::vector<Vec3> at(const Pose& pose) const {
    const std::size_t i = along_ < 1 ? 0 : 1;
    std::vector<Vec3> places;
    for (std::size_t v = 0; v < samples_[0].size(); ++v)
      places.push_back(
          toWorld(pose, glm::mix(Vec3(samples_[i][v]), Vec3(samples_[i + 1][v]), along_ - static_cast<double>(i))));
    return places;
  }

 private:
  std::array<std::vector<Vec3f>, 3> samples_;
  double along_ = 2;
  int left_ = 0;
};

[[nodiscard]] std::vector<std::array<float, 3>> rowsOf(const std::vector<Vec3f>& vertices) {
  std::vector<std::array<float, 3>> rows;
  for (const Vec3f& v : vertices) rows.push_back({v.x, v.y, v.z});
  return rows;
}

[[nodiscard]] World::Device device() {
  World::Device device;
  device.maxForce_N = 1000;
  return device;
}

class ReshapedWorld {
 public:
  ReshapedWorld(std::uint64_t seed, double speed_m_per_s, bool inScene)
      : random_(seed),
        period_((inScene ? kScenePeriods : kPeriods)[static_cast<std::size_t>(random_.below(int(kPeriods.size())))]),
        shape_(someShape(random_, inScene)),
        motion_(random_, shape_.moved(), speed_m_per_s, inScene),
        world_(device()),
        shapePath_(shape_.mesh().vertices),
        posePath_(Pose{random_.rotation(), Vec3(random_.between(-0.1, 0.1), 0, 0)}),
        spin_rad_per_s_(random_.chance(0.25) ? random_.between(-1, 1) : 0),
        first_(posePath_.at()) {
    if (inScene) scene_.emplace(device());
    body_ = add("shape", shape_, first_);
    shape_.put(shapePath_.at(first_));
    if (!shape_.isSheet() && random_.chance(0.3)) addBystander();
    hip_ = somewhere(1.3);
    for (int i = 0; i < 1000 && (isInAny(hip_) || shape_.distance_m(hip_) < 2e-3); ++i) hip_ = somewhere(1.3);
    isBehind_ = shape_.isWithin(hip_);  // of a sheet
    for (int i = 0; i < kRiseTicks; ++i) {
      stream(i, 0);
      static_cast<void>(step());
    }
  }

  [[nodiscard]] StreamRun run() {
    StreamCount counted;
    Vec3 ihip = hip_;
    for (int tick = kRiseTicks; tick < kRiseTicks + kStreamedTicks; ++tick) {
      stream(tick, 1e-3 * (tick - kRiseTicks));
      leadHand(ihip);
      const World::Sample sample = step();
      ihip = vec(sample.ihip_m);
      count(sample, ihip, counted);
      if (counted.notFinite > 0) break;
    }
    return {counted, period_};
  }

 private:
  [[nodiscard]] static World::Material material() {
    return {.stiffness_N_per_m = kStreamStiffness_N_per_m, .damping_Ns_per_m = 0};
  }
  [[nodiscard]] std::uint64_t add(const std::string& name, const Shape& shape, const Pose& pose) {
    if (!scene_) {
      const std::vector<TriangleIndices> felt(shape.felt().begin(), shape.felt().end());
      return world_.add(name, {rowsOf(shape.mesh().vertices), felt}, material(), worldPose(pose));
    }
    scene_->apply("operations { add { name: \"" + name + "\" mesh { " + shape.recipe() + " } " + text(pose) +
                  " material { stiffness_N_per_m: " + text(kStreamStiffness_N_per_m) + " damping_Ns_per_m: 0 } } }");
    return scene_->bodies().back().number;
  }
  [[nodiscard]] World::Sample step() noexcept {
    return scene_ ? scene_->step(vectorOf(hip_)) : world_.step(vectorOf(hip_));
  }
  /// @return Where the vertices go.
  [[nodiscard]] std::vector<Vec3f> moveVertices(double time_s) {
    auto places = shape_.withApex(motion_.at(time_s));
    if (!scene_) {
      world_.moveVerticesKinematic(body_, rowsOf(places));
      return places;
    }
    const Lattice lattice = motion_.latticeAt(time_s);
    const std::string points = std::to_string(lattice.points[0]);
    std::string edit =
        "operations { set_deformation { object { name: \"shape\" } kinematic: true deformation { lattice { low_m { " +
        text(lattice.low_m) + " } size_m { " + text(lattice.size_m) + " } points_x: " + points +
        " points_y: " + points + " points_z: " + points;
    for (const Vec3f& point : lattice.control_m) {
      for (int d = 0; d < 3; ++d) edit += " control_m: " + text(point[d]);
    }
    scene_->apply(edit + " } } } }");
    return places;
  }
  void movePose(const Pose& pose) {
    if (!scene_) return world_.moveKinematic(body_, worldPose(pose));
    scene_->apply("operations { set_pose { object { name: \"shape\" } kinematic: true " + text(pose) + " } }");
  }
  void addBystander() {
    Shape other = someBox(Vec3(0.03), 1);
    const Pose pose{random_.rotation(), first_.position + random_.direction() * random_.between(0.06, 0.1)};
    static_cast<void>(add("bystander", other, pose));
    other.put(ShapePath(other.mesh().vertices).at(pose));
    bystander_ = std::move(other);
  }
  [[nodiscard]] bool isInAny(Vec3 place) const {
    return (!shape_.isSheet() && shape_.isWithin(place)) || (bystander_ && bystander_->isWithin(place));
  }
  /// Near the body; of a sheet, not near its rim.
  [[nodiscard]] Vec3 somewhere(double share) {
    Vec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const TriangleIndices& t : shape_.felt()) {
      const Vec3 v(shape_.mesh().vertices[t[0]]);
      low = glm::min(low, v), high = glm::max(high, v);
    }
    const Vec3 half = glm::max((high - low) * 0.5 * share, Vec3(shape_.isSheet() ? 0.04 : 0.01));
    const double sideways = shape_.isSheet() ? 0.3 : 1;
    const Vec3 at(random_.between(-1, 1) * half.x * sideways, random_.between(-1, 1) * half.y * sideways,
                  random_.between(-1, 1) * half.z);
    return toWorld(posePath_.at(), (low + high) * 0.5 + at);
  }

  void stream(int tick, double time_s) {
    if (tick >= due_) {
      auto places = moveVertices(time_s);
      const int since = last_ < 0 ? 1 : tick - last_;
      shapePath_.sample(std::move(places), since);
      if (spin_rad_per_s_ != 0) {
        const Pose pose{glm::angleAxis(spin_rad_per_s_ * time_s, Vec3(0, 0, 1)) * first_.rotation,
                        first_.position + Vec3(0, 0, 0.02) * std::sin(time_s)};
        movePose(pose);
        posePath_.sample(pose, since);
      }
      last_ = tick;
      due_ = tick + (period_ == 1 ? 1 : period_ + random_.below(period_ / 2) - period_ / 4);
    }
    shapePath_.tick();
    posePath_.tick();
    shape_.put(shapePath_.at(posePath_.at()));
  }

  /// It rests, goes somewhere, and gives way.
  void leadHand(Vec3 ihip) {
    if (ticksToTarget_-- <= 0) {
      ticksToTarget_ = 100 + random_.below(600);
      target_ = random_.chance(0.4) ? hip_ : somewhere(1.2);
      step_m_ = 1e-3 * std::pow(10, random_.between(-2, -0.5));
    }
    const double way = glm::distance(hip_, target_);
    if (way > step_m_) hip_ += (target_ - hip_) * (step_m_ / way);
    const double depth = glm::distance(hip_, ihip);
    if (depth > kDeepest_m) {
      hip_ = ihip + (hip_ - ihip) * (kDeepest_m / depth);
      target_ = hip_;
    }
  }

  void count(const World::Sample& sample, Vec3 ihip, StreamCount& counted) {
    ++counted.ticks;
    counted.touching += sample.body != 0 ? 1 : 0;
    if (!std::isfinite(ihip.x + ihip.y + ihip.z + sample.force_N[0] + sample.force_N[1] + sample.force_N[2])) {
      ++counted.notFinite;
      return;
    }
    const bool waits = sample.allowanceSpent || waited_;
    waited_ = sample.allowanceSpent;
    constexpr double kRounding_m = 1e-7;  // of float vertices, and of the core's offsets
    const bool isBehind = shape_.isWithin(ihip);
    if (shape_.isSheet()) {
      const bool passed = isBehind != isBehind_ && shape_.distance_m(ihip) > kRounding_m;
      counted.crossed += passed && !waits ? 1 : 0;
      if (passed) isBehind_ = isBehind;
    } else {
      const double inside_m = isBehind ? shape_.distance_m(ihip) : 0;
      const double inOther_m = bystander_ && bystander_->isWithin(ihip) ? bystander_->distance_m(ihip) : 0;
      const double deepest = std::max(inside_m, inOther_m);
      if (deepest > kRounding_m) {
        const bool isFirst = sample.depenetrated && !wasInside_;
        (waits ? counted.insideWaiting : counted.inside) += isFirst ? 0 : 1;
        counted.deepest_m = std::max(counted.deepest_m, deepest);
      }
      wasInside_ = deepest > kRounding_m;
    }
    hasJumped_ = hasJumped_ || sample.allowanceSpent || sample.depenetrated;
    if (hasJumped_) return;  // that is let in at 30 N/s, and with it what moves meanwhile
    const Vec3 expected_N = kStreamStiffness_N_per_m * (ihip - hip_);
    const double allowed_N = kForcePart * glm::length(expected_N) + kForceBeside_N;
    counted.otherForce += glm::distance(vec(sample.force_N), expected_N) > allowed_N ? 1 : 0;
    const bool wasLate = std::exchange(late_, false);
    if (sample.body != body_ || (!wasLate && ++sinceRest_ < 20)) return;
    sinceRest_ = 0;
    ++counted.rests;
    if (bystander_ || !shape_.leadsAway(ihip, hip_, allowed_N / kStreamStiffness_N_per_m)) return;
    ++(wasLate ? counted.notAtRest : counted.late);
    late_ = true;
  }

  Random random_;
  int period_;
  Shape shape_;
  Motion motion_;
  World world_;
  std::optional<SceneWorld> scene_;  // in its place
  ShapePath shapePath_;
  StreamedPath posePath_;
  double spin_rad_per_s_;
  Pose first_;
  std::optional<Shape> bystander_;
  std::uint64_t body_ = 0;
  Vec3 hip_{0}, target_{0};
  double step_m_ = 0;
  int ticksToTarget_ = 0, due_ = 0, last_ = -1, sinceRest_ = 0;
  bool isBehind_ = false, waited_ = false, wasInside_ = false, hasJumped_ = false, late_ = false;
};

}  // namespace

StreamCount& StreamCount::operator+=(const StreamCount& o) noexcept {
  ticks += o.ticks, touching += o.touching, inside += o.inside, crossed += o.crossed;
  notFinite += o.notFinite, otherForce += o.otherForce, insideWaiting += o.insideWaiting;
  rests += o.rests, late += o.late, notAtRest += o.notAtRest;
  deepest_m = std::max(deepest_m, o.deepest_m);
  return *this;
}

StreamRun runReshapedWorld(std::uint64_t seed, double speed_m_per_s, bool inScene) {
  return ReshapedWorld(seed, speed_m_per_s, inScene).run();
}

}  // namespace haptics::eval
