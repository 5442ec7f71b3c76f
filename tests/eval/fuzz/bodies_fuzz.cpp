#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "tests/eval/fuzz/block_judge.h"
#include "tests/eval/fuzz/fuzz.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/random.h"
#include "tests/eval/report.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

constexpr int kWorldTicks = 3000;  // of a world
constexpr int kJudgeEach = 10;     // ticks
constexpr double kGravity_m_per_s2 = 9.81, kFriction = 0.5;
constexpr Vec3 kFarAway{0, 0, 5};
constexpr double kApart_m_per_s = 0.1;  // at which bodies that overlap are pushed apart
constexpr double kMaxDepth_m = 1e-4, kMaxDeepFor_s = 0.2;
constexpr double kHull =
    0.006;  // of its radius a ball may be smaller: it meets others as the hull of some of its vertices
constexpr double kMaxDrift_m = 1e-3, kMaxTilt_rad = 0.02;  // of what stands
constexpr double kMaxFloating_m = 1e-9;                    // of what floats apart
constexpr double kMaxLift_m = 1e-6;                        // of all blocks, where none is to be pushed apart
constexpr double kMaxCaught = 0.005, kMaxCaught_m = 3e-4;  // of its way, and as well, what slides
constexpr double kRounding_m = 1e-9;
constexpr std::uint64_t kWorldsToALine = 100;

enum class WorldKind {
  kStanding,  ///< Stacks that stand by exact statics, on one table or on flush tiles.
  kPut,       ///< Likewise, put into one another.
  kHeap,      ///< Let fall on each other.
  kRound,     ///< Likewise, balls among them, or into a bowl.
  kFloating,  ///< Near one another without gravity, apart or in each other.
  kSliding,   ///< Pulled over flush tiles, or over a mesh whose vertices lie on edges, without friction.
};
constexpr std::array kKinds{WorldKind::kStanding, WorldKind::kPut,      WorldKind::kHeap,
                            WorldKind::kRound,    WorldKind::kFloating, WorldKind::kSliding};
constexpr std::array<std::string_view, kKinds.size()> kKindNames{"standing", "put",      "heap",
                                                                 "round",    "floating", "sliding"};
/// Every so many worlds one is of the last kind, and the others are what they are without it.
constexpr std::uint64_t kSlidingEach = 8;

double logBetween(Random& random, double low, double high) {
  return std::exp(random.between(std::log(low), std::log(high)));
}

/// Sizes and places to a tenth of a millimetre, as people write them.
double decimal(double length_m) { return std::round(length_m * 1e4) / 1e4; }

/// Blocks, plates, boards and columns.
Vec3 randomHalf(Random& random) {
  const double base = logBetween(random, 0.01, 0.06);
  Vec3 size(base);
  switch (random.below(4)) {
    case 0:
      size = {base, base * random.between(0.5, 1), base * random.between(0.5, 1)};
      break;
    case 1:
      size = {base * random.between(1, 2), base * random.between(1, 2), logBetween(random, 0.001, 0.006)};
      break;
    case 2:
      size = {base * random.between(1, 4), base * random.between(0.3, 1), base * random.between(0.1, 0.4)};
      break;
    default:
      size = {base * 0.5, base * 0.5, base * random.between(1, 2)};
      break;
  }
  return 0.5 * Vec3(decimal(size.x), decimal(size.y), decimal(size.z));
}

