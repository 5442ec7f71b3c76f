#include "tests/eval/combinations/solo.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "tests/eval/combinations/bench.h"
#include "tests/eval/combinations/bodies.h"
#include "tests/eval/combinations/deformed_shape.h"

namespace haptics::eval {
namespace {

constexpr double kPi = std::numbers::pi;

/// One body with two features, its stroke, and the reference of both.
class Solo {
 public:
  Solo(Feature a, Feature b, Ablation ablation, Random& random, const Method* guest)
      : a_(a), b_(b), ablation_(ablation), guest_(guest), round_(has(Feature::kShading)), shape_(exactShape()) {
    draw(random);
    if (guest_ != nullptr) skin_.variation = 0;
  }

  [[nodiscard]] PairResult run() {
    PairResult result;
    stroke(result);
    const bool conservative = isElastic() && !has(Feature::kTexture) && !has(Feature::kMotion);
    if (has(Feature::kFriction) || conservative) loop(result);
    return result;
  }

 private:
  [[nodiscard]] bool has(Feature feature) const { return a_ == feature || b_ == feature; }
  [[nodiscard]] bool yields() const { return has(Feature::kSoftness) || has(Feature::kPlastic); }
  [[nodiscard]] bool isElastic() const { return !has(Feature::kFriction) && !has(Feature::kPlastic); }
  /// It is pressed and let go at one place; a stroke leaves marks of its own in what is pressed unevenly.
  [[nodiscard]] bool isPressed() const { return has(Feature::kSoftness) && has(Feature::kPlastic); }
  [[nodiscard]] DeformedShape exactShape() const {
    return round_ ? DeformedShape::sphere(kBallRadius_m) : DeformedShape::plane(kPadSide_m / 2);
  }
  [[nodiscard]] std::vector<Effect> effects() const {
    return has(Feature::kEffects) ? pulls_.effects() : std::vector<Effect>{};
  }
  [[nodiscard]] double share() const { return yields() ? contact_N_per_m_ / (contact_N_per_m_ + tissue_N_per_m_) : 0; }

  void draw(Random& random) {
    frame_ = {random.rotation(), random.direction() * random.between(0, 0.2)};
    contact_N_per_m_ = random.between(600, 1000);
    tissue_N_per_m_ = random.between(300, 600);
    falloff_m_ = random.between(0.018, 0.022);
    plastic_ = random.between(0.4, 0.9);
    depth_m_ = yields() ? random.between(0.002, 0.0045) : random.between(0.001, 0.0025);
    wave_ = random.between(0.05, 0.15);
    wave_Hz_ = random.between(1, 3);
    speed_m_per_s_ = random.between(0.03, 0.1);
    length_m_ = random.between(0.025, 0.035);
    const double heading = random.between(0, 2 * kPi);
    start_ = round_ ? random.direction() * kBallRadius_m
                    : Vec3{random.between(-0.008, 0.008), random.between(-0.008, 0.008), kPadSide_m / 2};
    const auto at = shape_.at(start_);
    along_ = at.tangent[0] * std::cos(heading) + at.tangent[1] * std::sin(heading);
    if (!round_) start_ -= along_ * (length_m_ / 2);
    pressed_m_ = random.between(0.002, 0.004);
    skin_ = randomSkin(a_, b_, random);
    if (has(Feature::kLattice)) {
      lattice_ = randomLattice(kPadSide_m, random);
      shape_.shapeBy(*lattice_);
    }
    slider_ = randomSlider(random);
    pulls_ = randomPulls(random);
  }

  [[nodiscard]] const TriMesh& mesh() const {
    if (round_) return has(Feature::kPlastic) ? fineBall() : ball();
    if (has(Feature::kPlastic)) return clayPad();
    return yields() || lattice_ ? finePad() : coarsePad();
  }

