#include "tests/eval/scenes/edits_at_rest.h"

#include <algorithm>
#include <limits>

#include "common/deform/dent.h"
#include "common/deform/free_form.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/random_motion.h"
#include "tests/eval/stage.h"
#include "tests/eval/textures/texture_cases.h"
#include "tests/eval/winding.h"

namespace haptics::eval {
namespace {

/// What a tick of 1 ms may change: 30 N/s, and what rounding and the friction's spring add.
constexpr double kMaxStep_N = 0.035;
constexpr int kTicksToBeFelt = 1000;
constexpr int kWatchedTicks = kTicksToBeFelt + 200;
constexpr double kSame_N = 0.01;
/// More than this takes longer at 30 N/s, after the 0.25 s for which an edit may wait.
constexpr double kInTime_N = 22;
constexpr int kScenes = 2;  // of each kind
constexpr int kEditsOfAScene = 10;
/// The HIP stops where the force is larger.
constexpr double kPressed_N = 2.5;

/// What the objects of a scene are like.
struct Kind {
  const char* name;
  int objects;  ///< At most, to begin with.
  bool folded = false;
  bool soft = false;
  double relief_m = 0;
  bool friction = false;
};
constexpr std::array kKinds{
    Kind{.name = "one", .objects = 1},
    Kind{.name = "several", .objects = 6},
    Kind{.name = "folded", .objects = 2, .folded = true},
    Kind{.name = "soft", .objects = 3, .soft = true},
    Kind{.name = "textured", .objects = 3, .relief_m = 0.3e-3},
    Kind{.name = "friction", .objects = 3, .friction = true},
};

struct Counts {
  int edits = 0;
  int kicks = 0;
  int inside = 0;
  int notFelt = 0;
  int notFinite = 0;
  double step_N = 0;

  void add(const Counts& other) {
    edits += other.edits;
    kicks += other.kicks;
    inside += other.inside;
    notFelt += other.notFelt;
    notFinite += other.notFinite;
    step_N = std::max(step_N, other.step_N);
  }
  [[nodiscard]] bool pass() const { return kicks + inside + notFelt + notFinite == 0; }
};

struct Object {
  shapes::Shape shape;
  std::shared_ptr<const CollisionMesh> surface;
  Pose pose;
};

FeltSurface surfaceOf(const Kind& kind, Random& random) {
  FeltSurface felt;
  felt.device = orThrow(findDevicePreset(kDefaultDevicePreset));
  felt.spring_N_per_m = random.between(200, 800);
  if (kind.soft) felt.tissue = SoftTissue{Falloff(random.between(0.01, 0.02), 2), random.between(200, 1000), 0};
  if (kind.friction) felt.properties.friction = Friction{0.6, 0.3, 0, {}};
  if (kind.relief_m > 0) {
    constexpr double kWave_m = 0.003;
    constexpr double kGain = 1.5;
    const TextureCase grating = makeGrating(kWave_m);
    felt.properties.texture = textureOf(grating, kind.relief_m, kGain);
    felt.texture = grating.field;
  }
  return felt;
}

/// One scene: a HIP is pressed against an object, stands still, and something is edited, again and again.
class RestingHip {
 public:
  RestingHip(Renderer& method, const Kind& kind, Random& random)
      : method_(method), kind_(kind), random_(random), felt_(surfaceOf(kind, random)), stage_(method, random) {
    method.setSurfaceProperties(felt_);
    spring_N_per_m_ = felt_.spring_N_per_m;
    for (int i = 1 + random.below(kind.objects); i > 0; --i) addObject(somewhere());
    stage_.begin(hip_);
  }

  Counts run() {
    Counts counts;
    for (int i = 0; i < kEditsOfAScene; ++i) counts.add(editOnce());
    return counts;
  }

 private:
  [[nodiscard]] Vec3 aside(double most_m) { return random_.between(0, most_m) * random_.direction(); }
  [[nodiscard]] Pose somewhere() { return {random_.rotation(), aside(0.03)}; }
  [[nodiscard]] std::size_t someObject() {
    return static_cast<std::size_t>(random_.below(static_cast<int>(objects_.size())));
  }