class BlockWorld {
 public:
  explicit BlockWorld(std::uint64_t seed)
      : random_(seed), kind_(kKinds[static_cast<std::size_t>(random_.below(static_cast<int>(kKinds.size()) - 1))]) {
    if (seed % kSlidingEach == 0) kind_ = WorldKind::kSliding;
    switch (kind_) {
      case WorldKind::kStanding:
      case WorldKind::kPut:
        addStacks();
        break;
      case WorldKind::kHeap:
        addHeap();
        break;
      case WorldKind::kRound:
        addRound();
        break;
      case WorldKind::kFloating:
        addFloating();
        break;
      case WorldKind::kSliding:
        addSliding();
        break;
    }
    world_.publish();
    world_.tick(kFarAway);
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) overlap_m_ += std::max(0.0, overlapOf(blocks_[i], blocks_[j]));
    }
    deepFor_.resize(blocks_.size() * blocks_.size());
    begun_ = blocks_;
    begun_J_ = energy_J();
  }

  struct Verdict {
    double deepest_m = 0, deepFor_s = 0;  ///< Of one pair in a row, beyond the time that pushing apart may take.
    double gained_J = 0, moved_m = 0, tilt_rad = 0;
    bool finite = true;
    std::uint64_t waited = 0;
    std::string wrong;
  };
  [[nodiscard]] Verdict run() {
    Verdict verdict;
    for (int tick = 0; tick < kWorldTicks; ++tick) {
      world_.tick(kFarAway);
      if (tick % kJudgeEach == 0) judge(tick, verdict);
    }
    verdict.waited = world_.waitedTicks();
    conclude(verdict);
    return verdict;
  }
  [[nodiscard]] std::string_view kind() const { return kKindNames[static_cast<std::size_t>(kind_)]; }
  [[nodiscard]] std::size_t blocks() const { return blocks_.size(); }
  [[nodiscard]] double overlap_m() const { return overlap_m_; }
  [[nodiscard]] double massRatio() const { return massRatio_; }

 private:
  void add(Vec3 half_m, const Pose& pose, double mass_kg, bool falls = true) {
    addMesh(makeBox(2.0 * half_m, 1).value(), pose, mass_kg, falls);
    blocks_.push_back({half_m, pose, mass_kg});
  }
  void addMesh(const TriMesh& mesh, const Pose& pose, double mass_kg, bool falls) {
    addMesh(mesh, pose, mass_kg, falls ? Vec3(0, 0, -kGravity_m_per_s2) : Vec3(0), kFriction);
  }
  void addMesh(const TriMesh& mesh, const Pose& pose, double mass_kg, Vec3 gravity_m_per_s2, double friction) {
    MovingSolid solid =
        mass_kg > 0 ? solidFrom(mesh, mass_kg) : MovingSolid{buildCollisionMesh(mesh.vertices, mesh.triangles), {}};
    solid.body.gravity_m_per_s2 = gravity_m_per_s2;
    ids_.push_back(world_.add(solid, pose, mass_kg > 0));
    CollisionPoints points = makeCollisionPoints(*solid.surface);
    points.friction = friction;
    world_.object(ids_.back()).collision = std::make_shared<const CollisionPoints>(std::move(points));
  }

  /// Its top is z = 0.
  void addTable() {
    if (random_.chance(0.5)) return add({0.3, 0.3, 0.01}, {{1, 0, 0, 0}, {0, 0, -0.01}}, 0);
    const double side_m = decimal(random_.between(0.02, 0.15)), thick_m = decimal(random_.between(0.004, 0.03));
    for (int i = -2; i < 2; ++i) {
      for (int j = -2; j < 2; ++j) {
        add({side_m / 2, side_m / 2, thick_m / 2},
            {{1, 0, 0, 0}, {(i + 0.5) * side_m, (j + 0.5) * side_m, -thick_m / 2}}, 0);
      }
    }
    reach_m_ = 2 * side_m;
  }

  /// Draws blocks on top of one another until the part of the stack above each of its joints is within what it lies on.
  void addStacks() {
    addTable();
    const int count = 2 + random_.below(9);
    const double lightest = logBetween(random_, 0.005, 0.5), heaviest = lightest * logBetween(random_, 1, 1000);
    std::vector<Block> stack{{{reach_m_, reach_m_, 0.01}, {{1, 0, 0, 0}, {0, 0, -0.01}}, 0}};
    for (int tries = 0; static_cast<int>(stack.size()) <= count && tries < 200; ++tries) {
      const Block& below = stack.back();
      const Vec3 half_m = randomHalf(random_);
      const double spread = stack.size() == 1 ? 0.3 * reach_m_ : 0.7 * std::max(below.half_m.x, below.half_m.y);
      const double turn = random_.chance(0.5) ? 0 : random_.between(0, std::numbers::pi);
      const Vec3 place(decimal(below.pose.position.x + random_.between(-spread, spread)),
                       decimal(below.pose.position.y + random_.between(-spread, spread)),
                       below.pose.position.z + below.half_m.z + half_m.z);
      stack.push_back({half_m, {glm::angleAxis(turn, Vec3(0, 0, 1)), place}, logBetween(random_, lightest, heaviest)});
      if (!stands(stack)) stack.pop_back();
    }
    double raised_m = 0;
    for (std::size_t i = 1; i < stack.size(); ++i) {
      const double thinner_m = 2 * std::min(stack[i].half_m.z, stack[i - 1].half_m.z);
      if (kind_ == WorldKind::kPut) raised_m -= random_.between(0, std::min(3e-3, 0.4 * thinner_m));
      Pose pose = stack[i].pose;
      pose.position.z += raised_m;
      add(stack[i].half_m, pose, stack[i].mass_kg);
    }
    massRatio_ = heaviest / lightest;
  }

  void addHeap() {
    addTable();
    const int count = 3 + random_.below(10);
    for (int i = 0; i < count; ++i) {
      add(randomHalf(random_),
          {random_.rotation(), {random_.between(-0.04, 0.04), random_.between(-0.04, 0.04), 0.06 + 0.1 * i}},
          logBetween(random_, 0.01, 0.3));
    }
  }

  void addBall(double radius_m, const Pose& pose, double mass_kg) {
    const TriMesh mesh = makeSphere(radius_m, static_cast<std::uint32_t>(3 + random_.below(20))).value();
    double inner_m = radius_m;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 at(mesh.vertices[a]);
      const Vec3 normal = glm::normalize(glm::cross(Vec3(mesh.vertices[b]) - at, Vec3(mesh.vertices[c]) - at));
      inner_m = std::min(inner_m, glm::dot(normal, at));
    }
    addMesh(mesh, pose, mass_kg, true);
    blocks_.push_back({Vec3(radius_m), pose, mass_kg, true});
    flat_m_.resize(blocks_.size());
    flat_m_.back() = radius_m - inner_m + kHull * radius_m;
  }

  /// Of half a hollow ball, open upwards, its middle at the origin.
  void addBowl() {
    constexpr int kTurns = 64, kRings = 16;
    constexpr double kWall_m = 0.006;
    bowl_m_ = random_.between(0.05, 0.1);
    TriMesh mesh;
    const auto ring = [&](double radius_m, double angle) {
      for (int i = 0; i < kTurns; ++i) {
        const double turn = 2 * std::numbers::pi * i / kTurns;
        mesh.vertices.emplace_back(
            Vec3(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), -std::cos(angle)) * radius_m);
      }
    };
    for (int r = 1; r <= kRings; ++r) ring(bowl_m_, 0.5 * std::numbers::pi * r / kRings);
    for (int r = kRings; r >= 1; --r) ring(bowl_m_ + kWall_m, 0.5 * std::numbers::pi * r / kRings);
    mesh.vertices.emplace_back(0, 0, -bowl_m_);
    mesh.vertices.emplace_back(0, 0, -bowl_m_ - kWall_m);
    const auto corner = [](int r, int i) { return static_cast<std::uint32_t>(r * kTurns + i % kTurns); };
    for (int i = 0; i < kTurns; ++i) {
      for (int r = 0; r + 1 < 2 * kRings; ++r) {
        mesh.triangles.push_back({corner(r, i), corner(r + 1, i + 1), corner(r, i + 1)});
        mesh.triangles.push_back({corner(r, i), corner(r + 1, i), corner(r + 1, i + 1)});
      }
      mesh.triangles.push_back({2 * kRings * kTurns, corner(0, i), corner(0, i + 1)});
      mesh.triangles.push_back({2 * kRings * kTurns + 1, corner(2 * kRings - 1, i + 1), corner(2 * kRings - 1, i)});
    }
    addMesh(mesh, {}, 0, true);
    blocks_.push_back({Vec3(0), {{1, 0, 0, 0}, {0, 0, -10}}, 0});  // judged by itself
  }
  /// How far a body in the bowl reaches into its wall. What is above the rim may lie on it.
  [[nodiscard]] double depthInBowl(const Block& block) const {
    if (bowl_m_ == 0) return 0;
    const auto depthOf = [&](Vec3 at) { return at.z < 0 ? glm::length(at) - bowl_m_ : 0; };
    const double middle_m = glm::length(block.pose.position);
    if (middle_m > bowl_m_) return 0;  // it has left
    if (block.isBall) return block.pose.position.z < -block.radius_m() ? middle_m + block.radius_m() - bowl_m_ : 0;
    double deepest_m = 0;
    for (const int corner : {0, 1, 2, 3, 4, 5, 6, 7}) {
      const Vec3 sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      deepest_m = std::max(deepest_m, depthOf(toWorld(block.pose, sign * block.half_m)));
    }
    return deepest_m;
  }

  /// By how much a body is smaller than it is judged to be.
  [[nodiscard]] double flatOf(std::size_t i) const { return i < flat_m_.size() ? flat_m_[i] : 0; }

  void addRound() {
    if (random_.chance(0.5)) {
      addTable();
    } else {
      addBowl();
    }
    const int count = 3 + random_.below(12);
    for (int i = 0; i < count; ++i) {
      const Pose pose{random_.rotation(),
                      {random_.between(-0.02, 0.02), random_.between(-0.02, 0.02), 0.03 + 0.04 * i}};
      const double mass_kg = logBetween(random_, 0.01, 0.3), half_m = logBetween(random_, 0.004, 0.015);
      if (random_.chance(0.6)) {
        addBall(half_m, pose, mass_kg);
      } else {
        add(half_m * Vec3(1, random_.between(0.6, 1), random_.between(0.6, 1)), pose, mass_kg);
      }
    }
  }

  void addFloating() {
    const int count = 2 + random_.below(6);
    for (int i = 0; i < count; ++i) {
      const bool aligned = random_.chance(0.5);
      const Pose pose{aligned ? Quat(1, 0, 0, 0) : random_.rotation(),
                      {random_.between(-0.05, 0.05), random_.between(-0.05, 0.05), random_.between(-0.05, 0.05)}};
      add(randomHalf(random_), pose, i == 0 && random_.chance(0.5) ? 0 : logBetween(random_, 0.01, 1), false);
    }
  }

  /// A box whose top is in strips, each divided otherwise.
  TriMesh withJunctions(Vec3 half_m) {
    TriMesh mesh = makeBox(2.0 * half_m, 1).value();
    std::erase_if(mesh.triangles, [&](const auto& t) {
      return std::ranges::all_of(t, [&](std::uint32_t v) { return mesh.vertices[v].z > 0; });
    });
    const int strips = 2 + random_.below(6);
    for (int i = 0; i < strips; ++i) {
      const int parts = 1 + random_.below(6);
      for (int j = 0; j < parts; ++j) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (const auto& [x, y] : {std::pair{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}})
          mesh.vertices.emplace_back((2.0 * x / strips - 1) * half_m.x, (2.0 * y / parts - 1) * half_m.y, half_m.z);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
      }
    }
    return mesh;
  }

  void addSliding() {
    constexpr int kColumns = 9, kRows = 5, kWay = 5;  // tiles
    const double side_m = decimal(random_.between(0.02, 0.06)), thick_m = decimal(random_.between(0.008, 0.03));
    const Vec3 middle(0.5 * (kColumns - 3) * side_m, 0, -thick_m / 2);
    if (random_.chance(0.3)) {
      const Vec3 half_m(0.5 * kColumns * side_m, 0.5 * kRows * side_m, thick_m / 2);
      addMesh(withJunctions(half_m), {{1, 0, 0, 0}, middle}, 0, false);
      blocks_.push_back({half_m, {{1, 0, 0, 0}, middle}, 0});
    } else {
      const double other_m = random_.chance(0.3) ? thick_m / 2 : thick_m;
      for (int i = 0; i < kColumns * kRows; ++i) {
        const double tile_m = i % 2 == 0 ? thick_m : other_m;
        add({side_m / 2, side_m / 2, tile_m / 2},
            {{1, 0, 0, 0}, {(i % kColumns - 1) * side_m, (i / kColumns - kRows / 2) * side_m, -tile_m / 2}}, 0);
      }
    }
    way_m_ = kWay * side_m;
    const double half_m = side_m * (random_.chance(0.3) ? 0.5 : random_.between(0.2, 0.9));
    const Vec3 size(2 * half_m, random_.chance(0.5) ? 2 * half_m : half_m, half_m * random_.between(0.1, 1));
    const bool isBox = random_.chance(0.5), isTurned = random_.chance(0.5), isAside = random_.chance(0.5);
    const TriMesh mesh = isBox
                             ? makeBox(size, 1).value()
                             : makeCylinder(half_m, size.z, static_cast<std::uint32_t>(3 + random_.below(62))).value();
    const Pose pose{glm::angleAxis(isTurned ? random_.between(0, std::numbers::pi) : 0, Vec3(0, 0, 1)),
                    {isAside ? random_.between(-0.5, 0.5) * side_m : 0,
                     isAside ? random_.between(-0.5, 0.5) * side_m : 0, size.z / 2}};
    const double mass_kg = logBetween(random_, 0.01, 1);
    constexpr double kSeconds = kWorldTicks * kPeriod_s;
    addMesh(mesh, pose, mass_kg, {2 * way_m_ / (kSeconds * kSeconds), 0, -kGravity_m_per_s2}, 0);
    blocks_.push_back({isBox ? 0.5 * size : Vec3(0.35 * half_m, 0.35 * half_m, size.z / 2), pose, mass_kg});
  }

  [[nodiscard]] double energy_J() const {
    double sum = 0;
    for (std::size_t i = 0; i < ids_.size(); ++i) sum += blocks_[i].mass_kg > 0 ? world_.energyOf(ids_[i]) : 0;
    return sum;
  }

  [[nodiscard]] bool hasLeft(std::size_t i) const {
    return blocks_[i].mass_kg > 0 && world_.stateOf(ids_[i]).condition == BodyCondition::kOutOfBounds;
  }

  void judge(int tick, Verdict& verdict) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      blocks_[i].pose = world_.poseOf(ids_[i]);
      verdict.finite = verdict.finite && isFinite(blocks_[i].pose.position);
    }
    const double settled_s = overlap_m_ / kApart_m_per_s;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (blocks_[i].mass_kg == 0 && blocks_[j].mass_kg == 0) continue;
        if (hasLeft(i) || hasLeft(j)) continue;
        const Block &a = blocks_[i], &b = blocks_[j];
        const bool isBowl = bowl_m_ > 0 && j == 0;
        const double allowed_m = kMaxDepth_m + flatOf(i) + flatOf(j);
        const double depth_m = isBowl ? depthInBowl(a) : overlapOf(a, b);
        double& deepFor_s = deepFor_[i * blocks_.size() + j];
        if (tick * kPeriod_s < settled_s || depth_m <= allowed_m) {
          deepFor_s = 0;
          continue;
        }
        deepFor_s += kJudgeEach * kPeriod_s;
        verdict.deepFor_s = std::max(verdict.deepFor_s, deepFor_s);
        if (deepFor_s > kMaxDeepFor_s) verdict.deepest_m = std::max(verdict.deepest_m, depth_m);
      }
    }
    verdict.gained_J = std::max(verdict.gained_J, energy_J() - begun_J_);
  }

  /// What rounding and pushing apart may lift, the latter each block at that speed against the next.
  [[nodiscard]] double allowed_J() const {
    double mass_kg = 0, fastest_m_per_s = 0;
    for (const Block& block : blocks_) {
      mass_kg += block.mass_kg;
      if (block.mass_kg > 0 && overlap_m_ > kRounding_m) fastest_m_per_s += kApart_m_per_s;
    }
    const double lifted_m = std::max(overlap_m_, kMaxLift_m);
    return mass_kg * (kGravity_m_per_s2 * lifted_m + 0.5 * fastest_m_per_s * fastest_m_per_s);
  }

  void conclude(Verdict& verdict) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      Vec3 moved_m = blocks_[i].pose.position - begun_[i].pose.position;
      if (kind_ == WorldKind::kPut) moved_m.z = 0;
      verdict.moved_m = std::max(verdict.moved_m, glm::length(moved_m));
      const Vec3 up(0, 0, 1);
      const double cosine =
          glm::dot(glm::conjugate(begun_[i].pose.rotation) * up, glm::conjugate(blocks_[i].pose.rotation) * up);
      verdict.tilt_rad = std::max(verdict.tilt_rad, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
    if (!verdict.finite)
      verdict.wrong = "not_finite";
    else if (verdict.deepFor_s > kMaxDeepFor_s)
      verdict.wrong = "deep";
    else if (verdict.gained_J > allowed_J())
      verdict.wrong = "energy";
    else if (kind_ == WorldKind::kFloating && overlap_m_ < kRounding_m && verdict.moved_m > kMaxFloating_m)
      verdict.wrong = "pulled";
    else if (kind_ == WorldKind::kFloating && verdict.moved_m > overlap_m_ + kMaxDrift_m)
      verdict.wrong = "flung";
    else if (kind_ == WorldKind::kStanding && (verdict.moved_m > kMaxDrift_m || verdict.tilt_rad > kMaxTilt_rad))
      verdict.wrong = "fallen";
    else if (kind_ == WorldKind::kSliding && behind_m() > kMaxCaught_m + kMaxCaught * way_m_)
      verdict.wrong = "caught";
  }
  /// How far what slides is from where it would be on one plate.
  [[nodiscard]] double behind_m() const {
    return glm::distance(blocks_.back().pose.position, begun_.back().pose.position + Vec3(way_m_, 0, 0));
  }

  Random random_;
  WorldKind kind_;
  MovingWorld world_;
  std::vector<std::uint64_t> ids_;
  std::vector<Block> blocks_, begun_;
  std::vector<double> deepFor_, flat_m_;
  double way_m_ = 0;  ///< Of what slides.
  double reach_m_ = 0.3, overlap_m_ = 0, begun_J_ = 0, massRatio_ = 1;
  double bowl_m_ = 0;  ///< The bowl's inner radius; 0: there is none. It is the first body.
};

}  // namespace