  [[nodiscard]] ServoObject object(std::shared_ptr<const CollisionMesh> surface, bool moved) const {
    ServoObject object{.id = 1, .surface = std::move(surface), .pose = {}, .stiffness_N_per_m = contact_N_per_m_};
    Skin skin = skin_;
    skin.shaded = (skin.shaded || yields()) && !(ablation_ == Ablation::kFacets && yields());
    const bool displaced = ablation_ == Ablation::kFieldsAtDisplacedPoints;
    std::shared_ptr<const std::vector<Vec3f>> material;
    if (moved) material = {std::shared_ptr<const void>(), &mesh().vertices};
    object.detail = detailOf(skin, *object.surface, displaced ? &shift_ : nullptr, material);
    if (yields()) {
      object.tissue = std::make_shared<const SoftTissue>(
          SoftTissue{Falloff(falloff_m_, 2), tissue_N_per_m_, 0, has(Feature::kPlastic) ? plastic_ : 0});
    }
    object.baked.shape = 1;
    if (has(Feature::kMotion)) object.motion = slider_.body(mesh());
    return object;
  }

  [[nodiscard]] ServoObject freshObject() const {
    if (!lattice_) return object(atRest(mesh()), false);
    return object(refitCollisionMesh(*atRest(mesh()), shapedBy(*lattice_, mesh().vertices)), true);
  }

  /// A dent that stays, pressed in the middle of the stroke to come, and baked as the builder does. What stays has its
  /// centre where the contact began (relaxing dents' rule for even grooves), and there the depth of the deepest one.
  void pressDent(Bench& bench, const ServoObject& before, DeformedShape& shape, PairResult& result) {
    constexpr int kPressed = 1500;  // ticks: down, up, and at rest until the dent stays
    constexpr double kAway_m = -0.01;
    const auto at = shape.at(shape.walked(start_, along_ * (length_m_ / 2)));
    std::optional<Vec3> begun;
    DeformedShape::Point deepest = at;
    double most_m = 0;
    for (int i = 0; i < kPressed; ++i) {
      const double t = i * kTick_s;
      const double depth_m = t < 2 * kApproach_s ? approach_m(std::min(t, 2 * kApproach_s - t), pressed_m_) : kAway_m;
      const Vec3 hip = at.place - at.normal * depth_m;
      (void)bench.tick(hip);
      const Vec3 h = toLocal(bench.poseOf(0), hip);
      const auto point = shape.nearest(h, at.material);
      const double below_m = glm::dot(point.place - h, point.normal);
      if (below_m > 0 && !begun) begun = point.place;
      if (below_m > most_m) most_m = below_m, deepest = point;
    }
    const HapticState& state = bench.state();
    if (state.dents.count != 1 || !state.dents[0].stays || !begun) {
      result.worst(Measure::kBadTicks, 1);
      return;
    }
    const double apart = glm::distance(*begun, deepest.place) / falloff_m_;
    const double there = (1 - apart * apart) * (1 - apart * apart);
    shape.dent({*begun, -deepest.normal * (there * plastic_ * share() * most_m), falloff_m_, 2});
    std::vector<Vec3f> vertices = lattice_ ? shapedBy(*lattice_, mesh().vertices) : mesh().vertices;
    for (Vec3f& v : vertices) v = dented(v, {&state.dents[0].dent, 1}, before.tissue->falloff);
    ServoObject dentedObject = object(refitCollisionMesh(*before.surface, vertices), true);
    dentedObject.motion = before.motion;
    dentedObject.baked.upTo = state.dents[0].number;
    bench.adopt({dentedObject});
  }

  /// Where the hand is on the shape, and how deep.
  struct Way {
    double along_m = 0;
    double depth_m = 0;
    bool judged = false;
  };
  [[nodiscard]] Way wayAt(int tick) const {
    const double t = tick * kTick_s;
    const double stroke_s = t - kBeforeStroke_s;
    Way way;
    const double deep_m = isPressed() ? depth_m_ / 2 : depth_m_;
    way.depth_m = approach_m(t, deep_m);
    if (stroke_s < 0) return way;
    const double phase = 2 * kPi * wave_Hz_ * stroke_s;
    if (isPressed()) {
      way.depth_m = depth_m_ * (0.75 - 0.25 * std::cos(phase));
    } else {
      way.along_m = std::min(stroke_s * speed_m_per_s_, length_m_);
      if (!has(Feature::kPlastic)) way.depth_m = depth_m_ * (1 + wave_ * std::sin(phase));
    }
    constexpr double kRubbed_m = 8e-3, kSettled_m = 1e-3;
    way.judged = isPressed() || way.along_m > (has(Feature::kFriction) ? kRubbed_m : kSettled_m);
    return way;
  }
  [[nodiscard]] int strokeTicks() const {
    const double stroke_s = isPressed() ? 1 : length_m_ / speed_m_per_s_;
    return static_cast<int>((kBeforeStroke_s + stroke_s) / kTick_s);
  }

