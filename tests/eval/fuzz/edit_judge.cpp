#include "tests/eval/fuzz/edit_judge.h"

#include <algorithm>
#include <utility>

#include "haptic_server/engine/step/held_springs.h"

namespace haptics::eval {
namespace {

/// Of the force in the end: what a hand does not notice.
constexpr double kSame_N = 0.03;
constexpr double kSamePart = 0.01;

bool isSoft(const EditRun& run) {
  return std::ranges::any_of(run.scenes, [](const FuzzScene& scene) {
    return std::ranges::any_of(scene.objects, [](const FuzzObject& o) { return o.tissue || o.mass_kg > 0; });
  });
}

/// A body that the dynamics move faster pushes, slips off and strikes; one that moves less is at rest.
constexpr double kMoved_m_per_s = 1e-5;
/// In which a jump of the contact force counts for 1/e of itself.
constexpr double kFlutter_s = 0.02;

/// How far (m) the dynamics, and not an edit, moved a body at the HIP in the last tick. `touched` and `before` are ids, 0
/// for none.
double movedAt_m(const HapticState& state, Vec3 hip, std::uint64_t touched, std::uint64_t before) {
  constexpr double kBeside_m = 0.01;
  double farthest_m = 0;
  for (std::size_t i = 0; i < state.moving.count; ++i) {
    const std::size_t b = state.moving[i].body;
    const Body& body = state.bodies[b];
    const std::uint64_t id = state.objects[b].id;
    if (state.objects[b].beingMoved) continue;
    const bool isTouched = touched == id || before == id;
    if (!isTouched && glm::distance(body.centre, hip) > body.surface->radius_m() + kBeside_m) continue;
    farthest_m = std::max(farthest_m, glm::distance(toWorld(body.current, toLocal(body.previous, hip)), hip));
  }
  return farthest_m;
}

}  // namespace

std::string_view nameOf(EditFailure failure) {
  switch (failure) {
    case EditFailure::kStep:
      return "step";
    case EditFailure::kInside:
      return "edited-inside";
    case EditFailure::kUnfelt:
      return "unfelt";
    case EditFailure::kNotFinite:
      return "not-finite";
  }
  return "";
}

std::optional<EditFailure> EditVerdict::failure() const {
  if (!finite) return EditFailure::kNotFinite;
  if (excess_N > 0) return EditFailure::kStep;
  if (inside_m > 0) return EditFailure::kInside;
  if (!adopted || missing_N > 0) return EditFailure::kUnfelt;
  return std::nullopt;
}

void EditJudge::begin(EditDrive& drive) {
  const TelemetrySample& sample = drive.sample();
  verdict_ = {};
  worst_ = worstAdoption_ = {drive.tick(), 0};
  insideBefore_ = depth_m(drive) > 0;
  flutter_N_ = 0;
  most_N_ = glm::length(sample.force.written);
  lastContact_N_ = limitMagnitude(sample.force.contact, drive.config().maxForce_N);
  last_N_ = twinLast_N_ = sample.force.written;
  lastObject_ = twinLastObject_ = sample.object;
  lastMoved_m_ = movedAt_m(drive.state(), sample.hip, sample.object, sample.object);
  lastStep_N_ = twinStep_N_ = twinAnyStep_N_ = 0;
  twin_ = run_.stabiliser || isSoft(run_);  // else nothing changes without an edit
  if (twin_) drive.split();
}

void EditJudge::observe(EditDrive& drive, Vec3 hip) {
  constexpr double kGoesOn = 1.25;  // a step that the dynamics make is followed by one as large
  const TelemetrySample& sample = drive.sample();
  const double step_N = glm::distance(sample.force.written, last_N_);
  verdict_.finite = verdict_.finite && isFinite(sample.force.written);
  const Vec3 contact_N = limitMagnitude(sample.force.contact, drive.config().maxForce_N);
  most_N_ = std::max(most_N_, glm::length(contact_N));
  flutter_N_ *= 1 - run_.period_s() / kFlutter_s;
  flutter_N_ = std::max(flutter_N_, glm::distance(contact_N, std::exchange(lastContact_N_, contact_N)));
  if (twin_) observeTwin(drive, hip);
  // An adoption may set bodies somewhere else: by the dynamics they would have gone on as before.
  const bool adopted = drive.adoptedNow();
  const double moved_m = adopted ? lastMoved_m_ : movedAt_m(drive.state(), hip, sample.object, lastObject_);
  const bool moved = moved_m > kMoved_m_per_s * run_.period_s();
  last_N_ = sample.force.written;
  lastObject_ = sample.object;
  lastMoved_m_ = moved_m;
  const double before_N = std::exchange(lastStep_N_, step_N);
  if (moved && !adopted) return;
  verdict_.step_N = std::max(verdict_.step_N, step_N);
  const double own_N = moved ? std::max(motion_N(drive, moved_m), kGoesOn * before_N) : motion_N(drive, moved_m);
  const double above_N = step_N - relaxation_N(drive) - own_N;
  Step& worst = moved ? worstAdoption_ : worst_;
  if (above_N > worst.above_N) worst = {drive.tick() - 1, above_N};
}

void EditJudge::observeTwin(EditDrive& drive, Vec3 hip) {
  const TelemetrySample& sample = drive.stepTwin(hip);
  const double step_N = glm::distance(sample.force.written, twinLast_N_);
  twinAnyStep_N_ = std::max(twinAnyStep_N_, step_N);
  if (movedAt_m(drive.twinState(), hip, sample.object, twinLastObject_) <= kMoved_m_per_s * run_.period_s()) {
    twinStep_N_ = std::max(twinStep_N_, step_N);
  }
  twinLast_N_ = sample.force.written;
  twinLastObject_ = sample.object;
}

void EditJudge::settle(const EditDrive& drive) {
  verdict_.adopted = !drive.waiting();
  if (!isFinite(drive.sample().force.written)) return;
  verdict_.inside_m = insideBefore_ ? 0 : depth_m(drive);
  verdict_.missing_N = missing_N(drive);
}

EditVerdict EditJudge::end() {
  constexpr double kRounding_N = 1e-6;
  const double limit_N = kMaxStep_N_per_s * run_.period_s() + kRounding_N;
  const double excess_N = worst_.above_N - limit_N - twinStep_N_;
  const double adoptionExcess_N = worstAdoption_.above_N - limit_N - twinAnyStep_N_;
  verdict_.excess_N = std::max({0.0, excess_N, adoptionExcess_N});
  verdict_.tick = adoptionExcess_N > std::max(0.0, excess_N) ? worstAdoption_.tick : worst_.tick;
  return verdict_;
}

/// Of the spring, for a body that the dynamics move so far; half as much again for its damper and lever.
double EditJudge::motion_N(const EditDrive& drive, double moved_m) const {
  constexpr double kPart = 1.5;
  const FuzzObject* touched = drive.object(drive.sample().object);
  return touched == nullptr ? 0 : kPart * touched->stiffness_N_per_m * moved_m;
}

/// In a tick, at most.
double EditJudge::relaxation_N(const EditDrive& drive) const {
  const FuzzObject* touched = drive.object(drive.sample().object);
  if (touched == nullptr || !touched->tissue) return 0;
  const SoftTissue& tissue = *touched->tissue;
  if (!(tissue.returnTime_s > 0)) return 0;
  const double share = touched->stiffness_N_per_m / (touched->stiffness_N_per_m + tissue.stiffness_N_per_m);
  const Vec3 penetration_m = drive.state().contact.ihip - drive.state().contact.hip;
  return touched->stiffness_N_per_m * glm::length(penetration_m) * run_.period_s() /
         (tissue.returnTime_s * (1 - share));
}

const SolidOracle& EditJudge::oracle(std::size_t mesh) {
  if (oracles_.size() <= mesh) oracles_.resize(mesh + 1);
  if (!oracles_[mesh]) oracles_[mesh].emplace(run_.meshes[mesh].mesh.vertices, run_.meshes[mesh].mesh.triangles);
  return *oracles_[mesh];
}

/// The contact's IHIP in the shapes at rest, which it is found with; and where a soft object is touched, the felt one in
/// that as it is dented. Shading and textures of what holds the IHIP tell another one than the contact has.
double EditJudge::depth_m(const EditDrive& drive) {
  constexpr double kOnDented_m = 1e-6;  // as S16 and S17 have it
  const HapticState& state = drive.state();
  const TelemetrySample& sample = drive.sample();
  const Vec3 ihip = sample.object == 0 ? state.contact.hip : state.contact.ihip;
  const auto hasDetail = [&](const ContactSurface& held) {
    const FuzzObject* object = drive.object(state.objects[static_cast<std::size_t>(held.body)].id);
    return object != nullptr && object->hasDetail();
  };
  const bool showsDetail = sample.object != 0 && std::ranges::any_of(state.contact.surfaces(), hasDetail);
  double deepest_m = 0;
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    const FuzzObject* object = drive.object(state.objects[i].id);
    if (object == nullptr || object->pendingRemoval || !run_.meshes[object->mesh].mesh.closed()) continue;
    const Pose& pose = state.bodies[i].current;
    const bool touched = sample.object == object->id || sample.object == 0;
    const bool dented = touched && object->tissue && !showsDetail;
    const double depth = dented ? dentedOracle(state, i, *object).depth_m(toLocal(pose, sample.ihip))
                                : oracle(object->mesh).depth_m(toLocal(pose, ihip));
    if (!dented || depth > kOnDented_m) deepest_m = std::max(deepest_m, depth);
  }
  return deepest_m;
}

