#include "graphics_client/mirror/playback.h"

#include <algorithm>

#include "common/mesh/triangle_distance.h"

namespace haptics {
namespace {

/// Longest path of a plastic dent between two samples, as a share of its radius.
constexpr double kLongestWay = 0.2;

double time_s(const MirrorView& view, const MirrorView& since) {
  return 1e-9 * (static_cast<double>(view.sample->time_ns) - static_cast<double>(since.sample->time_ns));
}

/// What is felt goes over from one sample to the next as a whole; only where things are is between them.
TelemetrySample between(const TelemetrySample& a, const TelemetrySample& b, double s) {
  TelemetrySample sample = s < 0.5 ? a : b;
  sample.hip = glm::mix(a.hip, b.hip, s);
  if (a.object == b.object) sample.force.written = glm::mix(a.force.written, b.force.written, s);
  return sample;
}

/// From a to b by the cubic whose ends are at right angles to the normals there, of any length: a straight path of length l
/// leaves a round surface of radius r by l^2 / 8 r. Straight on a plane, and where the normals are zero.
Vec3 alongSurface(Vec3 a, Vec3 normalAtA, Vec3 b, Vec3 normalAtB, double s) {
  const Vec3 chord = b - a;
  const auto bend = [&](Vec3 normal) {  // from the chord to the tangent
    const double length2 = squaredLength(normal);
    return length2 > 0 ? normal * (-glm::dot(normal, chord) / length2) : Vec3(0);
  };
  return a + s * chord + s * (1 - s) * ((1 - s) * bend(normalAtA) - s * bend(normalAtB));
}

/// Of the triangle that is touched, of any length, object frame: the sample's own normal is the shaded one. Zero: its mesh is
/// not here.
Vec3 normalAt(const MirrorView& view, const TelemetrySample& sample) {
  const SceneVersion::Object object = view.scene->find(sample.object);
  const auto corners = object ? view.cornersOf(*object, sample.primitive.polygon) : std::nullopt;
  return corners ? areaNormal(*corners) : Vec3(0);
}

bool isSameDent(const ObjectDent& a, const ObjectDent& b) {
  return a.object == b.object && a.dent.centre == b.dent.centre;
}

/// Dents of one place are the same dent. At most one moves, the contact's: what has no partner then goes over to what has
/// none, or comes and goes.
std::vector<ObjectDent> between(const std::vector<ObjectDent>& a, const std::vector<ObjectDent>& b, double s) {
  std::vector<ObjectDent> shown;
  std::vector<ObjectDent> ended;
  std::vector<ObjectDent> begun = b;
  const auto goOver = [&](const ObjectDent& dent, const auto& isNext) {
    const auto next = std::ranges::find_if(begun, isNext);
    if (next == begun.end()) return false;
    shown.push_back({dent.object,
                     {glm::mix(dent.dent.centre, next->dent.centre, static_cast<float>(s)),
                      glm::mix(dent.dent.displacement, next->dent.displacement, static_cast<float>(s))}});
    begun.erase(next);
    return true;
  };
  for (const ObjectDent& dent : a) {
    if (!goOver(dent, [&](const ObjectDent& other) { return isSameDent(other, dent); })) ended.push_back(dent);
  }
  for (const ObjectDent& dent : ended) {
    if (goOver(dent, [&](const ObjectDent& other) { return other.object == dent.object; })) continue;
    shown.push_back(dent);
    shown.back().dent.displacement *= static_cast<float>(1 - s);
  }
  for (const ObjectDent& dent : begun) {
    shown.push_back(dent);
    shown.back().dent.displacement *= static_cast<float>(s);
  }
  return shown;
}

/// Of the dents in the object none ends and none begins, and at most one moves, the contact's, and not far: between places
/// that are farther apart a surface that keeps dents may rise or fall by as much as a dent is deep.
bool isSameStroke(const MirrorView& a, const MirrorView& b, ObjectId id) {
  const auto notIn = [&](const std::vector<ObjectDent>& others, const std::vector<ObjectDent>& dents) {
    std::vector<Dent> left;
    for (const ObjectDent& dent : dents) {
      const auto isSame = [&](const ObjectDent& other) { return isSameDent(other, dent); };
      if (dent.object == id && std::ranges::none_of(others, isSame)) left.push_back(dent.dent);
    }
    return left;
  };
  const std::vector<Dent> ended = notIn(b.dents, a.dents), begun = notIn(a.dents, b.dents);
  if (ended.size() > 1 || ended.size() != begun.size()) return false;
  const SceneVersion::Object object = b.scene->find(id);
  if (ended.empty() || !object || !object->deformation.softness) return true;
  const Softness& softness = *object->deformation.softness;
  const double way_m = glm::distance(Vec3(ended.front().centre), Vec3(begun.front().centre));
  return softness.plastic == 0 || way_m < kLongestWay * softness.radius_m;
}

/// The view shown, at fraction s of the way from a's moment to b's.
class Interpolation {
 public:
  Interpolation(MirrorView& shown, const MirrorView& a, const MirrorView& b, double s)
      : shown_(shown), a_(a), b_(b), s_(s) {}

