#include "tests/eval/combinations/bench.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/maths/perception.h"
#include "haptic_server/engine/surface/surface_detail.h"
#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/spectrum.h"

namespace haptics::eval {
namespace {

Pose composed(const Pose& outer, const Pose& inner) {
  return {glm::normalize(outer.rotation * inner.rotation), toWorld(outer, inner.position)};
}

/// A field that is looked up beside where it is asked for.
class DisplacedField final : public ScalarField {
 public:
  DisplacedField(std::shared_ptr<const ScalarField> field, const Vec3* shift)
      : ScalarField(field->bounds(), field->shortestWavelength_m()), field_(std::move(field)), shift_(shift) {}
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override { return field_->at(point + *shift_); }

 private:
  std::shared_ptr<const ScalarField> field_;
  const Vec3* shift_;
};

std::shared_ptr<const ScalarField> fieldOf(const Waves& waves, const Vec3* shift) {
  if (waves.terms.empty()) return nullptr;
  if (shift == nullptr) return waves.field();
  return std::make_shared<const DisplacedField>(waves.field(), shift);
}

/// But for its texture.
SurfaceProperties propertiesOf(const Skin& skin) {
  constexpr double kCrease_rad = 1;  // a box's edges stay sharp
  SurfaceProperties properties;
  if (skin.shaded) properties.shading.emplace().crease_rad = kCrease_rad;
  if (skin.muStatic > 0) {
    properties.friction = Friction{skin.muStatic, skin.muDynamic, skin.variation, {}};
    if (skin.variation != 0) properties.friction->over = FourierFamily{skin.map.terms};
  }
  return properties;
}

double rms(std::span<const Vec3> values) {
  double squares = 0;
  for (const Vec3 v : values) squares += squaredLength(v);
  return values.empty() ? 0 : std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

std::shared_ptr<const SurfaceDetail> detailOf(const Skin& skin, const CollisionMesh& surface, const Vec3* shift,
                                              std::shared_ptr<const std::vector<Vec3f>> material) {
  SurfaceProperties properties = propertiesOf(skin);
  DetailFields fields;
  fields.material = std::move(material);
  if (skin.textureHeight_m > 0) {
    properties.texture =
        Texture{.family = FourierFamily{skin.relief.terms}, .amplitude_m = skin.textureHeight_m, .gain_K = Skin::kGain};
    fields.texture = fieldOf(skin.relief, shift);
  }
  if (skin.muStatic > 0 && skin.variation != 0) fields.friction = fieldOf(skin.map, shift);
  return makeSurfaceDetail(surface, properties, fields);
}

Vec3 printedForce(double depth_m, Vec3 normal, double height_m, Vec3 gradient) {
  const double d = std::max(0.0, depth_m + height_m);
  const Vec3 m = normal - gradient + glm::dot(gradient, normal) * normal;
  const double raised = Skin::kGain * height_m;
  return d >= raised ? (d - raised) * normal + raised * m : d * m;
}

Bench::Bench(std::vector<ServoObject> objects, const Pose& frame, const std::vector<Effect>& effects)
    : frame_(frame),
      config_{.period_s = kTick_s, .maxForce_N = 1e9},
      state_(std::make_unique<HapticState>(config_)),
      scene_(std::make_unique<ServoScene>()) {
  for (const Effect& effect : effects)
    effects_.push_back({0, effects_.size(), std::make_shared<const EffectField>(effect)});
  adopt(std::move(objects));
}

Bench::Bench(std::vector<ServoObject> objects, const Pose& frame, const Method* guest, const Skin& skin,
             const std::vector<Effect>& effects)
    : Bench(guest == nullptr ? objects : std::vector<ServoObject>{}, frame, effects) {
  if (guest == nullptr) return;
  if ((skin.shaded || skin.muStatic > 0) && !guest->surfaces)
    throw NotApplicable("a surface is shaded or has friction");
  guest_ = guest->make();
  for (const ServoObject& object : objects) {
    surfaces_.push_back(object.surface);
    poses_.push_back(composed(frame_, object.pose));
  }
  FeltSurface surface;
  surface.properties = propertiesOf(skin);
  surface.spring_N_per_m = objects.front().stiffness_N_per_m;
  surface.device = orThrow(findDevicePreset(kDefaultDevicePreset));
  guest_->setSurfaceProperties(surface);
}

void Bench::adopt(std::vector<ServoObject> objects) {
  auto next = std::make_unique<ServoScene>();
  next->number = next->revision = scene_->revision + 1;
  for (ServoObject& object : objects) object.pose = composed(frame_, object.pose);
  next->objects = std::move(objects);
  next->effects = effects_;
  if (!adoptScene(*next, *state_, ticks_)) throw std::logic_error("a scene is adopted while its objects are touched");
  scene_ = std::move(next);
}

TelemetrySample Bench::tickOfGuest(Vec3 hip) {
  const Vec3 place = toWorld(frame_, hip);
  if (!std::exchange(begun_, true)) guest_->begin(surfaces_, poses_, place);
  const Felt felt = guest_->tick(poses_, place);
  TelemetrySample sample;
  sample.hip = hip;
  sample.ihip = toLocal(frame_, felt.ihip);
  sample.object = felt.touching ? 1 : 0;
  sample.force.contact = glm::conjugate(frame_.rotation) * felt.force_N;
  sample.frictionState = felt.sliding ? FrictionState::kSliding : FrictionState::kSticking;
  return sample;
}

void tellFrictionApart(TelemetrySample& felt, Vec3 normal) {
  const double squared = squaredLength(normal);
  if (squared == 0) return;
  felt.force.friction = felt.force.contact - normal * (glm::dot(felt.force.contact, normal) / squared);
}

TelemetrySample Bench::tick(Vec3 hip) {
  if (guest_) return tickOfGuest(hip);
  const StepInput input{ticks_++, 0, {toWorld(frame_, hip), DeviceState::kReady, {}}};
  TelemetrySample sample = hapticStep(*scene_, *state_, config_, input);
  const auto turn = [this](Vec3& v) { v = glm::conjugate(frame_.rotation) * v; };
  for (Vec3* v : {&sample.force.spring, &sample.force.damping, &sample.force.friction, &sample.force.texture,
                  &sample.force.contact, &sample.force.written, &sample.surfaceNormal})
    turn(*v);
  sample.hip = hip;
  sample.ihip = toLocal(frame_, sample.ihip);
  return sample;
}

Pose Bench::poseOf(std::size_t body) const {
  const Pose& world = guest_ ? poses_[body] : state_->bodies[body].current;
  return {glm::conjugate(frame_.rotation) * world.rotation, toLocal(frame_, world.position)};
}

void Comparison::add(const TelemetrySample& felt, const Right& right) {
  if (!isFinite(felt.force.contact) || (right.normal_N != Vec3(0) && right.judged && felt.object == 0)) ++bad_;
  const Vec3 withoutFriction = felt.force.contact - felt.force.friction;
  const bool judgesFriction = right.judged && right.slides;
  const Vec3 deviation = (judgesFriction ? felt.force.contact - right.friction_N : withoutFriction) - right.normal_N;
  if (!first_ && lastJudged_ == judgesFriction) step_N_ = std::max(step_N_, glm::distance(deviation, last_N_));
  first_ = false;
  last_N_ = deviation;
  lastJudged_ = judgesFriction;
  if (!right.judged) return;
  felt_N_.push_back(withoutFriction);
  right_N_.push_back(right.normal_N);
  deviation_N_.push_back(deviation);
  angle2_ += std::pow(angle_deg(withoutFriction, right.normal_N), 2);
  highest_m_ = std::max(highest_m_, right.highest_m);
  feltHeight_m_.push_back(felt.height_m);
  rightHeight_m_.push_back(right.height_m);
  worstHeight_ = std::max(worstHeight_, std::abs(felt.height_m - right.height_m));
  feltFriction_N_.push_back(glm::length(felt.force.friction));
  rightFriction_N_.push_back(glm::length(right.friction_N));
  if (right.slides) {
    worstFriction_ = std::max(worstFriction_, std::abs(feltFriction_N_.back() / rightFriction_N_.back() - 1));
  }
}

void Comparison::addTo(PairResult& result, bool friction, bool texture) const {
  result.worst(Measure::kBadTicks, bad_);
  if (felt_N_.empty()) return;
  const auto count = static_cast<double>(felt_N_.size());
  result.worst(Measure::kStep_N, step_N_);
  result.worst(Measure::kFalseForce_N, rmsAbove(kFeltArtefactsFrom_Hz, deviation_N_, kTick_s));
  std::vector<Vec3> apart;
  for (std::size_t i = 0; i < felt_N_.size(); ++i) apart.push_back(felt_N_[i] - right_N_[i]);
  result.worst(Measure::kForce, rms(apart) / rms(right_N_));
  result.worst(Measure::kDirection_deg, std::sqrt(angle2_ / count));
  if (texture) result.worst(Measure::kHeight, worstHeight_ / highest_m_);
  if (friction) result.worst(Measure::kFriction, worstFriction_);

  result.felt.clear();
  result.right.clear();
  result.plotted = texture ? "height, mm" : friction ? "friction, N" : "force, N";
  for (std::size_t i = 0; i < felt_N_.size(); ++i) {
    const double t_s = kTick_s * static_cast<double>(i);
    const double felt = texture ? 1e3 * feltHeight_m_[i] : friction ? feltFriction_N_[i] : glm::length(felt_N_[i]);
    const double right = texture ? 1e3 * rightHeight_m_[i] : friction ? rightFriction_N_[i] : glm::length(right_N_[i]);
    result.felt.emplace_back(t_s, felt);
    result.right.emplace_back(t_s, right);
  }
}

double workAlong(std::span<const Vec3> force_N, std::span<const Vec3> place_m) {
  double work_J = 0;
  for (std::size_t i = 1; i < force_N.size(); ++i)
    work_J += glm::dot((force_N[i] + force_N[i - 1]) * 0.5, place_m[i] - place_m[i - 1]);
  return work_J;
}

}  // namespace haptics::eval
