// What effects take from a mesh, against every triangle, edge and vertex of it.
#include "haptic_server/engine/effects/near_mesh.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/mesh/generators.h"
#include "tests/haptic_server/engine/effects/effect_laws.h"

namespace haptics::near_mesh_test {
namespace {

using namespace effect_laws;

/// A mesh, and its edges with the polygons along them.
struct Model {
  explicit Model(TriMesh made) : mesh(std::move(made)), surface(buildCollisionMesh(mesh.vertices, mesh.triangles)) {
    std::map<std::array<std::uint32_t, 2>, std::vector<Vec3>> normals;
    for (const auto& triangle : mesh.triangles) {
      const Vec3 n = glm::normalize(glm::cross(at(triangle[1]) - at(triangle[0]), at(triangle[2]) - at(triangle[0])));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(triangle[k], triangle[(k + 1) % 3]);
        normals[{low, high}].push_back(n);
      }
    }
    for (const auto& [edge, along] : normals) {
      const bool bends = along.size() == 1 || std::acos(std::clamp(glm::dot(along[0], along[1]), -1.0, 1.0)) >
                                                  29.999 * std::numbers::pi / 180;
      if (bends) edges.push_back(edge);
    }
  }
  [[nodiscard]] Vec3 at(std::uint32_t vertex) const { return Vec3(mesh.vertices[vertex]); }