  void run() {
    for (auto& [object, body] : shown_.bodies) {
      const auto from = a_.bodies.find(object);
      const auto to = b_.bodies.find(object);
      const bool known = from != a_.bodies.end() && to != b_.bodies.end();
      if (known && !(from->second.pose == to->second.pose)) {
        body.pose = interpolate(from->second.pose, to->second.pose, s_);
      }
    }
    shown_.shapes = nearer().shapes;
    const bool firstHolds = holds(&MirrorView::sample), secondHolds = holds(&MirrorView::secondHand);
    shown_.dents = firstHolds && secondHolds ? between(a_.dents, b_.dents, s_) : nearer().dents;
    place(&MirrorView::sample, firstHolds);
    place(&MirrorView::secondHand, secondHolds);
  }

 private:
  using OfHand = std::optional<TelemetrySample> MirrorView::*;

  [[nodiscard]] const MirrorView& nearer() const { return s_ < 0.5 ? a_ : b_; }

  /// The hand goes on with the same contact, or there is no such hand.
  [[nodiscard]] bool holds(OfHand hand) const {
    const auto &a = a_.*hand, &b = b_.*hand;
    if (!a || !b) return !a && !b;
    return a->object == b->object && a->sceneRevision == b->sceneRevision && isSameStroke(a_, b_, a->object);
  }

  void place(OfHand hand, bool holds) const {
    if (!(a_.*hand) || !(b_.*hand)) {
      shown_.*hand = nearer().*hand;
      return;
    }
    TelemetrySample& sample = (shown_.*hand).emplace(between(*(a_.*hand), *(b_.*hand), s_));
    if (sample.object == 0) return;
    sample.ihip = contactPlace(hand, sample.object, &TelemetrySample::ihip, holds);
    sample.stickingPoint = contactPlace(hand, sample.object, &TelemetrySample::stickingPoint, holds);
  }

  /// Goes along with the object that is touched: on a flat side that turns away it stays on that side. Where a contact
  /// begins or ends, leaves a dent behind, or the scene becomes another, it stays, with the dents, as the nearer sample has it.
  [[nodiscard]] Vec3 contactPlace(OfHand hand, ObjectId object, Vec3 TelemetrySample::*place, bool holds) const {
    const auto in = [&](const MirrorView& view) {
      const auto body = view.bodies.find(object);
      return body == view.bodies.end() ? Pose{} : body->second.pose;
    };
    const auto local = [&](const MirrorView& view) { return toLocal(in(view), (*(view.*hand)).*place); };
    if (!holds) return toWorld(in(shown_), local(nearer()));
    const Vec3 normalAtA = normalAt(a_, *(a_.*hand)), normalAtB = normalAt(b_, *(b_.*hand));
    return toWorld(in(shown_), alongSurface(local(a_), normalAtA, local(b_), normalAtB, s_));
  }

