#include "tests/eval/walk/walk.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/methods.h"
#include "tests/eval/random_motion.h"
#include "tests/eval/report.h"
#include "tests/eval/walk/random_walker.h"
#include "tests/eval/walk/reference_proxy.h"
#include "tests/eval/walk/walk_oracle.h"
#include "tests/eval/walk/walk_scenes.h"

namespace haptics::eval {
namespace {

/// Parts into which the reference, and the finer one that it is compared with, divide a tick.
constexpr int kParts = 64;
constexpr int kFinerParts = 512;
/// Of the mean edge: farther apart than this is elsewhere.
constexpr double kElsewhere = 0.02;
/// Of elsewhere: a reference that leaps no farther keeps to its minimum.
constexpr double kLeap = 1.0 / 16;
/// What is allowed of episodes: a number of times those of the reference with itself, and some in a tick.
constexpr double kOfReference = 2;
constexpr double kInATick = 5e-6;
/// Of the ticks: in as many the contact may wait for the next tick's allowance.
constexpr double kMaxWaiting = 5e-3;
/// More than there are: no two scenes of two seeds share their random numbers.
constexpr std::uint64_t kMaxScenes = 64;

struct Counts {
  std::int64_t ticks = 0;
  std::int64_t contact = 0;
  std::int64_t notFinite = 0;
  std::int64_t inside = 0;
  std::int64_t insideOnce = 0;  ///< Judged by winding number: for one tick, as what is put out of a body is.
  std::int64_t heldByNothing = 0;
  std::int64_t lost = 0;
  std::int64_t waiting = 0;  ///< With the rest of the HIP's path left to the next tick: where no reference waits.
  std::int64_t episodes = 0;
  std::int64_t notMinima = 0;
  std::int64_t referenceEpisodes = 0;  ///< Of the reference with the finer one.
  Record why = Record::object();       ///< Of a method from outside that was not put through: runOrExplain().

  [[nodiscard]] double episodesInATick() const { return ratio(episodes, ticks); }
  [[nodiscard]] double referenceEpisodesInATick() const { return ratio(referenceEpisodes, ticks); }
  [[nodiscard]] double allowedInATick() const { return kOfReference * referenceEpisodesInATick() + kInATick; }
  [[nodiscard]] bool pass() const {
    return !why.contains("fault") && notFinite + inside + heldByNothing + lost + notMinima == 0 &&
           episodesInATick() <= allowedInATick() && ratio(waiting, ticks) <= kMaxWaiting;
  }
  Counts& operator+=(const Counts& other) {
    ticks += other.ticks;
    contact += other.contact;
    notFinite += other.notFinite;
    inside += other.inside;
    insideOnce += other.insideOnce;
    heldByNothing += other.heldByNothing;
    lost += other.lost;
    waiting += other.waiting;
    episodes += other.episodes;
    notMinima += other.notMinima;
    referenceEpisodes += other.referenceEpisodes;
    return *this;
  }

 private:
  static double ratio(std::int64_t part, std::int64_t whole) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::int64_t>(whole, 1));
  }
};

/// A method, a HIP and the judges in one scene.
class Walk {
 public:
  Walk(const WalkScene& scene, Renderer& method, Random random, std::string& episodes)
      : scene_(scene),
        method_(method),
        wanderer_(scene.soup, random),
        judge_(scene.soup),
        reference_(scene.soup),
        finer_(scene.soup),
        elsewhere_(kElsewhere * scene.soup.meanEdge_m()),
        hip_(wanderer_.hip()),
        felt_{false, hip_, Vec3(0), 0},
        episodes_(episodes) {
    method_.begin(scene.surfaces, scene.poses, hip_);
    reference_.place(hip_);
  }

  void tick() {
    const Vec3 before = hip_;
    const Vec3 ihipBefore = felt_.ihip;
    hip_ = wanderer_.next();
    felt_ = method_.tick(scene_.poses, hip_);
    ++counts_.ticks;
    if (!isFinite(felt_.ihip) || !isFinite(felt_.force_N)) {
      ++counts_.notFinite;
      method_.place(hip_);
      felt_ = {false, hip_, Vec3(0), 0};
    }
    counts_.contact += felt_.touching ? 1 : 0;
    counts_.inside += judge_.isInside(felt_.ihip) ? 1 : 0;
    if (felt_.followed) {
      ++counts_.waiting;
      reference_.resume(felt_.ihip, *felt_.followed);
      return;
    }
    counts_.heldByNothing += felt_.touching && judge_.isHeldByNothing(felt_.ihip, hip_) ? 1 : 0;
    finer_ = reference_;
    reference_.follow(hip_, kParts);
    compareReferences();
    if (glm::distance(felt_.ihip, reference_.ihip()) > elsewhere_) episode(before, ihipBefore);
  }

  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  /// Where the reference has left no minimum a finer division of the tick finds the same place: it is spared.
  void compareReferences() {
    if (reference_.leap_m() < kLeap * elsewhere_) return;
    finer_.follow(hip_, kFinerParts);
    if (glm::distance(finer_.ihip(), reference_.ihip()) > elsewhere_) ++counts_.referenceEpisodes;
  }