  [[nodiscard]] shapes::Shape someShape() {
    if (kind_.folded && random_.below(2) == 0) {
      const auto motion = makeFolded(random_, foldedCase(3 * random_.below(3)));
      return motion->bodies()[0].shape;
    }
    if (random_.below(2) == 0) {
      const Vec3 size(random_.between(0.01, 0.05), random_.between(0.01, 0.05), random_.between(0.005, 0.04));
      return shapes::box(size, 1 + random_.below(4));
    }
    const double radius = random_.between(0.01, 0.025);
    const double relief = random_.below(3) == 0 ? random_.between(0.1, 0.4) : random_.between(0, 0.1);
    return shapes::sphere(1, 2 + random_.below(5)).mapped([&](Vec3 v) {
      return v * radius * (1 - random_.between(0, relief));
    });
  }

  void addObject(const Pose& pose) {
    Object object{someShape(), nullptr, pose};
    object.surface = object.shape.build();
    stage_.add(object.surface, pose);
    objects_.push_back(std::move(object));
  }

  Felt approach() {
    constexpr double kStep_m = 0.3e-3;
    constexpr int kMaxTicks = 800;
    constexpr int kStandTicks = 60;
    constexpr double kDeepest_m = 0.008;
    pressed_ = someObject();
    const Object& object = objects_[pressed_];
    const auto t = static_cast<std::size_t>(random_.below(static_cast<int>(object.shape.triangles.size())));
    const Vec3 a = object.shape.corner(t, 0);
    const Vec3 b = object.shape.corner(t, 1);
    const Vec3 c = object.shape.corner(t, 2);
    const Vec3 below = random_.between(0, kDeepest_m) * glm::normalize(glm::cross(b - a, c - a));
    const Vec3 target = toWorld(object.pose, (a + b + c) / 3.0 - below);
    if (random_.below(2) > 0) {
      hip_ = kFar_m * random_.direction();
      stage_.place(hip_);
    }
    Felt felt = stage_.tick(hip_);
    for (int i = 0; i < kMaxTicks && glm::length(felt.force_N) < kPressed_N; ++i) {
      const Vec3 way = target - hip_;
      const double left = glm::length(way);
      if (left == 0) break;
      hip_ += way * std::min(1.0, kStep_m / left);
      felt = stage_.tick(hip_);
    }
    for (int i = 0; i < kStandTicks; ++i) felt = stage_.tick(hip_);
    return felt;
  }

  void move(std::size_t body, const Pose& pose) {
    objects_[body].pose = pose;
    stage_.move(static_cast<int>(body), pose);
  }

  void remesh(std::size_t body) {
    objects_[body].shape = someShape();
    objects_[body].surface = objects_[body].shape.build();
    stage_.replace(static_cast<int>(body), objects_[body].surface);
  }

  /// The same triangles with other vertices.
  template <class Map>
  void refit(std::size_t body, Map map) {
    Object& object = objects_[body];
    for (Vec3f& v : object.shape.vertices) v = map(v);
    object.surface = refitCollisionMesh(*object.surface, object.shape.vertices);
    stage_.replace(static_cast<int>(body), object.surface);
  }

  /// A client pulls at the control points.
  void pullLattice(std::size_t body) {
    constexpr double kPull_m = 0.003;
    constexpr std::array<std::uint32_t, 3> kPoints{3, 3, 3};
    const CollisionMesh& surface = *objects_[body].surface;
    const Vec3 size = surface.high() - surface.low();
    std::vector<Vec3f> control = FreeForm::atRest(surface.low(), size, kPoints);
    for (Vec3f& point : control) point += Vec3f(aside(kPull_m));
    refit(body, FreeForm(surface.low(), size, kPoints, control));
  }