  TriMesh mesh;
  std::shared_ptr<const CollisionMesh> surface;
  std::vector<std::array<std::uint32_t, 2>> edges;  // sharp ones
};

TriMesh openBox() {
  TriMesh box = makeBox(Vec3(0.06, 0.04, 0.05), 3).value();
  std::erase_if(box.triangles, [&](const auto& triangle) {
    return std::ranges::all_of(triangle, [&](std::uint32_t v) { return box.vertices[v].z > 0.02F; });
  });
  return box;
}

const std::vector<Model>& models() {
  static const std::vector<Model> all = [] {
    std::vector<Model> made;
    made.emplace_back(makeBox(Vec3(0.06, 0.04, 0.05), 3).value());
    made.emplace_back(makeCylinder(0.03, 0.05, 20).value());
    made.emplace_back(makeTorus(0.03, 0.012, 10, 6).value());
    made.emplace_back(openBox());
    return made;
  }();
  return all;
}

Vec3 nearestOfSegment(Vec3 a, Vec3 b, Vec3 x) {
  return glm::mix(a, b, std::clamp(glm::dot(x - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0));
}

Vec3 nearestOfTriangle(Vec3 a, Vec3 b, Vec3 c, Vec3 x) {
  const Vec3 n = glm::normalize(glm::cross(b - a, c - a));
  const Vec3 foot = x - glm::dot(x - a, n) * n;
  const auto isWithin = [&](Vec3 p, Vec3 q) { return glm::dot(glm::cross(q - p, foot - p), n) >= 0; };
  if (isWithin(a, b) && isWithin(b, c) && isWithin(c, a)) return foot;
  Vec3 best = nearestOfSegment(a, b, x);
  for (const Vec3 other : {nearestOfSegment(b, c, x), nearestOfSegment(c, a, x)}) {
    if (glm::distance(other, x) < glm::distance(best, x)) best = other;
  }
  return best;
}

Vec3 nearestOfSurface(const Model& model, Vec3 x) {
  Vec3 best(1e9);
  for (const auto& [a, b, c] : model.mesh.triangles) {
    const Vec3 point = nearestOfTriangle(model.at(a), model.at(b), model.at(c), x);
    if (glm::distance(point, x) < glm::distance(best, x)) best = point;
  }
  return best;
}

/// Out of the vertex, against the edge that comes from `from`: the mean with the one that goes on; 0: none or several do.
Vec3 goesOn(const Model& model, std::uint32_t vertex, std::uint32_t from) {
  std::vector<std::uint32_t> others;
  for (const auto& [a, b] : model.edges) {
    if (a == vertex && b != from) others.push_back(b);
    if (b == vertex && a != from) others.push_back(a);
  }
  if (others.size() != 1) return Vec3(0);
  return glm::normalize(glm::normalize(model.at(vertex) - model.at(from)) +
                        glm::normalize(model.at(others[0]) - model.at(vertex)));
}

struct OnEdge {
  Vec3 point{1e9};
  Vec3 along{0};
};

OnEdge nearestOfEdges(const Model& model, Vec3 x) {
  OnEdge best;
  std::array<std::uint32_t, 2> edge{};
  for (const auto& [a, b] : model.edges) {
    const Vec3 point = nearestOfSegment(model.at(a), model.at(b), x);
    if (!(glm::distance(point, x) < glm::distance(best.point, x))) continue;
    best.point = point;
    edge = {a, b};
  }
  const Vec3 a = model.at(edge[0]), b = model.at(edge[1]);
  const double length = glm::distance(a, b), come = glm::distance(a, best.point);
  const Vec3 first = -goesOn(model, edge[0], edge[1]), last = goesOn(model, edge[1], edge[0]);
  const Vec3 along = (b - a) / length;
  const double corner = std::min(0.002, length / 4);
  best.along =
      glm::normalize(glm::mix(first == Vec3(0) ? along : first, last == Vec3(0) ? along : last, come / length));
  const double fromFirst = first == Vec3(0) ? come : corner, fromLast = last == Vec3(0) ? length - come : corner;
  best.along *= std::min({fromFirst, fromLast, corner}) / corner;
  return best;
}

Vec3 forceOf(const EffectField& field, const Model& model, EffectMemory& memory, Vec3 hip, Vec3 v) {
  Allowance endless;
  return field.felt(memory, hip, v, kPeriod_s, field.near(*model.surface, hip, endless)).force_N;
}

TEST(NearMesh, MagnetsAndSnapsFollowTheirClosedForms) {
  Random random(31);
  for (const Kind kind : {Kind::kMagnet, Kind::kSpringToVertex, Kind::kSpringToEdge}) {
    int felt = 0;
    for (int i = 0; i < kStates; ++i) {
      const Model& model = models()[static_cast<std::size_t>(i) % models().size()];
      Effect effect = randomSpring(kind, random);
      if (!(effect.reach_m > 0)) effect.reach_m = 0.05;
      EffectMemory memory;
      memory.holds = random.chance();
      const bool held = memory.holds;
      const Vec3 hip = random.vector(0.06), v = random.vector(0.5);
      Vec3 expected;
      if (kind == Kind::kMagnet) {
        const Vec3 way = nearestOfSurface(model, hip) - hip;
        const double d = glm::length(way), pull = effect.stiffness_N_per_m * d;
        const double damping = std::clamp(-effect.damping_Ns_per_m * glm::dot(v, way / d), -pull, pull);
        Effect undamped = effect;
        undamped.limit_N = undamped.damping_Ns_per_m = 0;
        const double weight = glm::length(springLaw(undamped, way, Vec3(0), held)) / pull;
        expected = weight * atMost((pull + damping) / d * way, effect.limit_N);
      } else if (kind == Kind::kSpringToVertex) {
        Vec3 nearest(1e9);
        for (const auto& triangle : model.mesh.triangles) {
          for (const std::uint32_t k : triangle) {
            if (glm::distance(model.at(k), hip) < glm::distance(nearest, hip)) nearest = model.at(k);
          }
        }
        expected = springLaw(effect, nearest - hip, v, held);
      } else if (!model.edges.empty()) {
        const OnEdge on = nearestOfEdges(model, hip);
        expected = springLaw(effect, on.point - hip, v - glm::dot(v, on.along) * on.along, held);
      }
      const Vec3 is = forceOf(EffectField(effect), model, memory, hip, v);
      felt += is != Vec3(0) ? 1 : 0;
      ASSERT_LE(glm::distance(is, expected), kClose_N) << static_cast<int>(kind) << " state " << i;
    }
    EXPECT_GT(felt, kStates / 2);
  }
}

/// Of the solid angles of all triangles (Van Oosterom and Strackee 1983), over 4 pi.
double windingOf(const TriMesh& mesh, Vec3 x) {
  double sum = 0;
  for (const auto& triangle : mesh.triangles) {
    const Vec3 a = Vec3(mesh.vertices[triangle[0]]) - x, b = Vec3(mesh.vertices[triangle[1]]) - x;
    const Vec3 c = Vec3(mesh.vertices[triangle[2]]) - x;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

/// A box through a box: where both are, it winds twice.
TriMesh twoBoxes() {
  TriMesh both = makeBox(Vec3(0.06, 0.04, 0.05), 2).value();
  const TriMesh other = makeBox(Vec3(0.03, 0.09, 0.02), 2).value();
  const auto first = static_cast<std::uint32_t>(both.vertices.size());
  both.vertices.insert(both.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) both.triangles.push_back({first + a, first + b, first + c});
  return both;
}

TEST(NearMesh, TheInsideIsWhereTheSurfaceWinds) {
  Random random(32);
  const std::array closed{Model(makeTorus(0.03, 0.012, 10, 6).value()), Model(twoBoxes()),
                          Model(makeCylinder(0.03, 0.05, 20).value())};
  std::array<int, 3> felt{};
  for (int i = 0; i < kStates; ++i) {
    const std::size_t which = static_cast<std::size_t>(i) % closed.size();
    const Model& model = closed[which];
    Effect effect{.kind = Kind::kViscosity, .damping_Ns_per_m = random.number(0.1, 20)};
    effect.region = Effect::Region::kInside;
    effect.fade_m = random.chance() ? random.number(1e-4, 0.02) : 0;
    const Vec3 hip = random.vector(0.045), v = random.vector(0.5);
    const bool isInside = windingOf(model.mesh, hip) > 0.5;
    const double weight = isInside ? smooth(glm::distance(nearestOfSurface(model, hip), hip), effect.fade_m) : 0;
    EffectMemory memory;
    const Vec3 is = forceOf(EffectField(effect), model, memory, hip, v);
    ASSERT_LE(glm::distance(is, -weight * effect.damping_Ns_per_m * v), kClose_N) << which << " state " << i;
    felt[which] += isInside ? 1 : 0;
  }
  for (const int inside : felt) EXPECT_GT(inside, kStates / 100);
}

TEST(NearMesh, ConservativeOnesGiveNothingRoundALoop) {
  Random random(33);
  constexpr int kLoops = 10'000;
  double worst_J = 0;
  for (int i = 0; i < kLoops; ++i) {
    const Model& model = models()[static_cast<std::size_t>(i) % models().size()];
    Effect effect = randomSpring(static_cast<Kind>(12 + i / 4 % 3), random);
    effect.damping_Ns_per_m = effect.release_m = 0;
    if (!(effect.reach_m > 0)) effect.reach_m = 0.05;
    effect.fade_m = std::max(effect.fade_m, 0.2 * effect.reach_m);
    effect.stiffness_N_per_m = std::min(effect.stiffness_N_per_m, 300.0);
    const EffectField field(effect);
    std::array<Vec3, 5> loop;
    for (Vec3& part : loop) part = random.vector(0.005);
    const auto& vertices = model.mesh.vertices;
    loop[0] += Vec3(vertices[static_cast<std::size_t>(i) % vertices.size()]);
    const auto force = [&, memory = EffectMemory{}](Vec3 hip) mutable {
      return forceOf(field, model, memory, hip, Vec3(0));
    };
    const double work_J = std::abs(workRound(force, loop));
    ASSERT_LE(work_J, 10e-6) << "loop " << i << " kind " << static_cast<int>(effect.kind);
    worst_J = std::max(worst_J, work_J);
  }
  RecordProperty("worst_uJ", std::to_string(1e6 * worst_J));
}

/// At the middle of a ball all of it is as near.
TEST(NearMesh, QueriesEndWithTheirAllowance) {
  const Model ball(makeSphere(0.05, 40).value());
  Effect effect{.kind = Kind::kMagnet, .stiffness_N_per_m = 100, .reach_m = 0.1};
  for (const Kind kind : {Kind::kMagnet, Kind::kSpringToVertex, Kind::kSpringToEdge, Kind::kViscosity}) {
    effect.kind = kind;
    if (kind == Kind::kViscosity) effect.region = Effect::Region::kInside;
    effect.fade_m = 0.1;
    Allowance allowance(20'000);
    static_cast<void>(EffectField(effect).near(*ball.surface, Vec3(0), allowance));
    EXPECT_TRUE(allowance.isSpent()) << static_cast<int>(kind);
    EXPECT_GT(allowance.left(), -4'000) << static_cast<int>(kind);
  }
}

}  // namespace
}  // namespace haptics::near_mesh_test
