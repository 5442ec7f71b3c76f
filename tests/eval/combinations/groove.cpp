#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "tests/eval/combinations/bench.h"
#include "tests/eval/combinations/bodies.h"
#include "tests/eval/combinations/groove_reference.h"
#include "tests/eval/combinations/solo.h"

namespace haptics::eval {
namespace {

constexpr double kPi = std::numbers::pi;

/// How much of the force each of two surfaces has, and along what.
struct Parts {
  std::array<Vec3, 2> normal{Vec3(0), Vec3(0)};
  std::array<double, 2> depth_m{0, 0};  ///< The way from the HIP to the IHIP is the normals' sum, times these.
  Vec3 ihip{0};
};

/// Two bodies that hold the IHIP between them. Scene frame.
class Groove {
 public:
  Groove(Feature feature, Ablation ablation, Random& random, const Method* guest)
      : feature_(feature), ablation_(ablation), guest_(guest) {
    frame_ = {random.rotation(), random.direction() * random.between(0, 0.2)};
    for (Side& side : sides_) {
      side.contact_N_per_m = random.between(500, 1000);
      side.tissue_N_per_m = random.between(300, 600);
      side.depth_m = random.between(0.001, 0.0025);
      side.wave_Hz = random.between(1, 3);
      side.skin = randomSkin(feature, feature, random);
    }
    falloff_m_ = random.between(0.018, 0.022);
    plastic_ = random.between(0.4, 0.9);
    speed_m_per_s_ = random.between(0.03, 0.1) * random.sign();
    length_m_ = random.between(0.02, 0.03);
    slider_ = randomSlider(random);
    if (has(Feature::kEffects)) pulls_ = randomPulls(random);
    if (guest_ != nullptr) {
      sides_[0].skin.variation = 0;
      sides_[1].skin = sides_[0].skin;
      sides_[1].contact_N_per_m = sides_[0].contact_N_per_m;
    }
    if (feature == Feature::kShading) {
      placeBall(random);
    } else {
      placePads(random);
    }
  }

  [[nodiscard]] PairResult run() {
    PairResult result;
    stroke(result);
    if (has(Feature::kSoftness) || has(Feature::kLattice) || has(Feature::kShading) || has(Feature::kEffects))
      loop(result);
    return result;
  }

 private:
  struct Side {
    double contact_N_per_m = 0, tissue_N_per_m = 0, depth_m = 0, wave_Hz = 0;
    Skin skin;
    Pose pose;
    Vec3 normal{0, 0, 1};           // of the side that is touched, body frame
    Vec3 on{0, 0, kPadSide_m / 2};  // a point of it
    std::optional<Lattice> lattice;
  };

  [[nodiscard]] bool has(Feature feature) const { return feature_ == feature; }
  [[nodiscard]] bool yields() const { return has(Feature::kSoftness) || has(Feature::kPlastic); }
  [[nodiscard]] bool isRound() const { return has(Feature::kShading); }

  /// What each side presses with, N.
  [[nodiscard]] std::array<double, 2> pressing_N(const Parts& parts) const {
    const auto side = [&](std::size_t i) {
      return GrooveReference::Side{parts.normal[i], sides_[i].contact_N_per_m, yields() ? sides_[i].tissue_N_per_m : 0};
    };
    const double cosine = glm::dot(parts.normal[0], parts.normal[1]);
    return GrooveReference(side(0), side(1))
        .pressing_N({parts.depth_m[0] + cosine * parts.depth_m[1], parts.depth_m[1] + cosine * parts.depth_m[0]});
  }

  void placePads(Random& random) {
    const double half = random.between(25, 60) * kPi / 180;
    for (std::size_t i = 0; i < 2; ++i) {
      Side& side = sides_[i];
      const Quat turn = glm::angleAxis(i == 0 ? half : -half, Vec3(0, 1, 0));
      side.pose = {turn, turn * Vec3(0, 0, -kPadSide_m / 2)};
      if (has(Feature::kLattice)) shear(side, random);
    }
  }