  MirrorView& shown_;
  const MirrorView& a_;
  const MirrorView& b_;
  double s_;
};

/// Whether anything of the scene can change its place or shape by being touched.
bool anythingYields(const MirrorView& view) {
  return !view.bodies.empty() || !view.shapes.empty() ||
         std::ranges::any_of(view.scene->objects(), [](const SceneVersion::Object& object) {
           return object->deformation.softness.has_value();
         });
}

/// The servo felt an edit that is not here yet, which may have a dent that has ended in the sample.
bool isAhead(const MirrorView& view) {
  return view.sample->sceneRevision > view.scene->revision() &&
         std::ranges::any_of(view.scene->objects(), [](const SceneVersion::Object& object) {
           const auto& softness = object->deformation.softness;
           return softness && softness->plastic > 0;
         });
}

}  // namespace

std::shared_ptr<const MirrorView> Playback::at(View view, std::uint64_t now_ns) {
  if (!view->sample || !anythingYields(*view)) {
    past_.clear();
    return view;
  }
  const bool isHeld = isAhead(*view) && !past_.empty() && past_.back()->telemetryAgeAt_s(now_ns) < kLongestHold_s;
  if (!isHeld) remember(view);
  const MirrorView& newest = *past_.back();
  const double age_s = newest.telemetryAgeAt_s(now_ns);
  followAge(age_s, now_ns);
  const double moment_s = age_s - lag_s_;  // against the newest sample
  if (past_.size() < 2 || moment_s >= 0) return inStep(past_.back());

  const auto after =
      std::find_if(past_.begin() + 1, past_.end(), [&](const View& v) { return time_s(*v, newest) >= moment_s; });
  const MirrorView& a = **(after - 1);
  const MirrorView& b = **after;
  const double gap_s = time_s(b, a);
  const double passed = std::clamp((moment_s - time_s(a, newest)) / gap_s, 0.0, 1.0);
  const double s = gap_s > kLongestGap_s ? 1 : passed;
  auto shown = std::make_shared<MirrorView>(newest);
  shown->telemetryAge_s = lag_s_;
  shown->takenAt_ns = now_ns;
  Interpolation(*shown, a, b, s).run();
  return inStep(shown);
}

/// With the scene that the servo had adopted when it took the sample, as far as that is remembered.
Playback::View Playback::inStep(View shown) const {
  const auto isFelt = [&](const View& known) { return known->scene->revision() <= shown->sample->sceneRevision; };
  if (isFelt(shown) || ages_.back().age_s > kLongestHold_s) return shown;
  const auto felt = std::find_if(past_.rbegin(), past_.rend(), isFelt);
  if (felt == past_.rend()) return shown;
  auto before = std::make_shared<MirrorView>(*shown);
  before->scene = (*felt)->scene;
  before->meshes = (*felt)->meshes;
  before->fields = (*felt)->fields;
  before->vertexValues = (*felt)->vertexValues;
  before->pointFields = (*felt)->pointFields;
  before->movedVertices = (*felt)->movedVertices;
  return before;
}

void Playback::remember(const View& view) {
  constexpr std::size_t kKept = 16;
  if (!past_.empty()) {
    const MirrorView& last = *past_.back();
    if (last.epoch == view->epoch && last.sample->tick == view->sample->tick) {
      past_.back() = view;  // of the same moment, with what else is new
      return;
    }
    if (last.epoch != view->epoch || time_s(*view, last) <= 0) past_.clear();
  }
  past_.push_back(view);
  while (past_.size() > kKept || (past_.size() > 1 && keptAssets_bytes() > kMaxAssets_bytes)) past_.pop_front();
}

/// At most, as if views of different scenes had no asset in common.
std::size_t Playback::keptAssets_bytes() const {
  std::size_t bytes = 0;
  const SceneVersion* scene = nullptr;
  for (auto view = past_.rbegin(); view != past_.rend(); ++view) {
    if ((*view)->scene.get() != scene) bytes += (*view)->assetBytes;
    scene = (*view)->scene.get();
  }
  return bytes;
}

void Playback::followAge(double age_s, std::uint64_t now_ns) {
  const auto memory_ns = static_cast<std::uint64_t>(1e9 * kLagMemory_s);
  const double since_s = ages_.empty() ? 0 : 1e-9 * static_cast<double>(now_ns - ages_.back().when_ns);
  while (!ages_.empty() && now_ns - ages_.front().when_ns > memory_ns) ages_.pop_front();
  ages_.push_back({now_ns, age_s});
  const auto [freshest, oldest] = std::ranges::minmax(ages_, {}, &Age::age_s);
  lag_s_ = std::min(std::max(oldest.age_s, lag_s_ - kCatchUp * since_s), freshest.age_s + kMaxLag_s);
}

}  // namespace haptics
