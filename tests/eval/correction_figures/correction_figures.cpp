#include "tests/eval/correction_figures/correction_figures.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>

#include "tests/eval/correction_figures/ablations.h"
#include "tests/eval/correction_figures/section.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

using Look = SideBySide::Look;

/// Keeps the ticks about the one with the highest score, the first of equals; none of a score of 0.
class Best {
 public:
  /// Of the newest tick.
  using Score = std::function<double(const Trace& now, const Trace& before)>;

  Best(Score score, std::size_t before, std::size_t after) : score_(std::move(score)), before_(before), after_(after) {}

  void look(const Trace& now, const Trace& before) {
    const bool goesOn = moment_ && left_ > 0 && now.ticks.size() == seen_ + 1;
    seen_ = now.ticks.size();
    const double score = score_(now, before);
    if (score > best_) {
      best_ = score;
      left_ = after_;
      const std::size_t from = seen_ - std::min(seen_, before_ + 1);
      moment_ = Moment{{now.bodies, {now.ticks.begin() + static_cast<std::ptrdiff_t>(from), now.ticks.end()}}, 0, {}};
      moment_->event = moment_->trace.ticks.size() - 1;
      for (const TracedTick& tick : before.ticks) moment_->slow.push_back(toLocal(tick.poses[0], tick.with.ihip));
    } else if (goesOn) {
      moment_->trace.ticks.push_back(now.ticks.back());
      --left_;
    } else {
      left_ = 0;
    }
  }
  [[nodiscard]] const std::optional<Moment>& moment() const { return moment_; }

 private:
  Score score_;
  std::size_t before_, after_;
  double best_ = 0;
  std::size_t left_ = 0;
  std::size_t seen_ = 0;
  std::optional<Moment> moment_;
};

void play(const FailureScene& scene, std::uint64_t seed, std::string_view method, Look look) {
  SideBySide both(makeAblation(method), makeAblation("ours"), std::move(look));
  Random random = scene.random(seed);
  (void)scene.run(both, random);
}

double apart_m(const TracedTick& tick) { return glm::distance(tick.without.ihip, tick.with.ihip); }
bool isMissed(const TracedTick& tick) { return tick.with.touching && !tick.without.touching; }

/// Of what the HIP moves in the frame of the first body, m.
double step_m(const Trace& trace) {
  if (trace.ticks.size() < 2) return 0;
  const TracedTick& last = trace.ticks.back();
  const TracedTick& previous = trace.ticks[trace.ticks.size() - 2];
  return glm::distance(toLocal(last.poses[0], last.hip), toLocal(previous.poses[0], previous.hip));
}

struct SectionSpec {
  Cut cut;
  std::size_t before, after;  // ticks
  Best::Score score;
  double offset_m = 0;
  bool slow = false;  // the trace before is a slow hand's
};

struct Illustration {
  std::string_view method;
  FailureScene scene;  // about: what the picture shows of it
  Record (*describe)(const FailureScene& scene, std::uint64_t seed, std::string_view method);
};

void mustFail(bool fails, std::string_view method) {
  if (!fails) throw std::runtime_error(std::string(method) + " does not fail with this seed");
}

Record describeMoment(const FailureScene& scene, std::uint64_t seed, std::string_view method, const SectionSpec& spec) {
  Best best(spec.score, spec.before, spec.after);
  play(scene, seed, method, [&](const Trace& now, const Trace& before) { best.look(now, before); });
  mustFail(best.moment().has_value(), method);
  Moment moment = *best.moment();
  if (!spec.slow) moment.slow.clear();
  return describeSection(moment, spec.cut, spec.offset_m);
}

/// Whether the two methods are farther apart than this.
Best::Score apartBy(double metres) {
  return [=](const Trace& now, const Trace&) { return apart_m(now.ticks.back()) > metres ? 1.0 : 0.0; };
}
Best::Score missed(double minStep_m) {
  return [=](const Trace& now, const Trace&) {
    return isMissed(now.ticks.back()) && step_m(now) >= minStep_m ? 1.0 : 0.0;
  };
}