  /// Ticks in which effects are let in, at 30 N/s, and a body comes to rest in their pull: faster than any stroke, for which the step of
  /// first order is meant.
  static constexpr int kLetIn = 500;

  /// The exact shape's answer to a HIP in the body's frame.
  struct Answer {
    DeformedShape::Point point;
    Vec3 normal_N{0};
    double pressing_N = 0;
    double height_m = 0;
  };
  [[nodiscard]] Answer answer(const DeformedShape& shape, Vec3 h, Vec3 from, double& deepestYield_m) const {
    Answer answer;
    answer.point = shape.nearest(h, from);
    const Vec3 n = answer.point.normal;
    const double depth_m = glm::dot(answer.point.place - h, n);
    double yielded_m = share() * std::max(0.0, depth_m);
    if (isPressed()) {
      deepestYield_m = std::max(deepestYield_m, yielded_m);
      yielded_m = std::max(yielded_m, plastic_ * deepestYield_m);
    }
    const double contact_m = depth_m - yielded_m;
    answer.pressing_N = contact_N_per_m_ * std::max(0.0, contact_m);
    answer.normal_N = answer.pressing_N * n;
    if (skin_.textureHeight_m > 0) {
      const Vec3 material = answer.point.material;
      answer.height_m = skin_.height_m(material);
      answer.normal_N = contact_N_per_m_ * printedForce(contact_m, n, answer.height_m,
                                                        answer.point.gradient(skin_.heightGradient(material)));
      answer.pressing_N = contact_N_per_m_ * std::max(0.0, contact_m + answer.height_m);
    }
    shift_ = answer.point.place - n * yielded_m - answer.point.material;
    return answer;
  }

  void stroke(PairResult& result) {
    DeformedShape shape = shape_;
    const ServoObject first = freshObject();
    Bench bench({first}, frame_, guest_, skin_, effects());
    if (has(Feature::kPlastic) && !isPressed()) pressDent(bench, first, shape, result);
    Comparison comparison;
    SliderReference body(slider_);
    Vec3 material = start_;
    double deepestYield_m = 0;
    const int before = has(Feature::kMotion) && has(Feature::kEffects) ? kLetIn : 0;
    for (int i = -before; i < strokeTicks(); ++i) {
      const Way way = wayAt(i);
      const auto at = shape.at(shape.walked(start_, along_ * way.along_m));
      const Vec3 hip = at.place - at.normal * way.depth_m;
      TelemetrySample felt = bench.tick(hip);
      const Pose pose = bench.poseOf(0);
      const Answer right = answer(shape, toLocal(pose, hip), material, deepestYield_m);
      if (guest_ != nullptr && has(Feature::kFriction)) tellFrictionApart(felt, right.normal_N);
      material = right.point.material;
      Comparison::Right expected{.normal_N = right.normal_N,
                                 .height_m = right.height_m,
                                 .highest_m = 2 * skin_.textureHeight_m,
                                 .slides = has(Feature::kFriction),
                                 .judged = way.judged};
      if (has(Feature::kEffects)) expected.normal_N += pose.rotation * pulls_.force_N(toLocal(pose, hip));
      if (has(Feature::kFriction)) {
        constexpr double kAhead_m = 1e-4;
        const Vec3 ahead = shape.now(shape.walked(start_, along_ * (way.along_m + kAhead_m))) - at.place;
        const Vec3 n = right.point.normal;
        const Vec3 heading = glm::normalize(ahead - glm::dot(ahead, n) * n);
        expected.friction_N = -heading * (skin_.muDynamic * skin_.factor(material) * right.pressing_N);
      }
      comparison.add(felt, expected);
      if (has(Feature::kMotion)) body.follow(pose, felt.force.written, i >= 0);
    }
    comparison.addTo(result, has(Feature::kFriction), has(Feature::kTexture));
    if (has(Feature::kMotion)) result.worst(Measure::kTrajectory, body.deviation());
  }