SolidOracle EditJudge::dentedOracle(const HapticState& state, std::size_t body, const FuzzObject& object) const {
  std::vector<Dent> dents;
  for (const BodyDent& dent : state.allDents()) {
    if (dent.body == body) dents.push_back(dent.dent);
  }
  const FuzzMesh& mesh = run_.meshes[object.mesh].mesh;
  std::vector<Vec3f> vertices = mesh.vertices;
  for (Vec3f& v : vertices) v = dented(v, dents, object.tissue->falloff);
  return {vertices, mesh.triangles};
}

/// By how much the written force is not that of the scene's parameters: nothing is left of a blend, and the spring is as
/// stiff as the object that is touched, or as all that hold the IHIP. Where shading or a texture of any object may reach the HIP, or a body moves, only the
/// first is known. While two surfaces hold the IHIP about evenly, an observer's HIP may go to and fro between them at rest:
/// the contact force then has two values, with the edit or without.
double EditJudge::missing_N(const EditDrive& drive) const {
  constexpr double kSlowest_N_per_s = 30;
  constexpr double kLongest_s = 0.75;  // of the second: a force that turns goes a longer way than the two together
  const TelemetrySample& sample = drive.sample();
  if (movedAt_m(drive.state(), sample.hip, sample.object, sample.object) > kMoved_m_per_s * run_.period_s()) return 0;
  Vec3 expected_N = sample.force.contact;
  const FuzzObject* touched = drive.object(sample.object);
  if (severalBodiesHold(drive.state())) {
    for (const ContactSurface& held : drive.state().contact.surfaces()) {
      const auto& known = drive.state().objects[static_cast<std::size_t>(held.body)];
      const FuzzObject* object = drive.object(known.id);
      if (object == nullptr || object->pendingRemoval) continue;
      const double missing_N_per_m = std::abs(object->stiffness_N_per_m - known.stiffness.mean().spring_N_per_m);
      const double farthest_N = most_N_ + object->stiffness_N_per_m * sample.penetration_m;
      if (farthest_N > kSlowest_N_per_s * kLongest_s) return 0;
      if (missing_N_per_m > kSamePart * object->stiffness_N_per_m) return missing_N_per_m * sample.penetration_m;
    }
  } else if (touched != nullptr && touched->mass_kg == 0 && !drive.state().features.bumps) {
    const double stiffness_N_per_m = touched->pendingRemoval ? 0 : touched->stiffness_N_per_m;
    expected_N += stiffness_N_per_m * (sample.ihip - sample.predictedHip) - sample.force.spring;
  }
  if (most_N_ + glm::length(expected_N) > kSlowest_N_per_s * kLongest_s) return 0;
  const Vec3 limited_N = limitMagnitude(expected_N, drive.config().maxForce_N);
  const double difference_N = glm::distance(sample.force.written, limited_N);
  const double same_N = kSame_N + kSamePart * glm::length(limited_N) + 2 * flutter_N_;
  return difference_N > same_N ? difference_N : 0;
}

std::optional<EditFinding> findFailure(const EditRun& run, std::optional<EditFailure> kind) {
  EditDrive drive(run);
  EditJudge judge(run);
  std::size_t window = 0;
  for (std::uint64_t tick = 0; tick < run.hips.size() && window < run.windows.size(); ++tick) {
    const EditWindow& w = run.windows[window];
    if (tick == w.begin) judge.begin(drive);
    drive.step(run.hips[tick]);
    if (tick < w.begin) continue;
    judge.observe(drive, run.hips[tick]);
    if (tick + 1 == w.settled) judge.settle(drive);
    if (tick + 1 < w.end) continue;
    const EditVerdict verdict = judge.end();
    const auto failure = verdict.failure();
    if (failure && (!kind || failure == kind)) return EditFinding{*failure, window, verdict};
    ++window;
  }
  return std::nullopt;
}

}  // namespace haptics::eval