Record leaveCube(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  return describeMoment(scene, seed, method, {Cut::kUpright, 75, 35, apartBy(0.03)});
}
Record leaveGash(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  constexpr std::size_t kLong = 6;
  const auto score = [](const Trace& now, const Trace&) {
    if (now.bodies.size() != 1 || now.ticks.size() < kLong) return 0.0;
    const bool isOut = apart_m(now.ticks.back()) > 0.0005 && apart_m(now.ticks[now.ticks.size() - kLong]) > 0.0005;
    return isOut ? 1.0 : 0.0;
  };
  return describeMoment(scene, seed, method, {Cut::kAcross, 14, 0, score});
}
Record enterComb(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  return describeMoment(scene, seed, method, {Cut::kAcross, 1, 22, missed(0)});
}
Record crossGap(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  return describeMoment(scene, seed, method, {Cut::kAcross, 5, 8, missed(0)});
}
Record riseThroughHip(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  return describeMoment(scene, seed, method, {Cut::kAcross, 4, 10, missed(0.9e-3)});
}
Record enterBox(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  const auto score = [](const Trace& now, const Trace&) {
    const TracedTick& last = now.ticks.back();
    return apart_m(last) > 0.001 && depthInside(now, last, last.without.ihip) > 1e-4 ? 1.0 : 0.0;
  };
  return describeMoment(scene, seed, method, {Cut::kUpright, 20, 20, score});
}
Record slideAlongBox(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  return describeMoment(scene, seed, method, {Cut::kFromAbove, 70, 30, apartBy(0.004), 0.001});
}
Record strokeHills(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  const auto score = [](const Trace& now, const Trace& before) {
    const bool isFast = now.ticks.size() == 8 && before.ticks.size() == 512;
    return isFast && apart_m(now.ticks.back()) > 0.002 ? 1.0 : 0.0;
  };
  return describeMoment(scene, seed, method, {Cut::kRadial, 6, 0, score, 0, true});
}
Record crush(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  constexpr std::size_t kLong = 20;
  const auto score = [](const Trace& now, const Trace&) {
    if (now.ticks.size() < kLong) return 0.0;
    const auto inside = [&](const TracedTick& tick) { return depthInside(now, tick, tick.without.ihip); };
    const TracedTick& last = now.ticks.back();
    const TracedTick& first = now.ticks[now.ticks.size() - kLong];
    if (apart_m(last) < 0.003 || inside(last) < 0.002 || inside(first) < 1e-6) return 0.0;
    return depthInside(now, last, last.with.ihip) < 1e-6 ? 1.0 : 0.0;
  };
  return describeMoment(scene, seed, method, {Cut::kThroughBoth, 0, 0, score});
}

/// The values of each tick.
struct Curves {
  std::vector<double> without, with;
};

Record describeCurves(const Curves& curves, const char* meaning, const char* unit, std::string_view method) {
  mustFail(curves.without != curves.with, method);
  return {{"kind", "values"},
          {"meaning", meaning},
          {"unit", unit},
          {"panels", {Record{{"values", curves.without}}, Record{{"values", curves.with}}}}};
}

/// Triangles that the searches look at in a tick.
Record countTriangles(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  const auto score = [](const Trace& now, const Trace&) {
    return static_cast<double>(now.ticks.back().without.triangles);
  };
  Best best(score, 20, 20);
  play(scene, seed, method, [&](const Trace& now, const Trace& before) { best.look(now, before); });
  Curves curves;
  for (const TracedTick& tick : best.moment()->trace.ticks) {
    curves.without.push_back(tick.without.triangles);
    curves.with.push_back(tick.with.triangles);
  }
  return describeCurves(curves, "triangles that the searches look at, by tick", "", method);
}

/// The IHIP of the walk over two bodies at a scale of 2^-10, in units of the scene, beside that at a scale of 1.
Record compareScales(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  constexpr std::size_t kTicks = 600;
  std::vector<Trace> walks;
  play(scene, seed, method, [&](const Trace& now, const Trace&) {
    if (now.bodies.size() == 2 && now.ticks.size() == kTicks) walks.push_back(now);
  });
  const double scale = walks.at(1).bodies[0]->extent_m() / walks.at(0).bodies[0]->extent_m();
  Curves curves;
  for (std::size_t i = 0; i < kTicks; ++i) {
    const TracedTick& once = walks[0].ticks[i];
    const TracedTick& small = walks[1].ticks[i];
    const auto apart_um = [&](const Felt& a, const Felt& b) { return 1e6 * glm::distance(a.ihip, b.ihip / scale); };
    curves.without.push_back(apart_um(once.without, small.without));
    curves.with.push_back(apart_um(once.with, small.with));
  }
  return describeCurves(curves, "distance between the two IHIPs at full size, by tick", "um", method);
}

/// The force along the floor in a slide over it, which ought to be none.
Record forceAlongFloor(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  constexpr double kNothing_m = 1e-4;  // more is of the box
  Curves curves;
  const auto along_uN = [](const TracedTick& tick, const Felt& felt) {
    const Vec3 spring = glm::conjugate(tick.poses[0].rotation) * (felt.ihip - tick.hip);
    return 1e6 * kSpring_N_per_m * std::hypot(spring.x, spring.y);
  };
  bool done = false;
  play(scene, seed, method, [&](const Trace& now, const Trace&) {
    const TracedTick& tick = now.ticks.back();
    done = done || along_uN(tick, tick.with) > 1e6 * kSpring_N_per_m * kNothing_m;
    if (done || !tick.with.touching) return;
    curves.without.push_back(along_uN(tick, tick.without));
    curves.with.push_back(along_uN(tick, tick.with));
  });
  return describeCurves(curves, "force along the floor, which has no friction, by tick", "uN", method);
}