  /// Twice round; the second time counts.
  void loop(PairResult& result) {
    constexpr int kRound = 400;
    const bool sticks = has(Feature::kFriction);
    const double radius_m = sticks ? 0.5e-3 : 3e-3;
    const double breathes_m = sticks ? 0 : 0.2 * depth_m_;
    const Skin kept = skin_;
    if (sticks) skin_ = roughened(skin_);
    if (guest_ != nullptr) skin_.variation = 0;
    Bench bench({freshObject()}, frame_, guest_, skin_, effects());
    const auto from = shape_.at(start_);
    std::vector<Vec3> force_N, place;
    Vec3 material = start_;
    double deepestYield_m = 0;
    const int before = static_cast<int>(kBeforeStroke_s / kTick_s);
    int bad = 0;
    StickSlip stick;
    for (int i = 0; i <= before + 2 * kRound; ++i) {
      const double phase = 2 * kPi * std::max(0, i - before) / kRound;
      const Vec3 away = radius_m * (from.tangent[0] * std::sin(phase) + from.tangent[1] * (1 - std::cos(phase)));
      const auto at = shape_.at(shape_.walked(start_, away));
      const double depth_m = approach_m(i * kTick_s, depth_m_);
      const Vec3 hip = at.place - at.normal * (depth_m + breathes_m * std::sin(phase));
      TelemetrySample felt = bench.tick(hip);
      const Answer right = answer(shape_, toLocal(bench.poseOf(0), hip), material, deepestYield_m);
      material = right.point.material;
      if (ablation_ == Ablation::kMuAtIhip) followIhip(felt, right, stick);
      if (i < before + kRound) continue;
      bad += felt.object == 0 || (sticks && felt.frictionState != FrictionState::kSticking) ? 1 : 0;
      force_N.push_back(felt.force.contact);
      place.push_back(hip);
    }
    skin_ = kept;
    result.worst(Measure::kBadTicks, bad);
    // The other way round the loop gives what this way takes, but for what the body's damper takes either way.
    const double work_J = workAlong(force_N, place);
    result.worst(Measure::kLoop_J, has(Feature::kMotion) ? std::max(0.0, work_J) : std::abs(work_J));
  }
  /// Friction as StickSlip has it when its coefficients are edited in each tick to those at the IHIP.
  void followIhip(TelemetrySample& felt, const Answer& right, StickSlip& stick) const {
    if (!(right.pressing_N > 0)) return;
    const double factor = skin_.factor(right.point.material);
    const FrictionCoefficients mu{skin_.muStatic * factor, skin_.muDynamic * factor};
    const double most = skin_.muStatic * (1 + skin_.variation);
    stick.edit(mu);
    const PressedPoint at{right.point.material + shift_, right.point.normal, right.pressing_N};
    const Vec3 friction = stick.follow(at, mu, {contact_N_per_m_ / most, 0}, kTick_s);
    felt.force.contact += friction - felt.force.friction;
    felt.force.friction = friction;
  }
  /// So rough that the loop sticks, and of a map that changes within it.
  [[nodiscard]] static Skin roughened(Skin skin) {
    skin.muStatic = 3;
    skin.muDynamic = 2.5;
    skin.variation = 0.9;
    for (FourierTerm& term : skin.map.terms) term.wavelength_m /= 8;
    return skin;
  }

  Feature a_, b_;
  Ablation ablation_;
  const Method* guest_;
  bool round_;
  DeformedShape shape_;  // before any dent
  Pose frame_;
  double contact_N_per_m_ = 0, tissue_N_per_m_ = 0, falloff_m_ = 0, plastic_ = 0;
  double depth_m_ = 0, wave_ = 0, wave_Hz_ = 0, speed_m_per_s_ = 0, length_m_ = 0, pressed_m_ = 0;
  Vec3 start_{0}, along_{0};
  Skin skin_;
  std::optional<Lattice> lattice_;
  Slider slider_;
  Pulls pulls_;
  mutable Vec3 shift_{0};  // of the last answer: the displaced IHIP less the material point
};

}  // namespace

PairResult runSolo(Feature a, Feature b, Ablation ablation, Random random, const Method* guest) {
  return Solo(a, b, ablation, random, guest).run();
}

}  // namespace haptics::eval
