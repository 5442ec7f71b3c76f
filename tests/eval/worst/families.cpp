#include "tests/eval/worst/families.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "common/mesh/generators.h"
#include "common/surface/make_field.h"
#include "tests/eval/moving_world.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/random.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval {
namespace {

using Genes = std::span<const double, Family::kGenes>;
using SurfacePointer = std::shared_ptr<const CollisionMesh>;

constexpr double kRoom_m = 0.05;  ///< Half of the cube that a scene fills.

int whole(double gene, double least, double most) { return static_cast<int>(least * std::pow(most / least, gene)); }
double real(double gene, double least, double most) { return least + gene * (most - least); }
Random randomOf(double gene) { return Random(static_cast<std::uint64_t>(gene * 1e6)); }
Vec3 inRoom(Random& random) {
  return kRoom_m * Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
}

std::shared_ptr<const ServoScene> sceneOf(const std::vector<ServoObject>& objects) {
  auto scene = std::make_shared<ServoScene>();
  scene->revision = 1;
  scene->objects = objects;
  return scene;
}
ServoObject objectOf(std::uint64_t id, SurfacePointer surface, const Pose& pose = {}) {
  return {.id = id, .surface = std::move(surface), .pose = pose, .stiffness_N_per_m = 1000};
}
std::shared_ptr<const ServoScene> sceneOf(const shapes::Shape& shape) { return sceneOf({objectOf(1, shape.build(2))}); }

/// Triangles anywhere, as long as the room at the most.
shapes::Shape soupOf(int count, double size, Random& random) {
  shapes::Shape soup;
  for (int i = 0; i < count; ++i) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    const Vec3 middle = inRoom(random) * (1 - size);
    for (int k = 0; k < 3; ++k) soup.vertices.emplace_back(middle + size * inRoom(random));
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

std::shared_ptr<const ServoScene> makeSoup(Genes genes) {
  Random random = randomOf(genes[2]);
  return sceneOf(soupOf(whole(genes[0], 100, 4000), real(genes[1], 0.2, 1), random));
}

std::shared_ptr<const ServoScene> makeLargeSoup(Genes genes) {
  Random random = randomOf(std::floor(genes[2] * 3) / 3);
  return sceneOf(soupOf(20'000, 1, random));
}

std::shared_ptr<const ServoScene> makeNeedles(Genes genes) {
  Random random = randomOf(genes[2]);
  shapes::Shape needles;
  const double height = real(genes[1], 0.0001, 0.02);
  for (int i = whole(genes[0], 100, 10'000); i > 0; --i) {
    const auto first = static_cast<std::uint32_t>(needles.vertices.size());
    const Vec3 at = inRoom(random) * Vec3(1, 1, 0);
    needles.vertices.emplace_back(at);
    needles.vertices.emplace_back(at + Vec3(1e-5, 0, 0));
    needles.vertices.emplace_back(-at.x, -at.y, height * random.between(-1, 1));
    needles.triangles.push_back({first, first + 1, first + 2});
  }
  return sceneOf(needles);
}

std::shared_ptr<const ServoScene> makeFans(Genes genes) {
  return sceneOf(
      shapes::cone(real(genes[1], 0.02, kRoom_m), real(genes[2], 0.001, 0.05), whole(genes[0], 100, 30'000)));
}

shapes::Shape someBox(Random& random, double spread) {
  const Vec3 size =
      0.04 * Vec3(1 + 0.3 * random.between(-1, 1), 1 + 0.3 * random.between(-1, 1), 1 + 0.3 * random.between(-1, 1));
  shapes::Shape placed;
  placed.add(shapes::box(size), spread * inRoom(random));
  return placed;
}

std::shared_ptr<const ServoScene> makeNested(Genes genes) {
  Random random = randomOf(genes[2]);
  shapes::Shape all;
  for (int i = whole(genes[0], 8, 400); i > 0; --i) all.add(someBox(random, genes[1]));
  return sceneOf(all);
}

std::shared_ptr<const ServoScene> makeBoxes(Genes genes) {
  Random random = randomOf(genes[2]);
  std::vector<ServoObject> objects;
  for (int i = whole(genes[0], 4, 257); i > 0; --i) {
    const SurfacePointer box = someBox(random, 0).build();
    objects.push_back(objectOf(objects.size() + 1, box, {random.rotation(), genes[1] * inRoom(random)}));
  }
  return sceneOf(objects);
}

std::shared_ptr<const ServoScene> makeSheets(Genes genes) {
  shapes::Shape stack;
  const int count = whole(genes[0], 4, 2000);
  const double height = std::pow(10.0, real(genes[1], -7, -1.7));
  const shapes::Shape one = shapes::sheet(2 * kRoom_m, whole(genes[2], 1, 8));
  for (int i = 0; i < count; ++i) stack.add(one, {0, 0, height * i / count});
  return sceneOf(stack);
}

std::shared_ptr<const ServoScene> makeComb(Genes genes) {
  shapes::Shape comb;
  const int teeth = whole(genes[0], 4, 1000);
  const double pitch = 2 * kRoom_m / teeth;
  const shapes::Shape tooth = shapes::box({pitch * real(genes[1], 0.1, 0.99), 0.04, 0.02}, whole(genes[2], 1, 4));
  for (int i = 0; i < teeth; ++i) comb.add(tooth, {pitch * (i - teeth / 2.0), 0, 0});
  return sceneOf(comb);
}

std::shared_ptr<const ServoScene> makeFine(Genes genes) {
  const int n = whole(genes[0], 8, 200);
  return sceneOf(genes[1] < 0.5 ? shapes::sphere(0.04, n) : shapes::bumpy(0.04, n));
}

std::shared_ptr<const ServoScene> makeMoving(Genes genes) {
  Random random = randomOf(genes[2]);
  std::vector<ServoObject> objects;
  for (int i = whole(genes[0], 2, 33); i > 0; --i) {
    const MovingSolid solid =
        solidFrom(random.below(2) == 0 ? makeBox({0.02, 0.03, 0.04}, 2).value() : makeSphere(0.02, 12).value(), 0.1);
    RigidBody body = solid.body;
    body.gravity_m_per_s2 = {0, 0, -9.81};
    body.spring = {real(genes[3], 0, 500), 0, 0.05, 0};
    for (std::size_t p = 0; p < 4; ++p) {
      const double angle = std::numbers::pi / 2 * static_cast<double>(p);
      const Vec3 normal = glm::normalize(Vec3(std::cos(angle), std::sin(angle), 1));
      body.planes[p] = {.normal = normal, .offset_m = -0.03, .friction = 0.5};
    }
    body.planeCount = 4;
    ServoObject object = objectOf(objects.size() + 1, solid.surface, {random.rotation(), genes[1] * inRoom(random)});
    object.motion = std::make_shared<RigidBody>(body);
    objects.push_back(object);
  }
  return sceneOf(objects);
}

SurfaceProperties everyProperty(Random& random) {
  FourierFamily waves;
  for (int i = 0; i < 64; ++i) {
    waves.terms.push_back({1.0 / 64, random.direction(), random.between(0.002, 0.02), random.between(0, 6)});
  }
  SurfaceProperties properties;
  properties.shading = Shading{.crease_rad = 1, .creases = {}};
  properties.texture = Texture{.family = waves, .amplitude_m = 1e-4};
  properties.friction = Friction{.mu_static = 0.5, .mu_dynamic = 0.3, .variation = 0.5, .over = FieldFamily(waves)};
  properties.stiffnessOver = SurfaceMap{.variation = 0.3, .over = FieldFamily(waves)};
  return properties;
}

ServoObject dressed(ServoObject object, Random& random, bool soft) {
  const SurfaceProperties properties = everyProperty(random);
  const auto field = orThrow(makeField(properties.texture->family, [](const ContentHash&) { return nullptr; }));
  object.detail =
      makeSurfaceDetail(*object.surface, properties,
                        {.texture = field, .friction = field, .frictionScale = nullptr, .stiffness = {field}});
  if (soft) object.tissue = std::make_shared<const SoftTissue>(SoftTissue{Falloff(0.01, 3), 300, 0.3, 0.5});
  return object;
}

std::shared_ptr<const ServoScene> makeDressed(Genes genes) {
  Random random = randomOf(genes[2]);
  std::vector<ServoObject> objects;
  for (int i = whole(genes[0], 1, 257); i > 0; --i) {
    const SurfacePointer surface =
        random.below(2) == 0 ? shapes::box(Vec3(0.03), 6).build() : shapes::sphere(0.02, 8).build();
    const ServoObject object = objectOf(objects.size() + 1, surface, {random.rotation(), genes[1] * inRoom(random)});
    objects.push_back(dressed(object, random, random.between(0, 1) < genes[3]));
  }
  return sceneOf(objects);
}

std::shared_ptr<const ServoScene> makeDents(Genes genes) {
  Random random = randomOf(genes[2]);
  const int n = whole(genes[0], 6, 60);
  std::vector<ServoObject> objects{dressed(objectOf(1, shapes::bumpy(0.04, n).build()), random, true)};
  for (int i = whole(genes[1], 1, 8); i > 1; --i) {
    objects.push_back(dressed(
        objectOf(objects.size() + 1, shapes::sphere(0.02, n).build(), {{1, 0, 0, 0}, inRoom(random)}), random, true));
  }
  return sceneOf(objects);
}

constexpr std::array kFamilies{
    Family{"soup", "100 to 4,000 long triangles", makeSoup},
    Family{"large_soup", "20,000 long triangles", makeLargeSoup},
    Family{"needles", "thin triangles through one place", makeNeedles},
    Family{"fans", "up to 30,000 triangles about a vertex", makeFans},
    Family{"nested", "boxes that overlap, in one mesh", makeNested},
    Family{"boxes", "boxes that overlap, each an object", makeBoxes},
    Family{"sheets", "stacks of sheets, down to 0.1 um apart", makeSheets},
    Family{"comb", "up to 1,000 teeth", makeComb},
    Family{"fine", "fine spheres, smooth and bumpy", makeFine},
    Family{"moving", "up to 32 bodies on four planes each", makeMoving, false},
    Family{"dressed", "up to 256 objects, each with every feature, in one place", makeDressed, false},
    Family{"dents", "soft bodies with every feature", makeDents, false},
};

}  // namespace

std::span<const Family> families() { return kFamilies; }

const Family& findFamily(std::string_view name) {
  const auto* found = std::ranges::find(kFamilies, name, &Family::name);
  if (found != kFamilies.end()) return *found;
  std::string known;
  for (const Family& family : kFamilies) known += (known.empty() ? "" : ", ") + std::string(family.name);
  throw std::invalid_argument("there is no family " + std::string(name) + "; there are " + known);
}

}  // namespace haptics::eval