/// Segments between two ticks that enter a mesh, and are not seen to.
Record loseSegments(const FailureScene& scene, std::uint64_t seed, std::string_view method) {
  constexpr int kMaxSegments = 10'000;
  std::shared_ptr<const CollisionMesh> mesh;
  std::vector<Vec3> without, with;
  int segments = 0;
  play(scene, seed, method, [&](const Trace& now, const Trace&) {
    if (!mesh) mesh = now.bodies[0];
    if (now.bodies[0] != mesh || ++segments > kMaxSegments) return;
    const TracedTick& tick = now.ticks.back();
    int spent = 0;
    const Vec3 place = mesh->closestFoot(tick.hip, static_cast<int>(mesh->triangleCount()) + 1, spent).point;
    if (!tick.without.touching) without.push_back(place);
    if (!tick.with.touching) with.push_back(place);
  });
  mustFail(!without.empty(), method);
  return describePlaces(*mesh, without, with);
}

constexpr std::array kIllustrations{
    Illustration{"ours_without_feature_codes",
                 {"S1", "The HIP slides 2 mm below the top of a cube, and off it.", slideOffCube},
                 leaveCube},
    Illustration{"ours_without_pseudonormals",
                 {"S12", "The HIP goes about below the bottom of a narrow gash.", strokeSharpAndScaledShapes},
                 leaveGash},
    Illustration{"ours_without_same_tick_search",
                 {"S3", "The HIP crosses the teeth of a comb, 1 mm a tick.", crossComb},
                 enterComb},
    Illustration{
        "ours_without_exit_retest", {"S3", "The HIP crosses the teeth of a comb, 1 mm a tick.", crossComb}, crossGap},
    Illustration{"ours_without_object_frames",
                 {"S4", "A box rises at 1 m/s over a HIP at rest; drawn in the frame of the box.", moveThroughStillHip},
                 riseThroughHip},
    Illustration{"ours_without_watertight_test",
                 {"S5", "10,000 segments are aimed at vertices and edges of this sphere.", aimAtVerticesAndEdges},
                 loseSegments},
    Illustration{"ours_without_guard",
                 {"S2", "The HIP slides 3 mm below a floor, towards a box that stands on it.", slideIntoBox},
                 enterBox},
    Illustration{
        "ours_without_several_surfaces",
        {"S2", "The HIP slides below a floor and inside of a box that stands on it; seen from above.", slideIntoBox},
        slideAlongBox},
    Illustration{"ours_without_substeps",
                 {"S7", "The HIP is led below hills at 5 m/s, 5 mm a tick.", runDeepAndFast},
                 strokeHills},
    Illustration{
        "ours_without_budget", {"S6", "The HIP passes below a vertex of 4,096 triangles.", strokeFans}, countTriangles},
    Illustration{"ours_without_scale_free_tolerances",
                 {"S12", "The same walk about two bodies, at full size and with all lengths divided by 1,024.",
                  strokeSharpAndScaledShapes},
                 compareScales},
    Illustration{
        "ours_without_containment", {"S31", "Boxes have closed on the IHIP from all sides.", crushBetweenBoxes}, crush},
    Illustration{"ours_float", {"S2", "The HIP slides 3 mm below a floor.", slideIntoBox}, forceAlongFloor},
};

}  // namespace

void drawCorrections(std::uint64_t seed, std::string_view method, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::string known;
  int drawn = 0;
  for (const Illustration& illustration : kIllustrations) {
    known += (known.empty() ? "" : ", ") + std::string(illustration.method);
    if (!method.empty() && illustration.method != method) continue;
    Record figure = illustration.describe(illustration.scene, seed, illustration.method);
    figure["title"] = std::string(illustration.scene.name) + ": " + std::string(illustration.scene.about);
    figure["panels"][0]["heading"] = illustration.method;
    figure["panels"][1]["heading"] = "ours";
    std::string_view name = illustration.method;
    for (const std::string_view prefix : {"ours_", "without_"}) {
      if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
    }
    const std::filesystem::path stem = folder / name;
    drawFigure("correction", figure, stem);
    std::printf("%s.png\n", stem.c_str());
    ++drawn;
  }
  if (drawn == 0) {
    throw std::invalid_argument("--method: there is no picture of " + std::string(method) + "; there are those of " +
                                known);
  }
}

}  // namespace haptics::eval