  void dent(std::size_t body) {
    const Falloff falloff(random_.between(0.008, 0.02), 2);
    const auto& vertices = objects_[body].shape.vertices;
    const Vec3f at = vertices[static_cast<std::size_t>(random_.below(static_cast<int>(vertices.size())))];
    const Dent dent{at, Vec3f(aside(maxDentDepth_m(falloff)))};
    refit(body, [&](Vec3f v) { return dented(v, {&dent, 1}, falloff); });
  }

  void edit() {
    const std::size_t body = random_.below(4) > 0 ? pressed_ : someObject();
    const Pose pose = objects_[body].pose;
    switch (random_.below(10)) {
      case 0:
        addObject({random_.rotation(), hip_ + aside(0.02)});
        break;
      case 1:
        addObject(somewhere());
        break;
      case 2:
        if (objects_.size() == 1) addObject(somewhere());
        stage_.remove(static_cast<int>(body));
        objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(body));
        break;
      case 3:
        move(body, {pose.rotation, pose.position + 0.0003 * random_.direction()});
        break;
      case 4:
        move(body, {pose.rotation, pose.position + 0.01 * random_.direction()});
        break;
      case 5:
        move(body, {glm::angleAxis(random_.between(0, 0.3), random_.direction()) * pose.rotation, pose.position});
        break;
      case 6:
        remesh(body);
        break;
      case 7:
        spring_N_per_m_ = random_.between(100, 1500);
        break;
      case 8:
        pullLattice(body);
        break;
      default:
        dent(body);
    }
    stage_.edit(hip_, spring_N_per_m_);
  }

  Counts editOnce() {
    Counts counts;
    counts.edits = 1;
    Felt felt = approach();
    const double begun_N = glm::length(felt.onDevice_N());
    edit();
    Vec3 inTime_N(0);
    for (int i = 0; i < kWatchedTicks; ++i) {
      const Vec3 before_N = felt.onDevice_N();
      felt = stage_.tick(hip_);
      counts.notFinite += isFinite(felt.onDevice_N()) && isFinite(felt.ihip) ? 0 : 1;
      counts.step_N = std::max(counts.step_N, glm::distance(felt.onDevice_N(), before_N));
      if (i == kTicksToBeFelt) inTime_N = felt.onDevice_N();
    }
    counts.kicks = counts.step_N > kMaxStep_N ? 1 : 0;
    judgePlace(felt, counts);
    const bool settled = glm::distance(inTime_N, felt.onDevice_N()) < kSame_N &&
                         glm::distance(felt.onDevice_N(), felt.force_N) < kSame_N;
    // Of what is removed the force goes before another one comes.
    const bool large = begun_N + glm::length(felt.force_N) > kInTime_N;
    if (!settled && !large) counts.notFelt = 1;
    return counts;
  }

  /// In the end. Of a soft body that is pressed only its own dented surface is known to hold the IHIP: what it overlaps is
  /// not judged.
  void judgePlace(const Felt& felt, Counts& counts) const {
    const bool held = glm::length(felt.force_N) > kSame_N;
    double depth = 0;
    double hipDepth = 0;
    double hipAbove = std::numeric_limits<double>::infinity();
    double above = std::numeric_limits<double>::infinity();
    bool inHollow = false;
    int dented = 0;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const Place ihip = placeOf(i, felt.ihip);
      // Where objects overlap, the hollow that the HIP makes in one is one in all.
      inHollow = inHollow || (ihip.depth < onSurface_m() && ihip.depthAtRest > onSurface_m());
      const bool isOther = kind_.soft && held && method_.dents(i).empty();
      if (!isOther) depth = std::max(depth, ihip.depth);
      dented += method_.dents(i).empty() ? 0 : 1;
      const Place hip = placeOf(i, hip_);
      hipDepth = std::max(hipDepth, hip.depth);
      const double bulge_m = method_.highestBulge_m(i);
      hipAbove = std::min(hipAbove, hip.away - bulge_m);
      above = std::min(above, ihip.away - (kind_.soft ? bulge_m : 0));
    }
    counts.inside = depth > (kind_.soft ? onSurface_m() : kWithin_m) && !inHollow ? 1 : 0;
    const bool onBulge = hipDepth == 0 && hipAbove < 0;
    const double onSeveral_m = dented > 1 ? kOnSeveral_m : 0;
    const bool rightly = held ? above < onSurface_m() + onSeveral_m || onBulge : hipDepth < kHardlyInside_m;
    counts.notFelt = rightly ? 0 : 1;
  }