bool runFuzzBodies(const FuzzOptions& options, const std::filesystem::path& out) {
  Interruption interruption;
  std::vector<Record> findings;
  std::array<std::uint64_t, kKinds.size()> worlds{}, failed{};
  std::uint64_t done = 0;
  for (; done < options.scenes && !interruption.came(); ++done) {
    const std::uint64_t seed = options.seed + done;
    BlockWorld world(seed);
    const BlockWorld::Verdict verdict = world.run();
    const auto kind = static_cast<std::size_t>(std::ranges::find(kKindNames, world.kind()) - kKindNames.begin());
    ++worlds[kind];
    if (!verdict.wrong.empty()) {
      ++failed[kind];
      findings.push_back({{"fuzz", "bodies"},
                          {"kind", world.kind()},
                          {"seed", seed},
                          {"failure", verdict.wrong},
                          {"blocks", world.blocks()},
                          {"overlap_mm", world.overlap_m() * 1e3},
                          {"mass_ratio", world.massRatio()},
                          {"deepest_mm", verdict.deepest_m * 1e3},
                          {"deep_for_s", verdict.deepFor_s},
                          {"gained_mJ", verdict.gained_J * 1e3},
                          {"moved_mm", verdict.moved_m * 1e3},
                          {"tilt_rad", verdict.tilt_rad},
                          {"waited", verdict.waited},
                          {"pass", false}});
      showFinding(findings.back());
    }
    showProgress(done + 1, options.scenes, kWorldsToALine, findings.size());
  }
  std::vector<Record> records;
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    records.push_back({{"fuzz", "bodies"},
                       {"kind", kKindNames[i]},
                       {"seed", options.seed},
                       {"worlds", worlds[i]},
                       {"failed", failed[i]},
                       {"pass", failed[i] == 0}});
    std::printf("%s\n", measuresText(records.back()).c_str());
  }
  records.insert(records.end(), findings.begin(), findings.end());
  writeRecords(out, "fuzz", records);
  if (interruption.came()) std::printf("interrupted: this is what was found by then\n");
  std::printf("%llu worlds of %d ticks, %zu failed\n", static_cast<unsigned long long>(done), kWorldTicks,
              findings.size());
  return findings.empty();
}

}  // namespace haptics::eval