  void episode(Vec3 before, Vec3 ihipBefore) {
    ++counts_.episodes;
    const bool minimum = !felt_.touching || judge_.isLocalMinimum(felt_.ihip, hip_, elsewhere_);
    const bool lost = !felt_.touching && holds(before, ihipBefore, kParts) && holds(before, ihipBefore, kFinerParts);
    counts_.notMinima += minimum ? 0 : 1;
    counts_.lost += lost ? 1 : 0;
    const Vec3 other = reference_.ihip();
    char line[512];
    std::snprintf(
        line, sizeof line, "%s,%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.9g,%.9g,%.9g,%d,%d\n",
        scene_.name.c_str(), static_cast<long long>(counts_.ticks), hip_.x, hip_.y, hip_.z, felt_.ihip.x, felt_.ihip.y,
        felt_.ihip.z, other.x, other.y, other.z, glm::distance(felt_.ihip, other) * 1e3,
        glm::distance(felt_.ihip, hip_) * 1e3, glm::distance(other, hip_) * 1e3, minimum ? 1 : 0, lost ? 1 : 0);
    episodes_ += line;
    reference_.resume(felt_.ihip, hip_);
  }

  /// Would the reference, from where the method was a tick ago, hold now?
  [[nodiscard]] bool holds(Vec3 before, Vec3 ihipBefore, int parts) const {
    ReferenceProxy proxy(scene_.soup);
    proxy.resume(ihipBefore, before);
    proxy.follow(hip_, parts);
    return glm::distance(proxy.ihip(), hip_) > elsewhere_;
  }

  const WalkScene& scene_;
  Renderer& method_;
  RandomWalker wanderer_;
  WalkOracle judge_;
  ReferenceProxy reference_;
  ReferenceProxy finer_;
  double elsewhere_;  // m
  Vec3 hip_;
  Felt felt_;
  std::string& episodes_;
  Counts counts_;
};

/// Without the reference: bodies in random motion, each for a while.
Counts walkAmongRandomMotion(const std::string& scene, Renderer& method, Random random, std::int64_t ticks) {
  constexpr std::int64_t kTicksEach = 5000;
  MotionCounts seen;
  int number = 0;
  for (std::int64_t left = ticks; left > 0; left -= kTicksEach) {
    const Random own(static_cast<std::uint64_t>(random.below(1 << 30)));
    const auto motion = scene == "crushed" ? makeCrushed(own) : makeFolded(own, foldedCase(number++ % kFoldedCases));
    leadThrough(method, *motion, static_cast<int>(std::min(left, kTicksEach)), random, seen);
  }
  Counts counts;
  counts.ticks = seen.ticks;
  counts.contact = seen.contact;
  counts.notFinite = seen.notFinite;
  counts.inside = seen.inside.all() - seen.inside.single();
  counts.insideOnce = seen.inside.single();
  return counts;
}

Counts walkOver(const WalkSceneSource& source, Renderer& method, Random random, std::int64_t ticks,
                std::string& episodes) {
  if (source.winding) return walkAmongRandomMotion(source.name, method, random, ticks);
  const WalkScene scene = makeWalkScene(source, random);
  Walk walk(scene, method, random, episodes);
  for (std::int64_t tick = 0; tick < ticks; ++tick) walk.tick();
  return walk.counts();
}

/// What recordOf() tells.
Counts countsOf(const Record& r) {
  return {.ticks = r.at("ticks"),
          .contact = r.at("contact_ticks"),
          .notFinite = r.at("not_finite_ticks"),
          .inside = r.at("inside_ticks"),
          .insideOnce = r.at("inside_single_ticks"),
          .heldByNothing = r.at("wrong_side_ticks"),
          .lost = r.at("lost_contacts"),
          .waiting = r.at("waiting_ticks"),
          .episodes = r.at("episodes"),
          .notMinima = r.at("episodes_not_local_minima"),
          .referenceEpisodes = r.at("reference_episodes"),
          .why = r.value("why", Record::object())};
}