  [[nodiscard]] double onSurface_m() const { return kOnSurface_m + kind_.relief_m; }

  /// Of a point and a body, m. A dent is between the chords of its moved vertices and the exact map of the shape at rest:
  /// what is inside of both is inside, what is on either or between the two is on the surface.
  struct Place {
    double depth = 0;
    double away = 0;
    double depthAtRest = 0;
  };
  [[nodiscard]] Place placeOf(std::size_t body, Vec3 point) const {
    const Object& object = objects_[body];
    const Vec3 local = toLocal(object.pose, point);
    const WindingMesh atRest(object.shape.vertices, object.shape.triangles);
    const double depth = atRest.depthInside(local);
    const std::vector<Dent> dents = method_.dents(body);
    if (dents.empty()) return {depth, atRest.distanceTo(local), depth};
    std::vector<Vec3f> vertices = object.shape.vertices;
    for (Vec3f& v : vertices) v = dented(v, dents, felt_.tissue->falloff);
    const WindingMesh chords(vertices, object.shape.triangles);
    const Vec3 exact = undented(body, local);
    const double inChords = chords.depthInside(local);
    const double inExact = atRest.depthInside(exact);
    const bool isBetween = (inChords > 0) != (inExact > 0);
    const double away = isBetween ? 0 : std::min(chords.distanceTo(local), atRest.distanceTo(exact));
    return {std::min(inChords, inExact), away, depth};
  }

  /// Where a place of the body (object frame) is without its dents: each is undone by the fixed point of
  /// x = y - displacement(x), which kMaxDentGradient makes a contraction.
  [[nodiscard]] Vec3 undented(std::size_t body, Vec3 place) const {
    constexpr int kIterations = 60;
    std::vector<Dent> dents = method_.dents(body);
    for (; !dents.empty(); dents.pop_back()) {
      const Vec3 yielded = place;
      for (int i = 0; i < kIterations; ++i) {
        place = yielded - displacementBy(dents.back(), felt_.tissue->falloff, place);
      }
    }
    return place;
  }

  /// Outside of all.
  static constexpr double kFar_m = 0.15;
  static constexpr double kOnSurface_m = 1e-6;
  /// Where several dented bodies hold the IHIP, it is on the planes of their lines and vertices.
  static constexpr double kOnSeveral_m = 2e-4;
  /// A HIP that is deeper is to be held: deeper than the relief, and with the softest spring of more than kSame_N.
  static constexpr double kHardlyInside_m = 1e-3;

  Renderer& method_;
  Kind kind_;
  Random& random_;
  FeltSurface felt_;
  Stage stage_;
  std::vector<Object> objects_;
  double spring_N_per_m_ = 0;
  std::size_t pressed_ = 0;  // object that the HIP went to
  Vec3 hip_{kFar_m, 0, 0};
};

}  // namespace

bool editUnderRestingHip(Renderer& method, Random& random, SceneResult& result) {
  Counts all;
  for (const Kind& kind : kKinds) {
    Counts counts;
    for (int i = 0; i < kScenes; ++i) counts.add(RestingHip(method, kind, random).run());
    const std::string name = std::string("at_rest_") + kind.name;
    result.measures[name + "_kicks"] = counts.kicks;
    result.measures[name + "_inside_after"] = counts.inside;
    result.measures[name + "_not_felt"] = counts.notFelt;
    all.add(counts);
  }
  result.measures["at_rest_edits"] = all.edits;
  result.measures["at_rest_force_step_N"] = all.step_N;
  result.measures["at_rest_nan_ticks"] = all.notFinite;
  return all.pass();
}

}  // namespace haptics::eval