  /// An affine lattice: the pads stay planes. Of two points along each axis, which are all corners.
  static void shear(Side& side, Random& random) {
    constexpr double kHalf_m = 0.055;
    glm::dmat3 matrix(1);
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) matrix[column][row] += random.between(-0.08, 0.08);
    }
    Lattice lattice{.low_m = Vec3(-kHalf_m), .size_m = Vec3(2 * kHalf_m), .points = {2, 2, 2}, .control_m = {}};
    for (int i = 0; i < 8; ++i) {
      lattice.control_m.emplace_back(matrix * (kHalf_m * Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
    }
    side.lattice = lattice;
    side.normal = glm::normalize(glm::transpose(glm::inverse(matrix)) * side.normal);
    side.on = matrix * side.on;
  }

  /// A ball that stands out of a pad: their groove is a circle.
  void placeBall(Random& random) {
    level_m_ = random.between(-0.015, 0.015);
    circle_m_ = std::sqrt(kBallRadius_m * kBallRadius_m - level_m_ * level_m_);
    sides_[1].pose.position = Vec3(circle_m_, 0, level_m_ - kPadSide_m / 2);
    sides_[1].depth_m += sides_[0].depth_m;  // that the pad pushes whatever way the ball does
  }

  [[nodiscard]] ServoObject object(std::size_t i) const {
    const Side& side = sides_[i];
    const TriMesh& mesh = isRound() && i == 0 ? ball() : yields() ? finePad() : coarsePad();
    ServoObject object{
        .id = i + 1, .surface = atRest(mesh), .pose = side.pose, .stiffness_N_per_m = side.contact_N_per_m};
    if (side.lattice) object.surface = refitCollisionMesh(*object.surface, shapedBy(*side.lattice, mesh.vertices));
    Skin skin = side.skin;
    skin.shaded = skin.shaded || yields();
    object.detail = detailOf(skin, *object.surface, nullptr, nullptr);
    if (yields()) {
      object.tissue = std::make_shared<const SoftTissue>(
          SoftTissue{Falloff(falloff_m_, 2), side.tissue_N_per_m, 0, has(Feature::kPlastic) ? plastic_ : 0});
      object.baked.shape = 1;
    }
    if (has(Feature::kMotion) && i == 0) object.motion = slider_.body(mesh);
    return object;
  }
  [[nodiscard]] Bench makeBench() const {
    return Bench({object(0), object(1)}, frame_, guest_, sides_[0].skin,
                 has(Feature::kEffects) ? pulls_.effects() : std::vector<Effect>{});
  }

  /// Of two planes, or of ball and pad.
  [[nodiscard]] Parts partsOf(const std::array<Pose, 2>& poses, Vec3 h) const {
    Parts parts;
    if (isRound()) {
      const double radius_m = std::hypot(h.x, h.y);
      const Vec3 out(h.x / radius_m, h.y / radius_m, 0);
      const double aside_m = circle_m_ - radius_m, below_m = level_m_ - h.z;
      parts.normal = {(out * circle_m_ + Vec3(0, 0, level_m_)) / kBallRadius_m, Vec3(0, 0, 1)};
      parts.depth_m[0] = aside_m * kBallRadius_m / circle_m_;
      parts.depth_m[1] = below_m - aside_m * level_m_ / circle_m_;
    } else {
      std::array<double, 2> below_m{};
      for (std::size_t i = 0; i < 2; ++i) {
        parts.normal[i] = poses[i].rotation * sides_[i].normal;
        below_m[i] = glm::dot(parts.normal[i], toWorld(poses[i], sides_[i].on) - h);
      }
      const double cosine = glm::dot(parts.normal[0], parts.normal[1]);
      for (std::size_t i = 0; i < 2; ++i)
        parts.depth_m[i] = (below_m[i] - cosine * below_m[1 - i]) / (1 - cosine * cosine);
    }
    parts.ihip = h + parts.depth_m[0] * parts.normal[0] + parts.depth_m[1] * parts.normal[1];
    return parts;
  }

  /// A place along the groove, so deep below both sides.
  [[nodiscard]] Vec3 place(double along_m, double first_m, double second_m) const {
    if (isRound()) {
      const double angle = along_m / circle_m_;
      const Vec3 out(std::cos(angle), std::sin(angle), 0);
      const double aside_m = first_m * circle_m_ / kBallRadius_m;
      return out * (circle_m_ - aside_m) + Vec3(0, 0, level_m_ - second_m - aside_m * level_m_ / circle_m_);
    }
    const std::array<Pose, 2> poses{sides_[0].pose, sides_[1].pose};
    const Parts atOrigin = partsOf(poses, Vec3(0));
    const Vec3 axis = glm::normalize(glm::cross(atOrigin.normal[0], atOrigin.normal[1]));
    return atOrigin.ihip + axis * along_m - first_m * atOrigin.normal[0] - second_m * atOrigin.normal[1];
  }

  struct Answer {
    Vec3 normal_N{0};
    double friction_N = 0;  ///< mu_1 N_1 + mu_2 N_2.
    std::array<double, 2> mu{0, 0};
  };
  [[nodiscard]] Answer answer(const std::array<Pose, 2>& poses, const Parts& parts) const {
    Answer answer;
    const std::array<double, 2> pressing_N = this->pressing_N(parts);
    for (std::size_t i = 0; i < 2; ++i) {
      const Side& side = sides_[i];
      const double k = side.contact_N_per_m;
      const Vec3 n = parts.normal[i];
      const Vec3 material = toLocal(poses[i], parts.ihip);
      Vec3 force_N = pressing_N[i] * n;
      if (side.skin.textureHeight_m > 0) {
        const double height_m = side.skin.height_m(material);
        const Vec3 gradient = poses[i].rotation * side.skin.heightGradient(material);
        force_N += k * (printedForce(parts.depth_m[i], n, height_m, gradient) - parts.depth_m[i] * n);
      }
      answer.mu[i] = side.skin.muDynamic * side.skin.factor(material);
      answer.friction_N += answer.mu[i] * std::max(0.0, pressing_N[i]);
      answer.normal_N += force_N;
    }
    return answer;
  }

  void stroke(PairResult& result) {
    Bench bench = makeBench();
    Comparison comparison;
    SliderReference slider(slider_);
    const bool rubs = has(Feature::kFriction);
    const int ticks = static_cast<int>((kBeforeStroke_s + length_m_ / std::abs(speed_m_per_s_)) / kTick_s);
    const double from_m = -length_m_ / 2 * (speed_m_per_s_ > 0 ? 1 : -1);
    for (int i = 0; i < ticks; ++i) {
      const double t = i * kTick_s;
      const double stroke_s = std::max(0.0, t - kBeforeStroke_s);
      std::array<double, 2> depth_m{};
      for (std::size_t k = 0; k < 2; ++k) {
        const double wave = has(Feature::kPlastic) ? 0 : 0.1 * std::sin(2 * kPi * sides_[k].wave_Hz * stroke_s);
        depth_m[k] = approach_m(t, sides_[k].depth_m) + wave * sides_[k].depth_m;
      }
      const double along_m = from_m + speed_m_per_s_ * stroke_s;
      const Vec3 hip = place(along_m, depth_m[0], depth_m[1]);
      TelemetrySample felt = bench.tick(hip);
      const std::array<Pose, 2> poses{bench.poseOf(0), bench.poseOf(1)};
      const Parts parts = partsOf(poses, hip);
      const Answer right = answer(poses, parts);
      if (ablation_ == Ablation::kFirstNormal) applyFirstNormal(felt, right);
      const double rubbed_m = std::abs(along_m - from_m);
      Comparison::Right expected{.normal_N = right.normal_N, .slides = rubs, .judged = rubbed_m > (rubs ? 8e-3 : 1e-3)};
      if (has(Feature::kEffects)) expected.normal_N += poses[0].rotation * pulls_.force_N(toLocal(poses[0], hip));
      const bool isFlat = !isRound() && !has(Feature::kTexture);  // the reference knows one side alone
      if (!isFlat && !expected.judged && std::min(parts.depth_m[0], parts.depth_m[1]) <= 0)
        expected.normal_N = felt.force.contact - felt.force.friction;
      const Vec3 heading =
          glm::normalize(place(along_m + 1e-4, depth_m[0], depth_m[1]) - hip) * (speed_m_per_s_ > 0 ? 1.0 : -1.0);
      expected.friction_N = -heading * right.friction_N;
      if (guest_ != nullptr && rubs) felt.force.friction = heading * glm::dot(felt.force.contact, heading);
      comparison.add(felt, expected);
      if (has(Feature::kMotion)) slider.follow(poses[0], partAlong(parts, felt.force.contact, 0) * parts.normal[0]);
    }
    comparison.addTo(result, rubs, false);
    if (has(Feature::kMotion)) result.worst(Measure::kTrajectory, slider.deviation());
  }

  /// The formula before friction was summed over the surfaces, of what telemetry tells: the first body's coefficient
  /// times the whole force.
  static void applyFirstNormal(TelemetrySample& felt, const Answer& right) {
    if (felt.object == 0 || felt.force.friction == Vec3(0)) return;
    const Vec3 pressing_N = felt.force.contact - felt.force.friction;
    const double old_N = right.mu[felt.object - 1] * glm::length(pressing_N);
    const Vec3 old = glm::normalize(felt.force.friction) * old_N;
    felt.force.contact += old - felt.force.friction;
    felt.force.friction = old;
  }

  /// Of a force along the two normals, what the side i has.
  [[nodiscard]] static double partAlong(const Parts& parts, Vec3 force_N, std::size_t i) {
    const double cosine = glm::dot(parts.normal[0], parts.normal[1]);
    const double own = glm::dot(force_N, parts.normal[i]), other = glm::dot(force_N, parts.normal[1 - i]);
    return (own - cosine * other) / (1 - cosine * cosine);
  }

  /// Along the groove and back while the depths go round.
  void loop(PairResult& result) {
    constexpr int kRound = 400;
    Bench bench = makeBench();
    std::vector<Vec3> force_N, places;
    const int before = static_cast<int>(kBeforeStroke_s / kTick_s);
    int bad = 0;
    for (int i = 0; i <= before + 2 * kRound; ++i) {
      const double phase = 2 * kPi * std::max(0, i - before) / kRound;
      const auto depth = [&](std::size_t k, double wave) {
        return approach_m(i * kTick_s, sides_[k].depth_m) + 0.2 * sides_[k].depth_m * wave;
      };
      const Vec3 hip = place(3e-3 * std::sin(phase), depth(0, std::sin(phase)), depth(1, 1 - std::cos(phase)));
      const TelemetrySample felt = bench.tick(hip);
      if (i < before + kRound) continue;
      bad += felt.object == 0 ? 1 : 0;
      force_N.push_back(felt.force.contact);
      places.push_back(hip);
    }
    result.worst(Measure::kBadTicks, bad);
    // The other way round the loop gives what this way takes.
    result.worst(Measure::kLoop_J, std::abs(workAlong(force_N, places)));
  }

  Feature feature_;
  Ablation ablation_;
  const Method* guest_;
  Pose frame_;
  std::array<Side, 2> sides_;
  double falloff_m_ = 0, plastic_ = 0, speed_m_per_s_ = 0, length_m_ = 0;
  double level_m_ = 0, circle_m_ = 0;  // of ball and pad
  Slider slider_;
  Pulls pulls_;
};

}  // namespace

PairResult runGroove(Feature feature, Ablation ablation, Random random, const Method* guest) {
  return Groove(feature, ablation, random, guest).run();
}

}  // namespace haptics::eval