Record recordOf(const std::string& method, const std::string& scene, std::uint64_t seed, const Counts& c) {
  constexpr double kMillion = 1e6;
  Record record{{"method", method},
                {"scene", scene},
                {"seed", seed},
                {"ticks", c.ticks},
                {"contact_ticks", c.contact},
                {"not_finite_ticks", c.notFinite},
                {"inside_ticks", c.inside},
                {"inside_single_ticks", c.insideOnce},
                {"wrong_side_ticks", c.heldByNothing},
                {"lost_contacts", c.lost},
                {"waiting_ticks", c.waiting},
                {"episodes", c.episodes},
                {"episodes_not_local_minima", c.notMinima},
                {"episodes_per_1e6_ticks", c.episodesInATick() * kMillion},
                {"reference_episodes", c.referenceEpisodes},
                {"reference_episodes_per_1e6_ticks", c.referenceEpisodesInATick() * kMillion},
                {"allowed_episodes_per_1e6_ticks", c.allowedInATick() * kMillion},
                {"pass", c.pass()}};
  if (!c.why.empty()) record.update({{"why", c.why}, {"pass", c.why.at("pass")}});
  return record;
}

void printHead() {
  std::printf("%-20s %9s %9s %4s %7s %6s %5s %7s %9s %7s %10s %10s %10s\n", "scene", "ticks", "contact", "NaN",
              "inside", "wrong", "lost", "waiting", "episodes", "not", "per 1e6", "reference", "allowed");
  std::printf("%-20s %9s %9s %4s %7s %6s %5s %7s %9s %7s %10s %10s %10s\n", "", "", "", "", "", "side", "", "", "",
              "minima", "ticks", "to itself", "");
}

void printRow(const std::string& scene, const Counts& c) {
  const auto n = [](std::int64_t x) { return static_cast<long long>(x); };
  std::printf("%-20s %9lld %9lld %4lld %7lld %6lld %5lld %7lld %9lld %7lld %10.1f %10.1f %10.1f  %s\n", scene.c_str(),
              n(c.ticks), n(c.contact), n(c.notFinite), n(c.inside), n(c.heldByNothing), n(c.lost), n(c.waiting),
              n(c.episodes), n(c.notMinima), c.episodesInATick() * 1e6, c.referenceEpisodesInATick() * 1e6,
              c.allowedInATick() * 1e6, c.pass() ? "pass" : "FAIL");
  std::fflush(stdout);
}

/// A part is a scene.
class WalkSweep : public Sweep {
 public:
  WalkSweep(const WalkOptions& options, std::filesystem::path out)
      : options_(options),
        out_(std::move(out)),
        method_(findMethod(options.method, methods())),
        sources_(chosenWalkScenes(options.models, options.scene)) {
    if (options.ticks < static_cast<std::int64_t>(sources_.size()))
      throw std::invalid_argument("--ticks: give at least " + std::to_string(sources_.size()) + ", one for each scene");
  }

  [[nodiscard]] std::size_t size() const override { return sources_.size(); }

  [[nodiscard]] Record run(std::size_t part) override {
    const WalkSceneSource& source = sources_[part];
    const Random random(options_.seed * kMaxScenes + source.number);
    std::string episodes;
    const std::int64_t ticks = options_.ticks / static_cast<std::int64_t>(sources_.size());
    Counts counts;
    runOrExplain(counts.why, [&] { counts = walkOver(source, *method_.make(), random, ticks, episodes); });
    return {{"record", recordOf(std::string(method_.name), source.name, options_.seed, counts)},
            {"episodes", episodes}};
  }

  void print(std::size_t part, const Record& result) override {
    if (part == 0) printHead();
    const Counts counts = countsOf(result.at("record"));
    if (counts.why.empty()) return printRow(sources_[part].name, counts);
    std::printf("%-20s %s\n", sources_[part].name.c_str(), measuresText(counts.why).c_str());
  }

  [[nodiscard]] bool finish(const std::vector<Record>& results) override {
    std::ofstream episodes(out_ / "walk_episodes.csv");
    episodes << "scene,tick,hip_x_m,hip_y_m,hip_z_m,ihip_x_m,ihip_y_m,ihip_z_m,reference_x_m,reference_y_m,"
                "reference_z_m,apart_mm,depth_mm,reference_depth_mm,local_minimum,lost\n";
    std::vector<Record> records;
    Counts all;
    bool pass = true;
    for (const Record& result : results) {
      records.push_back(result.at("record"));
      const Counts counts = countsOf(records.back());
      all += counts;
      pass = pass && counts.pass();
      episodes << result.at("episodes").get_ref<const std::string&>();
    }
    episodes.close();
    if (!episodes) throw std::runtime_error((out_ / "walk_episodes.csv").string() + ": cannot be written");
    printRow("all", all);
    records.push_back(recordOf(std::string(method_.name), "all", options_.seed, all));
    writeRecords(out_, "walk", records);
    return pass;
  }

 private:
  WalkOptions options_;
  std::filesystem::path out_;
  const Method& method_;
  std::vector<WalkSceneSource> sources_;
};

}  // namespace

std::unique_ptr<Sweep> makeWalkSweep(const WalkOptions& options, const std::filesystem::path& out) {
  return std::make_unique<WalkSweep>(options, out);
}

}  // namespace haptics::eval
